"""Tables for the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import pandas as pd

from pytest_lpb.aligned import aligned
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import whole_percent
from pytest_lpb.run.evaluation import Evaluation
from pytest_lpb.run.missing import missing_notes
from pytest_lpb.run.title import title_of

HEADS = (
    "planner",
    "trials",
    "problems",
    "success",
    "95 % interval",
    "time to goal if solved [s]",
    "solver median [ms]",
    "p95 [ms]",
)
COLUMNS = ("time_to_goal_s_median", "solver_time_p50_ms_median", "solver_time_p95_ms_median")


def title_lines(data: ReportData) -> Iterator[str]:
    """The run's title, if it has one, above a blank line."""
    title = title_of(data.run_info)
    if title:
        yield from (title, "")


def planner_table(data: ReportData) -> Iterator[str]:
    """One line per planner: trials, success rate with interval, median time to goal, solver time; then what to know."""
    yield from aligned(planner_rows(data))
    yield from planner_notes(data)


def planner_rows(data: ReportData) -> list[Sequence[str]]:
    """The table's cells, headings first."""
    heads = [f"{head}{'*' if _contended(data) and '[ms]' in head else ''}" for head in HEADS]
    return [heads, *(_cells(row) for _, row in _overall(data).iterrows())]


def planner_notes(data: ReportData) -> Iterator[str]:
    """What to know of the table's figures."""
    if _contended(data):
        yield "* timing was contended (other work ran on the same cores): no basis for comparisons"
    overall = _overall(data)
    repeated = overall[overall["problems"] < overall["trials"]]
    if len(repeated):
        yield "repeats of one problem count as one problem: intervals are over problems, not trials"
    yield from data.run_info.get("notes", ())
    yield from missing_notes(data.missing, len(data.trials), data.resume)


def _overall(data: ReportData) -> pd.DataFrame:
    return data.summary[data.summary["scenario"] == "all"]


def _contended(data: ReportData) -> bool:
    return bool(len(data.trials)) and bool(data.trials["timing_contended"].astype(bool).any())


def _cells(row: pd.Series[Any]) -> tuple[str, ...]:
    low, high = _number(row["success_low"]), _number(row["success_high"])
    return (
        str(row["planner"]),
        str(row["trials"]),
        str(row["problems"]),
        f"{whole_percent(row['success_rate'])} %",
        f"{100 * low:.0f} to {100 * high:.0f} %",
        *(_figure(row.get(column)) for column in COLUMNS),
    )


def _number(value: object) -> float:
    return float(str(value))


def _figure(value: object) -> str:
    """A number with three digits, or a dash where there is none."""
    if value is None or pd.isna(_number(value)):
        return "-"
    return f"{_number(value):.3g}"


def comparison_table(data: ReportData) -> Iterator[str]:
    """One line per KPI of the compared planners, over all scenarios, with the number of pairs."""
    rows = data.comparisons[data.comparisons["scenario"] == "all"]
    heads = ("kpi", "pairs", "median a", "median b", "b - a", "95 % interval", "adjusted p", "b is")
    for (first, second), pair in rows.groupby(["planner_a", "planner_b"], sort=True):
        yield f"a = {first}, b = {second}"
        known = pair[pair["pairs"] > 0]
        yield from aligned([heads, *(_compared(row) for _, row in known.iterrows())])
        if len(known) < len(pair):
            yield f"no problem has a value of both: {', '.join(pair.loc[pair['pairs'] == 0, 'kpi'])}"


def _compared(row: pd.Series[Any]) -> tuple[str, ...]:
    low, high = row["difference_low"], row["difference_high"]
    interval = f"{_figure(low)} to {_figure(high)}" if pd.notna(low) else "-"
    figures = (_figure(row[column]) for column in ("median_a", "median_b", "difference"))
    return (
        str(row["kpi"]),
        str(row["pairs"]),
        *figures,
        interval,
        _figure(row["p_adjusted"]),
        str(row["verdict"]) or "-",
    )


def trial_lines(evaluation: Evaluation) -> Iterator[str]:
    """Everything that is known of the trials: outcome, message, command, then a line per KPI."""
    for _, row in evaluation.trials.iterrows():
        yield f"{row['node_id']}: {row['outcome']}"
        yield str(row["message"])
        yield f"repeat: {row['command']}"
        table = [(kpi.name, _figure(row[kpi.name]), kpi.unit, kpi.group) for kpi in evaluation.kpis]
        yield from aligned([("kpi", "value", "unit", "group"), *table])
