"""Who is ahead where, in words: by success, and among equals by the time to the goal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import count, finite, show
from pytest_lpb.report.view import PlannerStyle, Winner

SUCCESS, TIME = "success", "time_to_goal_s"
OPPOSITE = {"better": "worse", "worse": "better"}
Rows = Mapping[str, Mapping[Any, Any]]  # of the summary, by planner


def winners(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[Winner]:
    """One per scenario where at least two planners ran."""
    verdicts = _Verdicts(data)
    found = []
    for scenario in dict.fromkeys(data.trials["scenario"]):
        rows = data.summary[data.summary["scenario"] == scenario].to_dict("records")
        by_planner = {str(row["planner"]): row for row in rows if finite(row["success_rate"]) is not None}
        if len(by_planner) > 1:
            found.append(_winner(str(scenario), by_planner, verdicts, styles))
    return found


def winners_summary(found: Sequence[Winner], styles: Mapping[str, PlannerStyle]) -> str:
    """In how many scenarios each planner is ahead alone, and how often a test decided so."""
    if not found:
        return ""
    alone = [winner for winner in found if len(winner.styles) == 1]
    wins = Counter(winner.styles[0].name for winner in alone)
    decided = Counter(winner.styles[0].name for winner in alone if winner.decided)
    parts = [
        f"{name} is ahead in {wins[name]}{f' ({decided[name]} decided)' if decided[name] else ''}"
        for name in sorted(styles, key=lambda name: -wins[name])
        if wins[name]
    ]
    ties = sum(len(winner.styles) > 1 for winner in found)
    nobody = sum(not winner.styles for winner in found)
    parts += [f"{ties} tied"] if ties else []
    parts += [f"{nobody} solved by nobody"] if nobody else []
    return f"Of {count(len(found), 'scenario')}: {', '.join(parts)}."


class _Verdicts:
    """What comparisons.csv says of two planners, whichever comes first there."""

    def __init__(self, data: ReportData) -> None:
        wanted = data.comparisons[data.comparisons["kpi"].isin([SUCCESS, TIME])]
        self._found = {
            (row["planner_a"], row["planner_b"], str(row["scenario"]), row["kpi"]): str(row["verdict"])
            for row in wanted.to_dict("records")
        }

    def better(self, planner: str, other: str, scenario: str, kpi: str) -> bool:
        """Whether a test says that a planner is better than another."""
        about_planner = self._found.get((other, planner, scenario, kpi))
        about_other = self._found.get((planner, other, scenario, kpi), "")
        return (about_planner or OPPOSITE.get(about_other)) == "better"


def _winner(scenario: str, rows: Rows, verdicts: _Verdicts, styles: Mapping[str, PlannerStyle]) -> Winner:
    rates = {name: float(row["success_rate"]) for name, row in rows.items()}
    best = max(rates.values())
    if best == 0.0:
        return Winner(scenario, (), "nobody solved a problem", decided=False)
    leaders = [name for name in styles if rates.get(name) == best]
    if len(leaders) > 1:
        return _among_equals(scenario, leaders, rows, verdicts, styles)
    leader = leaders[0]
    second = max((name for name in rates if name != leader), key=lambda name: rates[name])
    decided = all(verdicts.better(leader, other, scenario, SUCCESS) for other in rates if other != leader)
    text = f"solves {_share(rows[leader])}, {second} {_share(rows[second])}"
    return Winner(scenario, (styles[leader],), text, decided)


def _among_equals(
    scenario: str, leaders: list[str], rows: Rows, verdicts: _Verdicts, styles: Mapping[str, PlannerStyle]
) -> Winner:
    """The fastest of planners with the same success where a test says so; else all of them."""
    for name in leaders:
        others = [other for other in leaders if other != name]
        if all(verdicts.better(name, other, scenario, TIME) for other in others):
            times = {other: finite(rows[other].get(f"{TIME}_median")) for other in leaders}
            next_best = min(others, key=lambda other: times[other] or 0.0)
            text = f"as successful, at the goal after {show(times[name])} s, {next_best} {show(times[next_best])} s"
            return Winner(scenario, (styles[name],), text, decided=True)
    text = f"each solves {_share(rows[leaders[0]])}"
    return Winner(scenario, [styles[name] for name in leaders], text, decided=False)


def _share(row: Mapping[Any, Any]) -> str:
    return f"{int(row['successes'])} of {int(row['trials'])}"
