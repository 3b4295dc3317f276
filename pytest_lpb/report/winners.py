"""Who is ahead where, by one rule: what the tests of comparisons.csv decide, success before time to the goal.

A planner beats another where the verdict on success says better; where that verdict does not decide between them, where
the verdict on time to the goal (failures count the duration) does. It is ahead where it beats every other. Otherwise it
is undecided between those that nobody beats, or equal where all their verdicts say `same`. Point estimates decide
nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import count, finite, show
from pytest_lpb.report.titles import RESTRICTED
from pytest_lpb.report.view import PlannerStyle, Winner
from pytest_lpb.run.summary import ALL
from pytest_lpb.run.verdict import BETTER, DECIDABLE_PAIRS, SAME, WORSE

SUCCESS, TIME = "success", "time_to_goal_s"
MIRRORED = {BETTER: WORSE, WORSE: BETTER}
AHEAD, EQUAL, UNDECIDED, NOBODY = "ahead", "equal", "undecided", "nobody"
Rows = Mapping[str, Mapping[Any, Any]]  # of the summary, by planner


def winners(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[Winner]:
    """One per scenario where at least two planners ran, then one over all scenarios where there are several."""
    verdicts = _Verdicts(data)
    found = []
    scenarios = [str(name) for name in dict.fromkeys(data.trials["scenario"])]
    for scenario in [*scenarios, ALL] if len(scenarios) > 1 else scenarios:
        rows = data.summary[data.summary["scenario"] == scenario].to_dict("records")
        by_planner = {str(row["planner"]): row for row in rows if finite(row["success_rate"]) is not None}
        if len(by_planner) > 1:
            found.append(_winner(scenario, by_planner, verdicts, styles))
    return found


def winners_summary(found: Sequence[Winner], styles: Mapping[str, PlannerStyle]) -> str:
    """In how many scenarios each planner is ahead, and how many are undecided; then all scenarios together."""
    single = [winner for winner in found if winner.scenario != ALL]
    if not single:
        return ""
    wins = Counter(winner.styles[0].name for winner in single if winner.standing == AHEAD)
    parts = [f"{name} is ahead in {wins[name]}" for name in sorted(styles, key=lambda name: -wins[name]) if wins[name]]
    for standing, words in ((EQUAL, "equal"), (UNDECIDED, "undecided"), (NOBODY, "solved by nobody")):
        number = sum(winner.standing == standing for winner in single)
        parts += [f"{number} {words}"] if number else []
    together = "".join(f" Over all of them: {_sentence(winner)}." for winner in found if winner.scenario == ALL)
    return f"Of {count(len(single), 'scenario')}: {', '.join(parts)}.{together}"


def _sentence(winner: Winner) -> str:
    names = [style.name for style in winner.styles]
    if winner.standing == AHEAD:
        return f"{names[0]} is ahead ({winner.text})"
    return winner.text if winner.standing == NOBODY else f"{winner.standing} between {_and(names)}"


class _Verdicts:
    """What comparisons.csv says of two planners, whichever comes first there."""

    def __init__(self, data: ReportData) -> None:
        wanted = data.comparisons[data.comparisons["kpi"].isin([SUCCESS, TIME])]
        self._found = {
            (row["planner_a"], row["planner_b"], str(row["scenario"]), row["kpi"]): row
            for row in wanted.to_dict("records")
        }

    def of(self, planner: str, other: str, scenario: str, kpi: str) -> str:
        """The verdict on a planner against another; empty without one."""
        about_planner = self._found.get((other, planner, scenario, kpi))
        if about_planner is not None:
            return str(about_planner["verdict"])
        about_other = str(self._found.get((planner, other, scenario, kpi), {}).get("verdict", ""))
        return MIRRORED.get(about_other, about_other)

    def decisive(self, planner: str, other: str, scenario: str) -> str:
        """By which of the two a planner beats another, success first; empty where it does not."""
        success = self.of(planner, other, scenario, SUCCESS)
        if success in MIRRORED:
            return SUCCESS if success == BETTER else ""
        return TIME if self.of(planner, other, scenario, TIME) == BETTER else ""

    def difference(self, planner: str, other: str, scenario: str) -> float | None:
        """By how much a planner's time to the goal differs from another's [s], failures counting the duration."""
        about_planner = self._found.get((other, planner, scenario, TIME))
        if about_planner is not None:
            return finite(about_planner["difference"])
        about_other = finite(self._found[planner, other, scenario, TIME]["difference"])
        return None if about_other is None else -about_other

    def same(self, planner: str, other: str, scenario: str) -> bool:
        """Whether two planners are equal in both."""
        return all(self.of(planner, other, scenario, kpi) == SAME for kpi in (SUCCESS, TIME))

    def pairs(self, scenario: str) -> int:
        """Most problems that two planners share."""
        found = [int(row.get("pairs", 0)) for (_, _, name, _), row in self._found.items() if name == scenario]
        return max(found, default=0)


def _winner(scenario: str, rows: Rows, verdicts: _Verdicts, styles: Mapping[str, PlannerStyle]) -> Winner:
    if not any(int(row["successes"]) for row in rows.values()):
        return Winner(scenario, (), "nobody solved a problem", NOBODY)
    names = [name for name in styles if name in rows]
    beaten = {name: {other for other in names if verdicts.decisive(name, other, scenario)} for name in names}
    for name in names:
        others = [other for other in names if other != name]
        if beaten[name] == set(others):
            return Winner(scenario, (styles[name],), _how(name, others, scenario, verdicts), AHEAD)
    unbeaten = [name for name in names if not any(name in losers for losers in beaten.values())] or names
    rivals = [name for name in names if name in unbeaten or not any(name in beaten[first] for first in unbeaten)]
    equal = all(verdicts.same(a, b, scenario) for a in rivals for b in rivals if a < b)
    found = [styles[name] for name in rivals]
    if equal:
        return Winner(scenario, found, "the same success and time to goal", EQUAL)
    pairs = verdicts.pairs(scenario)
    few = f"{count(pairs, 'problem')}; a test needs {DECIDABLE_PAIRS}" if pairs < DECIDABLE_PAIRS else ""
    return Winner(scenario, found, few, UNDECIDED)


def _how(name: str, others: Sequence[str], scenario: str, verdicts: _Verdicts) -> str:
    """What a planner is ahead by: success, or time against those that are as successful for all we know."""
    by_time = [other for other in others if verdicts.decisive(name, other, scenario) == TIME]
    by_success = [other for other in others if other not in by_time]
    parts = [f"more successful than {_and(by_success)}"] if by_success else []
    if by_time:
        found = [(other, verdicts.difference(name, other, scenario)) for other in by_time]
        known = _and([f"{show(difference)} s against {other}" for other, difference in found])
        parts.append(f"success decides nothing against {_and(by_time)}; sooner at the goal ({RESTRICTED}): {known}")
    return "; ".join(parts)


def _and(names: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
