"""The tables of comparisons and of trials."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import finite, kpi_title, percent, show, show_exact, show_p
from pytest_lpb.report.overview import endings
from pytest_lpb.report.view import Cell, ComparisonRow, PlannerStyle, TrialRow

MAX_COMPARISONS = 2500
MAX_TRIALS = 5000
COMPARISON_HEADS = (
    "pairs",
    "median A",
    "median B",
    "difference B − A",
    "ratio B / A",
    "p, adjusted",
    "B improves",
)
TRIAL_KPIS = ("time_to_goal_s", "clearance_min_m", "solver_time_p95_ms")


def comparison_rows(data: ReportData, styles: Mapping[str, PlannerStyle]) -> tuple[list[ComparisonRow], str]:
    """Rows of the table of comparisons, and a note where some are left out."""
    frame = data.comparisons[data.comparisons["pairs"] > 0]
    if frame["scenario"].nunique() == 2 and "all" in set(frame["scenario"]):
        frame = frame[frame["scenario"] != "all"]  # of one scenario it says the same again
    note = ""
    if len(frame) > MAX_COMPARISONS:
        kept = frame[frame["scenario"] == "all"]
        frame = (kept if len(kept) else frame).head(MAX_COMPARISONS)
        note = f"{len(frame)} comparisons; all {len(data.comparisons)} of them are in comparisons.csv."
    kpis = {kpi.name: kpi for kpi in data.kpis}
    contended = len(data.trials) > 0 and bool(data.trials["timing_contended"].eq(True).any())
    rows = []
    for row in frame.to_dict("records"):
        kpi = kpis.get(row["kpi"])
        title = kpi_title(kpi.name, kpi.unit) if kpi else str(row["kpi"]).replace("_", " ")
        marked = kpi is not None and kpi.timing and contended
        rows.append(
            ComparisonRow(
                a=styles[row["planner_a"]],
                b=styles[row["planner_b"]],
                scenario=str(row["scenario"]),
                kpi=str(row["kpi"]),
                title=f"{title} †" if marked else title,
                over=str(row["over"]),
                verdict=str(row["verdict"]),
                cells=_comparison_cells(row),
            )
        )
    return rows, note


def _comparison_cells(row: Mapping[Any, Any]) -> list[Cell]:
    low, high = finite(row["difference_low"]), finite(row["difference_high"])
    difference = finite(row["difference"])
    sign = "+" if difference is not None and difference > 0 else ""
    return [
        Cell(show_exact(row["pairs"]), finite(row["pairs"])),
        Cell(show(row["median_a"]), finite(row["median_a"])),
        Cell(show(row["median_b"]), finite(row["median_b"])),
        Cell(
            sign + show(difference),
            difference,
            "" if low is None or high is None else f"{show(low)} to {show(high)}",
        ),
        Cell(show(row["ratio"]), finite(row["ratio"])),
        Cell(show_p(row["p_adjusted"]), finite(row["p_adjusted"])),
        Cell(percent(row["improvement_probability"]), finite(row["improvement_probability"])),
    ]


def trial_heads(data: ReportData) -> list[str]:
    """Headings of the figures in the table of trials."""
    return [*(kpi_title(kpi.name, kpi.unit) for kpi in data.kpis if kpi.name in TRIAL_KPIS), "steps"]


def trial_rows(data: ReportData, styles: Mapping[str, PlannerStyle]) -> tuple[list[TrialRow], str]:
    """Rows of the table of trials, and a note where some are left out."""
    frame, note = data.trials, ""
    if len(frame) > MAX_TRIALS:
        frame = frame.sort_values("success", kind="stable").head(MAX_TRIALS)
        note = f"{MAX_TRIALS} of {len(data.trials)} trials, failed ones first; all of them are in trials.csv."
    kpis = [kpi for kpi in data.kpis if kpi.name in TRIAL_KPIS]
    rows = []
    for row in frame.assign(outcome=endings(frame)).to_dict("records"):
        mark = "†" if row["timing_contended"] == 1 else ""
        cells = [
            Cell(show(row.get(kpi.name)), finite(row.get(kpi.name)), mark=mark if kpi.timing else "") for kpi in kpis
        ]
        cells.append(Cell(show_exact(row["steps"]), finite(row["steps"])))
        rows.append(_trial_row(row, styles, cells))
    return rows, note


def _trial_row(row: Mapping[Any, Any], styles: Mapping[str, PlannerStyle], cells: list[Cell]) -> TrialRow:
    return TrialRow(
        node_id=str(row["node_id"]),
        scenario=str(row["scenario"]),
        style=styles[row["planner"]],
        seed=int(row["seed"]),
        outcome=str(row["outcome"]),
        success=row["success"] == 1,
        cells=cells,
        message=_text(row.get("message")),
        failed_criteria=_text(row.get("failed_criteria")),
        command=_text(row.get("command")),
    )


def _text(value: Any) -> str:
    return "" if value is None or value is pd.NA or value != value else str(value)
