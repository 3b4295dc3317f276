"""Built-in plot of tables: the performance profile of each KPI that has one."""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import wrap
from typing import Any

from matplotlib.ticker import NullFormatter

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import unit_text
from pytest_lpb.report.palette import COLOURS, styles_of
from pytest_lpb.report.plots import Plot, default_registry
from pytest_lpb.report.profiles import axis_of, explained, profile_of, with_profile
from pytest_lpb.report.scale import Scale
from pytest_lpb.report.titles import timing_mark, value_title
from pytest_lpb.report.view import PlannerStyle
from pytest_lpb.run.profiles import RATIO
from pytest_lpb.shown import literal

TITLE_WIDTH = 90  # [characters]
TICKS = (1, 2, 5, 10, 20, 50, 100)


def profile_pictures(data: ReportData) -> Iterator[tuple[str, ...]]:
    """One of every KPI with a direction and values."""
    for kpi in with_profile(data):
        yield (kpi.name,)


def profile(data: ReportData, parts: tuple[str, ...], axes: Any) -> None:
    """Share of problems within each bound, with pointwise 95 % intervals; a line per planner."""
    kpi = next(kpi for kpi in data.kpis if kpi.name == parts[0])
    shown = profile_of(kpi, data)
    if shown is None:
        return
    title = value_title(kpi) + timing_mark(kpi, data)
    axes.set_title("\n".join([title, *wrap(explained(shown), TITLE_WIDTH)]), fontsize=8)
    styles = styles_of(data)
    for planner, curve in shown.curves.items():
        colour, line = COLOURS[styles[planner].colour], _line_style(styles[planner])
        axes.plot(shown.bounds, curve.share, color=colour, linestyle=line, label=literal(planner))
        axes.fill_between(shown.bounds, curve.low, curve.high, color=colour, alpha=0.15, linewidth=0)
    scale = axis_of(shown)
    if scale.logarithmic:
        _logarithmic(axes, scale)
    unit = unit_text(kpi.unit)
    bound = "ratio to the best planner" if shown.kind == RATIO else f"bound [{unit}]" if unit else "bound"
    axes.set(xlabel=bound, ylabel="share of problems", xlim=(scale.low, scale.high), ylim=(-0.02, 1.02))
    axes.legend(loc="best", fontsize="small")


def _line_style(style: PlannerStyle) -> Any:
    """The planner's dash as matplotlib takes it."""
    return (0, tuple(map(float, style.dash.split()))) if style.dash else "-"


def _logarithmic(axes: Any, scale: Scale) -> None:
    axes.set_xscale("log", subs=range(2, 10))
    axes.set_xticks([tick for tick in TICKS if scale.low <= tick <= scale.high])
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())


default_registry.add(Plot("profile", "run", profile, pictures=profile_pictures))
