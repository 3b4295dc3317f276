"""Tables for the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import pandas as pd

from pytest_lpb.aligned import aligned
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import whole_percent
from pytest_lpb.report.success import common_rate_name, rate_name, solved, solved_share
from pytest_lpb.report.timing_notes import contention_notes, deadline_warnings
from pytest_lpb.report.titles import REACHED, compared_name, timing_mark
from pytest_lpb.run.evaluation import Evaluation
from pytest_lpb.run.missing import missing_notes
from pytest_lpb.run.paired import SUCCESS
from pytest_lpb.run.skipped import skipped_notes
from pytest_lpb.run.summary import ALL
from pytest_lpb.run.title import title_of

KPIS = (
    ("time_to_goal_s", f"time to goal {REACHED} [s]"),
    ("solver_time_p50_ms", "solver median [ms]"),
    ("solver_time_p95_ms", "p95 [ms]"),
)
"""Medians in the table of planners, with their heads."""


def title_lines(data: ReportData) -> Iterator[str]:
    """The run's title, if it has one, above a blank line."""
    title = title_of(data.run_info)
    if title:
        yield from (title, "")


def planner_table(data: ReportData, further: Iterable[str] = ()) -> Iterator[str]:
    """One line per planner: trials solved, rate with interval, median time to goal, solver time; then the notes."""
    yield from aligned(planner_rows(data))
    yield from planner_notes(data, further)


def planner_rows(data: ReportData) -> list[Sequence[str]]:
    """The table's cells, headings first; the planner that solved most of its trials first."""
    rows = sorted(_overall(data).to_dict("records"), key=lambda row: -solved_share(row))
    rates = common_rate_name(rows)
    known = {kpi.name: kpi for kpi in data.kpis}
    marks = [timing_mark(known[name], data) if name in known else "" for name, _ in KPIS]
    heads = ["planner", "solved", "problems", rates, "95 % interval"]
    heads += [f"{head}{mark}" for (_, head), mark in zip(KPIS, marks, strict=True)]
    return [heads, *(_cells(row, rates) for row in rows)]


def planner_notes(data: ReportData, further: Iterable[str] = ()) -> Iterator[str]:
    """What to know of the table's figures, and of `further` KPIs that are shown beside it."""
    rows = _overall(data).to_dict("records")
    if any(row["problems"] < row["trials"] for row in rows):
        yield "repeats of one problem count as one problem: intervals are over problems, not trials"
    if any("scenario" in str(row["success_rate_is"]) for row in rows):
        yield "mean of scenarios: each weighs the same; medians are over all problems, of timing over all trials"
    yield from contention_notes(data, {*further, *(name for name, _ in KPIS)})
    yield from (f"warning: {warning}" for warning in deadline_warnings(data))
    yield from data.run_info.get("notes", ())
    yield from skipped_notes(data.skipped)
    yield from missing_notes(data.missing, len(data.trials), data.resume)


def _overall(data: ReportData) -> pd.DataFrame:
    return data.summary[data.summary["scenario"] == ALL]


def _cells(row: Mapping[Any, Any], rates: str) -> tuple[str, ...]:
    low, high = _number(row["success_low"]), _number(row["success_high"])
    rate = f"{whole_percent(row['success_rate'])} %"
    return (
        str(row["planner"]),
        solved(row),
        str(row["problems"]),
        rate if rate_name(row) == rates else f"{rate_name(row)}: {rate}",
        f"{100 * low:.0f} to {100 * high:.0f} %",
        *(_figure(row.get(f"{name}_median")) for name, _ in KPIS),
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
    rows = data.comparisons[data.comparisons["scenario"] == ALL]
    names = {kpi.name: compared_name(kpi) + timing_mark(kpi, data) for kpi in data.kpis}
    names[SUCCESS.name] = "success [%]"
    heads = ("kpi", "pairs", "a", "b", "b - a", "95 % interval", "adjusted p", "b is")
    yield "a, b, b - a: medians, over several scenarios the mean of theirs; success: rates, b - a in percentage points"
    for (first, second), pair in rows.groupby(["planner_a", "planner_b"], sort=True):
        yield f"a = {first}, b = {second}"
        known = pair[pair["pairs"] > 0]
        yield from aligned([heads, *(_compared(row, names) for row in known.to_dict("records"))])
        if len(known) < len(pair):
            yield f"no problem has a value of both: {', '.join(pair.loc[pair['pairs'] == 0, 'kpi'])}"


def _compared(row: Mapping[Any, Any], names: Mapping[str, str]) -> tuple[str, ...]:
    percent = 100.0 if row["kpi"] == SUCCESS.name else 1.0
    low, high = (percent * row[f"difference_{end}"] for end in ("low", "high"))
    interval = f"{_figure(low)} to {_figure(high)}" if pd.notna(low) else "-"
    figures = (_figure(percent * row[column]) for column in ("median_a", "median_b", "difference"))
    return (
        names.get(str(row["kpi"]), str(row["kpi"])),
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
