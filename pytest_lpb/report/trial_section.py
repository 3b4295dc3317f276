"""The table of trials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from pytest_lpb.report.data import ReportData, ReportedKpi
from pytest_lpb.report.numbers import finite, show, show_exact
from pytest_lpb.report.overview import USER, by_success, endings, ordered_outcomes
from pytest_lpb.report.titles import MARK, value_title
from pytest_lpb.report.view import Cell, PlannerStyle, TrialRow, TrialSection
from pytest_lpb.run.contention import contended

MAX_TRIALS = 5000
TRIAL_KPIS = ("time_to_goal_s", "clearance_min_m", "solver_time_p95_ms")


def trial_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> TrialSection | None:
    """The table of trials, and what it can be filtered by; None without trials."""
    if data.trials.empty:
        return None
    rows, note = trial_rows(data, styles)
    return TrialSection(
        heads=trial_heads(data),
        rows=rows,
        note=note,
        styles=by_success(data, styles),
        scenarios=[str(name) for name in dict.fromkeys(data.trials["scenario"])],
        outcomes=ordered_outcomes(endings(data.trials)),
    )


def trial_kpis(data: ReportData) -> Sequence[ReportedKpi]:
    """The KPIs of the table: three, and a user's own."""
    return [kpi for kpi in data.kpis if kpi.name in TRIAL_KPIS or kpi.group == USER]


def listed_trials(data: ReportData) -> tuple[pd.DataFrame, str]:
    """The trials that the report shows one by one, and a note where some are left out."""
    if len(data.trials) <= MAX_TRIALS:
        return data.trials, ""
    frame = data.trials.sort_values("success", kind="stable").head(MAX_TRIALS)
    return frame, f"{MAX_TRIALS} of {len(data.trials)} trials, failed ones first; all of them are in trials.csv."


def trial_heads(data: ReportData) -> list[str]:
    """Headings of the figures in the table of trials."""
    return [*(value_title(kpi) for kpi in trial_kpis(data)), "steps"]


def trial_rows(data: ReportData, styles: Mapping[str, PlannerStyle]) -> tuple[list[TrialRow], str]:
    """Rows of the table of trials, and a note where some are left out."""
    frame, note = listed_trials(data)
    kpis = trial_kpis(data)
    rows = []
    disturbed = {kpi.name: contended(frame, kpi).tolist() for kpi in kpis}
    for place, row in enumerate(frame.assign(outcome=endings(frame)).to_dict("records")):
        values = [(kpi, finite(row.get(kpi.name))) for kpi in kpis]
        cells = [
            Cell(show(value), value, mark=MARK if value is not None and disturbed[kpi.name][place] else "")
            for kpi, value in values
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
        known_failure=_text(row.get("known_failure")),
    )


def _text(value: Any) -> str:
    return "" if value is None or value is pd.NA or value != value else str(value)
