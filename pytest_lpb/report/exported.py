"""The tables of a run for papers and pages: what is in them, before it is LaTeX or Markdown."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pytest_lpb.report.data import ReportData, ReportedKpi
from pytest_lpb.report.numbers import EMPTY, finite, percent, show, show_exact, show_p, whole_percent
from pytest_lpb.report.overview import headline_kpis
from pytest_lpb.report.success import RATE, rate_name, solved, solved_share
from pytest_lpb.report.titles import MARK, compared_title, is_contended, timing_mark, value_title
from pytest_lpb.run.paired import SUCCESS
from pytest_lpb.run.summary import ALL

OVER_ALL = " Scenario all: the rate is the mean of the scenarios' rates; medians and quartiles are of all problems."


@dataclass(frozen=True)
class Table:
    """A table as text.

    Attributes:
        name: of its file.
        caption: one sentence.
        heads: with units.
        texts: how many of the first columns are words; the others are figures.
        rows: as many cells as heads.
    """

    name: str
    caption: str
    heads: Sequence[str]
    texts: int
    rows: Sequence[Sequence[str]]


def tables(data: ReportData, kpi_names: Sequence[str] | None = None) -> list[Table]:
    """Summary and comparisons.

    Args:
        data: the evaluated run.
        kpi_names: KPIs in them; None: those of the report's table of planners, a user's own among them.
    """
    headlines = headline_kpis(data)
    chosen = headlines if kpi_names is None else [kpi for kpi in data.kpis if kpi.name in set(kpi_names)]
    found = [_summary(data, chosen)]
    return [*found, _comparisons(data, chosen)] if len(data.comparisons) else found


def _summary(data: ReportData, kpis: Sequence[ReportedKpi]) -> Table:
    several = data.trials["scenario"].nunique() > 1
    records = data.summary.to_dict("records")
    # Of one scenario, the mean over scenarios says the same again.
    rows = sorted(
        (row for row in records if several or row["scenario"] != ALL),
        key=lambda row: (row["scenario"] == ALL, str(row["scenario"]), -solved_share(row)),
    )
    heads = ["scenario", "planner", "solved", "problems", "rate [%]", *_titles(data, kpis, value_title).values()]
    return Table(
        "summary",
        "Trials solved, and the success rate with its 95 % interval; medians with quartiles over problems, of timing "
        f"over trials.{OVER_ALL if several else ''}{_marked(data, chosen=kpis)}",
        heads,
        2,
        [_summary_row(row, kpis) for row in rows],
    )


def _titles(data: ReportData, kpis: Sequence[ReportedKpi], title: Callable[[ReportedKpi], str]) -> dict[str, str]:
    """Names with units; timing that was contended is marked, as everywhere."""
    return {kpi.name: title(kpi) + timing_mark(kpi, data) for kpi in kpis}


def _marked(data: ReportData, chosen: Sequence[ReportedKpi]) -> str:
    contended = any(is_contended(kpi, data) for kpi in chosen)
    return f" {MARK} Timing was contended and does not compare planners." if contended else ""


def _summary_row(row: Mapping[Any, Any], kpis: Sequence[ReportedKpi]) -> list[str]:
    rate, low, high = (finite(row[f"success_{part}"]) for part in ("rate", "low", "high"))
    success = EMPTY
    if rate is not None and low is not None and high is not None:
        name = "" if rate_name(row) == RATE else f"{rate_name(row)}: "
        success = f"{name}{whole_percent(rate)} ({100 * low:.0f} to {100 * high:.0f})"
    figures = [_with_bounds(*(row.get(f"{kpi.name}_{part}") for part in ("median", "q1", "q3"))) for kpi in kpis]
    return [str(row["scenario"]), str(row["planner"]), solved(row), str(row["problems"]), success, *figures]


def _comparisons(data: ReportData, kpis: Sequence[ReportedKpi]) -> Table:
    titles = {SUCCESS.name: "success [%]"} | _titles(data, kpis, compared_title)
    frame = data.comparisons
    frame = frame[(frame["scenario"] == ALL) & frame["kpi"].isin(titles) & (frame["pairs"] > 0)]
    several = data.trials["scenario"].nunique() > 1
    figures = "means of the scenarios' medians" if several else "medians"
    heads = ["A", "B", "KPI", "pairs", "value A", "value B", "B − A", "ratio", "p, adjusted", "B improves", "B is"]
    return Table(
        "comparisons",
        f"B against A on the same problems, over all scenarios: {figures} (success: rates; their difference in "
        "percentage points); differences with 95 % intervals, p adjusted (Holm)." + _marked(data, chosen=kpis),
        heads,
        3,
        [_comparison_row(row, titles) for row in frame.to_dict("records")],
    )


def _comparison_row(row: Mapping[Any, Any], titles: Mapping[str, str]) -> list[str]:
    scale = 100.0 if row["kpi"] == SUCCESS.name else 1.0
    ends = [scale * row[name] for name in ("difference", "difference_low", "difference_high")]
    return [
        str(row["planner_a"]),
        str(row["planner_b"]),
        titles[str(row["kpi"])],
        show_exact(row["pairs"]),
        show(scale * row["median_a"]),
        show(scale * row["median_b"]),
        _with_bounds(*ends),
        show(row["ratio"]),
        show_p(row["p_adjusted"]),
        percent(row["improvement_probability"]),
        str(row["verdict"]) or EMPTY,
    ]


def _with_bounds(value: Any, low: Any, high: Any) -> str:
    if finite(value) is None or finite(low) is None or finite(high) is None or low == high:
        return show(value)
    return f"{show(value)} ({show(low)} to {show(high)})"
