"""The top of the page: who solved what, in words, as a heat map and as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from pytest_lpb.report.data import ReportData, ReportedKpi
from pytest_lpb.report.known_failures import reasons
from pytest_lpb.report.numbers import EMPTY, count, finite, interval, kpi_title, percent, show, show_exact
from pytest_lpb.report.view import Cell, MatrixRow, OutcomeBar, PlannerRow, PlannerStyle, Share, Statement

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
    total = rows[rows["scenario"] == "all"]
    records = (total if len(total) else rows).to_dict("records")
    return {str(key): value for key, value in records[0].items()} if records else {}


def by_success(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[PlannerStyle]:
    """Planners, the most successful first."""
    rates = {name: finite(overall(data.summary, name).get("success_rate")) for name in styles}
    return sorted(styles.values(), key=lambda style: -(rates[style.name] or 0.0))


def statements(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[Statement]:
    """One sentence per planner, the most successful first: what it solved, and how it failed."""
    return [_statement(data, style) for style in by_success(data, styles)]


def _statement(data: ReportData, style: PlannerStyle) -> Statement:
    row = overall(data.summary, style.name)
    trials = data.trials[data.trials["planner"] == style.name]
    if not row or trials.empty:
        return Statement(style, "has no finished trial", "")
    problems, solved = int(row["problems"]), int(trials["success"].eq(True).sum())
    once = problems == len(trials)
    rate = percent(row["success_rate"])
    if abs(float(row["success_rate"]) - solved / len(trials)) >= 0.005:
        rate = f"mean over {'problems' if data.trials['scenario'].nunique() == 1 else 'scenarios'} {rate}"
    bounds = interval(row["success_low"], row["success_high"])
    whole = count(len(trials), "problem" if once else "trial")
    text = f"solved {solved} of {whole} ({rate}, 95 % interval {bounds})"
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
        names.append("all")
    return [
        MatrixRow(
            scenario="mean over scenarios" if name == "all" else name,
            cells=[_matrix_cell(rows.get((name, planner))) for planner in styles],
            is_scenario=name != "all",
        )
        for name in names
    ]


def _matrix_cell(row: Mapping[Any, Any] | None) -> Cell:
    rate = None if row is None else finite(row["success_rate"])
    if row is None or rate is None:
        return Cell(EMPTY)
    problems, trials = int(row["problems"]), int(row["trials"])
    repeats = "" if problems == trials else f" of {count(problems, 'problem')}"
    note = f"{int(row['successes'])} of {count(trials, 'trial')}{repeats}"
    return Cell(percent(rate), rate, f"{note} · {interval(row['success_low'], row['success_high'])}")


def summary_table(data: ReportData, styles: Mapping[str, PlannerStyle]) -> tuple[list[str], list[PlannerRow]]:
    """Headings and rows of the table of planners: success, headline KPIs, the user's own KPIs."""
    chosen = headline_kpis(data)
    heads = ["trials", "problems", "success rate", *(f"{kpi_title(kpi.name, kpi.unit)}" for kpi in chosen)]
    return heads, [_planner_row(data, style, chosen) for style in by_success(data, styles)]


def headline_kpis(data: ReportData) -> list[ReportedKpi]:
    """The KPIs of the table of planners, in its order."""
    by_name = {kpi.name: kpi for kpi in data.kpis if f"{kpi.name}_median" in data.summary}
    users = [kpi for name, kpi in by_name.items() if kpi.group == USER]
    return [by_name[name] for name in HEADLINES if name in by_name] + users


def _planner_row(data: ReportData, style: PlannerStyle, chosen: Sequence[ReportedKpi]) -> PlannerRow:
    row = overall(data.summary, style.name)
    trials = data.trials[data.trials["planner"] == style.name]
    contended = bool(trials["timing_contended"].eq(True).any())
    rate = row.get("success_rate")
    cells = [
        Cell(str(len(trials)), len(trials)),
        Cell(show_exact(row.get("problems")), finite(row.get("problems"))),
        Cell(percent(rate), finite(rate), interval(row.get("success_low"), row.get("success_high"))),
    ]
    for kpi in chosen:
        median, low, high = (row.get(f"{kpi.name}_{part}") for part in ("median", "q1", "q3"))
        spread = f"{show(low)} to {show(high)}" if finite(low) is not None and low != high else ""
        mark = "†" if kpi.timing and contended and finite(median) is not None else ""
        cells.append(Cell(show(median), finite(median), spread, mark))
    return PlannerRow(style, cells)


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
