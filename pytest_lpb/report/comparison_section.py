"""Comparisons of planners: a table, and differences with their intervals as a picture."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import finite, percent, show, show_exact, show_p
from pytest_lpb.report.packing import packed
from pytest_lpb.report.titles import compared_title, is_contended
from pytest_lpb.report.view import ComparisonSection, PlannerStyle
from pytest_lpb.run.paired import SUCCESS
from pytest_lpb.run.summary import ALL

MAX_COMPARISONS = 20_000
VERDICTS = ("better", "worse", "same", "inconclusive", "")
HEADS = ("pairs", "A", "B", "difference B − A", "ratio B / A", "p, adjusted", "B improves")


def comparison_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> ComparisonSection | None:
    """Every comparison with at least one pair of problems; None without any."""
    frame, note = _shown(data)
    if frame.empty:
        return None
    found = set(frame["verdict"])
    titles = {kpi.name: compared_title(kpi) for kpi in data.kpis}
    kpis = [(str(name), titles.get(str(name), str(name))) for name in dict.fromkeys(frame["kpi"])]
    scenarios = [str(name) for name in dict.fromkeys(frame["scenario"])]
    return ComparisonSection(
        kpis=kpis,
        scenarios=scenarios,
        verdicts=[verdict for verdict in VERDICTS if verdict in found and verdict],
        styles=list(styles.values()),
        note=note,
        packed=packed(
            {
                "heads": HEADS,
                "planners": list(styles),
                "kpis": [[name, title, *_marks(data, name)] for name, title in kpis],
                "scenarios": scenarios,
                "rows": _rows(frame, list(styles), [name for name, _ in kpis], scenarios),
            }
        ),
    )


def _shown(data: ReportData) -> tuple[pd.DataFrame, str]:
    frame = data.comparisons[data.comparisons["pairs"] > 0]
    if frame["scenario"].nunique() == 2 and ALL in set(frame["scenario"]):
        frame = frame[frame["scenario"] != ALL]  # of one scenario it says the same again
    if len(frame) <= MAX_COMPARISONS:
        return frame, ""
    overall = frame[frame["scenario"] == ALL]
    frame = (overall if len(overall) else frame).head(MAX_COMPARISONS)
    return frame, f"{len(frame)} comparisons; all {len(data.comparisons)} of them are in comparisons.csv."


def _marks(data: ReportData, name: str) -> tuple[str, int]:
    """Direction of a KPI, and whether its figures are timing that was contended."""
    kpi = next((kpi for kpi in data.kpis if kpi.name == name), None)
    if kpi is None:
        return "higher", 0
    return kpi.direction, int(is_contended(kpi, data))


def _rows(frame: pd.DataFrame, planners: list[str], kpis: list[str], scenarios: list[str]) -> list[list[Any]]:
    """Rows as lists: places of planners, scenario, KPI and verdict in their lists, then cells and numbers."""
    return [
        [
            planners.index(row["planner_a"]),
            planners.index(row["planner_b"]),
            scenarios.index(str(row["scenario"])),
            kpis.index(row["kpi"]),
            VERDICTS.index(str(row["verdict"])),
            int(row["over"] == "solved"),
            _cells(row),
            relative_difference(row),
        ]
        for row in frame.to_dict("records")
    ]


def _cells(row: Mapping[Any, Any]) -> list[list[Any]]:
    """(text, number to sort by, small print) of each figure."""
    low, high = finite(row["difference_low"]), finite(row["difference_high"])
    difference = finite(row["difference"])
    sign = "+" if difference is not None and difference > 0 else ""
    bounds = "" if low is None or high is None else f"{show(low)} to {show(high)}"
    if row["kpi"] == SUCCESS.name:
        return _success_cells(row, sign)
    return [
        [show_exact(row["pairs"]), finite(row["pairs"]), ""],
        [show(row["median_a"]), finite(row["median_a"]), ""],
        [show(row["median_b"]), finite(row["median_b"]), ""],
        [sign + show(difference), difference, bounds],
        *_tested_cells(row),
    ]


def _success_cells(row: Mapping[Any, Any], sign: str) -> list[list[Any]]:
    """The same of success: rates in percent, their difference in percentage points."""
    difference, low, high = (finite(row[f"difference{end}"]) for end in ("", "_low", "_high"))
    bounds = "" if low is None or high is None else f"{show(100 * low)} to {show(100 * high)}"
    points = "" if difference is None else " percentage points"
    return [
        [show_exact(row["pairs"]), finite(row["pairs"]), ""],
        [percent(row["median_a"]), finite(row["median_a"]), ""],
        [percent(row["median_b"]), finite(row["median_b"]), ""],
        [f"{sign}{show(None if difference is None else 100 * difference)}{points}", difference, bounds],
        *_tested_cells(row),
    ]


def _tested_cells(row: Mapping[Any, Any]) -> list[list[Any]]:
    return [
        [show(row["ratio"]), finite(row["ratio"]), ""],
        [show_p(row["p_adjusted"]), finite(row["p_adjusted"]), ""],
        [percent(row["improvement_probability"]), finite(row["improvement_probability"]), ""],
    ]


def relative_difference(row: Mapping[Any, Any]) -> list[float | None] | None:
    """Difference with its interval, if it has one, in [%] of A's figure, so that KPIs share an axis.

    Success in percentage points.
    """
    figures = [finite(row[name]) for name in ("difference", "difference_low", "difference_high")]
    whole = 1.0 if row["kpi"] == "success" else abs(finite(row["median_a"]) or 0.0)
    if figures[0] is None or whole == 0.0:
        return None
    shares = [None if figure is None else 100.0 * figure / whole for figure in figures]
    known = all(share is None or finite(share) is not None for share in shares)
    return [None if share is None else round(share, 2) for share in shares] if known else None
