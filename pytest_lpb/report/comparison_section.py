"""Comparisons of planners: a table, and differences with their intervals as a picture."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import finite, kpi_title, percent, show, show_exact, show_p
from pytest_lpb.report.packing import packed
from pytest_lpb.report.view import ComparisonSection, PlannerStyle
from pytest_lpb.run.summary import ALL

MAX_COMPARISONS = 20_000
VERDICTS = ("better", "worse", "same", "inconclusive", "")
HEADS = ("pairs", "median A", "median B", "difference B − A", "ratio B / A", "p, adjusted", "B improves")


def comparison_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> ComparisonSection | None:
    """Every comparison with at least one pair of problems; None without any."""
    frame, note = _shown(data)
    if frame.empty:
        return None
    found = set(frame["verdict"])
    titles = {kpi.name: kpi_title(kpi.name, kpi.unit) for kpi in data.kpis}
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
    return kpi.direction, int(kpi.timing and bool(data.trials["timing_contended"].eq(True).any()))


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
    return [
        [show_exact(row["pairs"]), finite(row["pairs"]), ""],
        [show(row["median_a"]), finite(row["median_a"]), ""],
        [show(row["median_b"]), finite(row["median_b"]), ""],
        [sign + show(difference), difference, bounds],
        [show(row["ratio"]), finite(row["ratio"]), ""],
        [show_p(row["p_adjusted"]), finite(row["p_adjusted"]), ""],
        [percent(row["improvement_probability"]), finite(row["improvement_probability"]), ""],
    ]


def relative_difference(row: Mapping[Any, Any]) -> list[float] | None:
    """Difference with its interval in [%] of A's median, so that KPIs share an axis; success in points."""
    figures = [finite(row[name]) for name in ("difference", "difference_low", "difference_high")]
    whole = 1.0 if row["kpi"] == "success" else abs(finite(row["median_a"]) or 0.0)
    if None in figures or whole == 0.0:
        return None
    shares = [100.0 * (figure or 0.0) / whole for figure in figures]
    return [round(share, 2) for share in shares] if all(finite(share) is not None for share in shares) else None
