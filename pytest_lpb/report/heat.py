"""The heat map's figures for every KPI that can be chosen: scenario by planner."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pytest_lpb.report.data import ReportData, ReportedKpi
from pytest_lpb.report.numbers import count, finite, show
from pytest_lpb.report.overview import quartiles
from pytest_lpb.report.packing import packed
from pytest_lpb.report.titles import MARK, value_title
from pytest_lpb.report.view import HeatMap, PlannerStyle
from pytest_lpb.run.contention import CONTENDED_KPIS, SEPARATOR
from pytest_lpb.run.summary import ALL

MAX_CELLS = 40_000  # of all KPIs together


def heat_map(data: ReportData, styles: Mapping[str, PlannerStyle]) -> HeatMap | None:
    """Medians of every KPI that has values, in the order of the matrix of success; None without any.

    Packed: KPI name -> [direction, rows of cells], each cell [text, value, small print], or null.
    """
    rows = {(str(row["scenario"]), str(row["planner"])): row for row in data.summary.to_dict("records")}
    scenarios = [str(name) for name in dict.fromkeys(data.trials["scenario"])]
    names = [*scenarios, ALL] if len(scenarios) > 1 else scenarios
    most = MAX_CELLS // max(len(names) * len(styles), 1)
    chosen = [kpi for kpi in data.kpis if _has_values(data, kpi)][:most]
    if not chosen:
        return None
    cells = {
        kpi.name: [
            kpi.direction,
            [[_cell(kpi, rows.get((name, planner))) for planner in styles] for name in names],
        ]
        for kpi in chosen
    }
    options = [(kpi.group, kpi.name, value_title(kpi)) for kpi in chosen]
    return HeatMap(options, packed(cells))


def _has_values(data: ReportData, kpi: ReportedKpi) -> bool:
    column = f"{kpi.name}_median"
    return column in data.summary and any(finite(value) is not None for value in data.summary[column])


def _cell(kpi: ReportedKpi, row: Mapping[Any, Any] | None) -> list[Any] | None:
    value = None if row is None else finite(row[f"{kpi.name}_median"])
    if row is None or value is None:
        return None
    mark = f" {MARK}" if kpi.name in str(row[CONTENDED_KPIS]).split(SEPARATOR) else ""
    parts = [quartiles(row, kpi.name), count(int(row[f"{kpi.name}_n"]), "problem")]
    return [f"{show(value)}{mark}", value, " · ".join(filter(None, parts))]
