"""The top of the page: who solved what, in words, as a heat map and as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from pytest_lpb.report.data import ReportData, ReportedKpi
from pytest_lpb.report.known_failures import reasons
from pytest_lpb.report.numbers import EMPTY, count, finite, percent, show, show_exact
from pytest_lpb.report.success import common_rate_name, named_rate, rate_interval, rate_name, solved, solved_share
from pytest_lpb.report.titles import MARK, contended_trials, value_title
from pytest_lpb.report.view import Cell, MatrixRow, OutcomeBar, PlannerRow, PlannerStyle, Share, Statement
from pytest_lpb.run.summary import ALL

OUTCOMES = (
    "success",
    "criteria_failed",
    "timeout",
    "stalled",
    "infeasible",
    "collision",
    "self_collision",
    "joint_limit",
    "deadline",
    "planner_error",
    "environment_error",
    "worker_crash",
)
USER = "user"  # group of KPIs that a user registered
HEADLINES = ("time_to_goal_s", "clearance_min_m", "path_length_m", "solver_time_p50_ms", "solver_time_p95_ms")


def endings(trials: pd.DataFrame) -> pd.Series[str]:
    """Outcome of every trial; `criteria_failed` where the goal was reached but a criterion was not met."""
    unmet = trials["outcome"].eq("success") & ~trials["success"].eq(True)
    return trials["outcome"].astype(str).mask(unmet, "criteria_failed")


def overall(summary: pd.DataFrame, planner: str) -> Mapping[str, Any]:
    """A planner's row over all scenarios; its only row where there is one scenario."""
    rows = summary[summary["planner"] == planner]
    total = rows[rows["scenario"] == ALL]
    records = (total if len(total) else rows).to_dict("records")
    return {str(key): value for key, value in records[0].items()} if records else {}


def by_success(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[PlannerStyle]:
    """Planners by the share of trials they solved, the most successful first: by what is shown first."""
    rows = {name: overall(data.summary, name) for name in styles}
    return sorted(styles.values(), key=lambda style: -solved_share(rows[style.name]) if rows[style.name] else 0.0)


def statements(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[Statement]:
    """One sentence per planner, the most successful first: what it solved, and how it failed."""
    return [_statement(data, style) for style in by_success(data, styles)]


def _statement(data: ReportData, style: PlannerStyle) -> Statement:
    row = overall(data.summary, style.name)
    trials = data.trials[data.trials["planner"] == style.name]
    if not row or trials.empty:
        return Statement(style, "has no finished trial", "")
    problems = int(row["problems"])
    once = problems == len(trials)
    text = f"solved {solved(row)} {'problem' if once else 'trial'}{'' if len(trials) == 1 else 's'}"
    text += f" ({named_rate(row)}, 95 % interval {rate_interval(row)})"
    details = [] if once else [f"{count(problems, 'distinct problem')}, each counts once"]
    failures = endings(trials)[~trials["success"].eq(True)].value_counts()
    details += [f"{str(outcome).replace('_', ' ')} in {number}" for outcome, number in failures.items()]
    known = int(reasons(trials).ne("").sum())
    details += [f"{count(known, 'known failure')} among them"] if known else []
    return Statement(style, text, ", ".join(details))


def success_matrix(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[MatrixRow]:
    """Success of each planner (columns) in each scenario (rows)."""
    rows = {(str(row["scenario"]), str(row["planner"])): row for row in data.summary.to_dict("records")}
    names = [str(name) for name in dict.fromkeys(data.trials["scenario"])]
    if len(names) > 1:
        names.append(ALL)
    return [
        MatrixRow(
            scenario=name,
            cells=[_matrix_cell(rows.get((name, planner))) for planner in styles],
            is_scenario=name != ALL,
        )
        for name in names
    ]


def _matrix_cell(row: Mapping[Any, Any] | None) -> Cell:
    rate = None if row is None else finite(row["success_rate"])
    if row is None or rate is None:
        return Cell(EMPTY)
    return Cell(solved(row), rate, f"{named_rate(row)} · {rate_interval(row)}")


def summary_table(data: ReportData, styles: Mapping[str, PlannerStyle]) -> tuple[list[str], list[PlannerRow]]:
    """Headings and rows of the table of planners: success, headline KPIs, the user's own KPIs."""
    chosen = headline_kpis(data)
    order = by_success(data, styles)
    rates = common_rate_name(row for style in order if (row := overall(data.summary, style.name)))
    heads = ["solved", "problems", rates, *(value_title(kpi) for kpi in chosen)]
    return heads, [_planner_row(data, style, chosen, rates) for style in order]


def headline_kpis(data: ReportData) -> list[ReportedKpi]:
    """The KPIs of the table of planners, in its order."""
    by_name = {kpi.name: kpi for kpi in data.kpis if f"{kpi.name}_median" in data.summary}
    users = [kpi for name, kpi in by_name.items() if kpi.group == USER]
    return [by_name[name] for name in HEADLINES if name in by_name] + users


def _planner_row(data: ReportData, style: PlannerStyle, chosen: Sequence[ReportedKpi], rates: str) -> PlannerRow:
    row = overall(data.summary, style.name)
    if not row:
        return PlannerRow(style, [Cell(EMPTY) for _ in range(3 + len(chosen))])
    rate = percent(row["success_rate"]) if rate_name(row) == rates else named_rate(row)
    cells = [
        Cell(solved(row), solved_share(row)),
        Cell(show_exact(row["problems"]), finite(row["problems"])),
        Cell(rate, finite(row["success_rate"]), f"95 %: {rate_interval(row)}"),
    ]
    return PlannerRow(style, [*cells, *(_figure_cell(data, row, kpi) for kpi in chosen)])


def _figure_cell(data: ReportData, row: Mapping[str, Any], kpi: ReportedKpi) -> Cell:
    """Median, quartiles and number of problems; in how many trials the timing was disturbed."""
    median = finite(row.get(f"{kpi.name}_median"))
    if median is None:
        return Cell(EMPTY)
    parts = [quartiles(row, kpi.name)]
    disturbed = contended_trials(kpi, data, str(row["planner"]))
    if kpi.timing:
        parts += [f"{count(disturbed, 'trial')} {MARK}"] if disturbed else []
    else:
        parts.append(count(int(row[f"{kpi.name}_n"]), "problem"))
    return Cell(show(median), median, " · ".join(filter(None, parts)), MARK if disturbed else "")


def quartiles(row: Mapping[Any, Any], kpi_name: str) -> str:
    """`1.7 to 4.35`; empty where there are none, or all values are the same."""
    low, high = row.get(f"{kpi_name}_q1"), row.get(f"{kpi_name}_q3")
    return f"{show(low)} to {show(high)}" if finite(low) is not None and low != high else ""


def outcome_bars(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[OutcomeBar]:
    """How the trials of each planner ended."""
    bars = []
    for style in by_success(data, styles):
        counts = endings(data.trials[data.trials["planner"] == style.name]).value_counts()
        total = int(counts.sum())
        shares = [
            Share(name, int(counts[name]), round(100 * int(counts[name]) / total, 3))
            for name in ordered_outcomes(counts.index)
        ]
        bars.append(OutcomeBar(style, shares))
    return bars


def ordered_outcomes(names: Any) -> list[str]:
    """Outcomes from success over harmless to broken; unknown ones last."""
    return sorted(
        {str(name) for name in names},
        key=lambda name: (OUTCOMES.index(name) if name in OUTCOMES else len(OUTCOMES), name),
    )
