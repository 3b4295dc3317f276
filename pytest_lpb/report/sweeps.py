"""The section about a study's sweeps: every KPI over the values of a parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pytest_lpb.report.canvas import path_through
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import percent, show
from pytest_lpb.report.palette import DASHES
from pytest_lpb.report.scale import Scale, scale_for
from pytest_lpb.report.success import RATE, common_rate_name
from pytest_lpb.report.titles import timing_mark, value_title
from pytest_lpb.report.view import PlannerStyle, Tick
from pytest_lpb.run.summary import ALL
from pytest_lpb.run.sweeps import Curve, Point, Sweep, sweeps_of

# KPIs that are shown at once; the others are below a fold.
FIRST = ("time_to_goal_s", "clearance_min_m", "path_length_ratio", "solver_time_p50_ms", "solver_time_p99_ms")


@dataclass(frozen=True)
class SweepLine:
    """A curve, in units of 1/1000 of its axes."""

    style: PlannerStyle
    dash: str  # of the planner; where a planner has several lines, of the other values
    label: str
    d: str
    whiskers: str  # SVG path of the intervals
    dots: Sequence[tuple[float, float, str]]  # place, and what it says


@dataclass(frozen=True)
class SweepFigure:
    """A KPI over the values of a parameter."""

    title: str  # of the vertical axis
    x_title: str
    x_ticks: Sequence[Tick]
    y_ticks: Sequence[Tick]
    lines: Sequence[SweepLine]


@dataclass(frozen=True)
class ShownSweep:
    """All KPIs of one sweep."""

    title: str
    note: str
    figures: Sequence[SweepFigure]
    further: Sequence[SweepFigure]


@dataclass(frozen=True)
class SweepSection:
    """All sweeps."""

    sweeps: Sequence[ShownSweep]


def sweep_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> SweepSection | None:
    """The section; None where nothing was swept."""
    shown = [_shown(sweep, data, styles) for sweep in sweeps_of(data.run_info)]
    sweeps = [sweep for sweep in shown if sweep.figures]
    return SweepSection(sweeps) if sweeps else None


def _shown(sweep: Sweep, data: ReportData, styles: Mapping[str, PlannerStyle]) -> ShownSweep:
    known = {kpi.name: kpi for kpi in data.kpis}
    own = [kpi.name for kpi in data.kpis if kpi.group == "user"]
    first = [name for name in dict.fromkeys([*FIRST, *own]) if name in known]
    names = [*first, *(name for name in known if name not in first)]
    rates = common_rate_name(row for row in data.summary.to_dict("records") if _is_of(sweep, row))
    figures = [_figure(sweep, data, styles, "success_rate", _rate_title(rates), Scale(0.0, 1.05))]
    further: list[SweepFigure | None] = []
    for name in names:
        title = value_title(known[name]) + timing_mark(known[name], data)
        figure = _figure(sweep, data, styles, f"{name}_median", title, None)
        (figures if name in first else further).append(figure)
    of_planner = sweep.kind == "planners"
    return ShownSweep(
        title=f"{sweep.of}: {sweep.parameter}",
        note=("Over all scenarios" if of_planner else "A line per planner")
        + ": success rates with 95 % intervals; medians over problems (timing: trials) with quartiles.",
        figures=[figure for figure in figures if figure is not None],
        further=[figure for figure in further if figure is not None],
    )


def _figure(
    sweep: Sweep,
    data: ReportData,
    styles: Mapping[str, PlannerStyle],
    column: str,
    title: str,
    scale: Scale | None,
) -> SweepFigure | None:
    if column not in data.summary:
        return None
    curves = [curve for curve in sweep.curves(data.summary, column) if curve.planner in styles]
    ends = [end for curve in curves for point in curve.points for end in (point.figure, point.low, point.high)]
    figures = np.array(ends)[np.isfinite(ends)]
    if not len(figures):
        return None
    across, up = _across(sweep.values), scale or scale_for(figures)
    says = percent if column == "success_rate" else show
    return SweepFigure(
        title=title,
        x_title=sweep.parameter,
        x_ticks=across.ticks,
        y_ticks=[Tick(round(100 - tick.at, 2), tick.label) for tick in up.ticks(5)],
        lines=[
            SweepLine(
                styles[curve.planner],
                DASHES[curve.family % len(DASHES)] if sweep.lines_per_planner > 1 else styles[curve.planner].dash,
                curve.label,
                *_drawn(curve, across, up, says),
            )
            for curve in curves
        ],
    )


@dataclass(frozen=True)
class _Across:
    """Places of a parameter's values on the axis, 0 to 1."""

    places: Mapping[str, float]
    ticks: Sequence[Tick]


def _across(values: Sequence[Any]) -> _Across:
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        scale = scale_for(np.array(values, dtype=float), may_be_logarithmic=True)
        places = scale.place(np.array(values, dtype=float))
    else:
        places = (np.arange(len(values)) + 0.5) / len(values)
    ticks = [Tick(round(100 * float(at), 2), str(value)) for at, value in zip(places, values, strict=True)]
    return _Across({repr(value): float(at) for at, value in zip(places, values, strict=True)}, ticks)


def _drawn(curve: Curve, across: _Across, up: Scale, says: Any) -> Iterator[Any]:
    """The curve's path, its intervals, and its dots with what they say."""
    x = np.array([across.places[repr(point.value)] for point in curve.points])
    y = 1.0 - up.place(np.array([point.figure for point in curve.points]))
    places = 1000.0 * np.column_stack([x, y])
    low, high = (1000.0 * (1.0 - up.place(np.array(ends))) for ends in _ends(curve))
    yield path_through(places)
    yield "".join(
        f"M{left:.1f} {bottom:.1f}V{top:.1f}"
        for left, bottom, top in zip(places[:, 0], low, high, strict=True)
        if np.isfinite([bottom, top]).all()
    )
    yield [
        (round(float(left), 1), round(float(top), 1), _says(point, says))
        for (left, top), point in zip(places, curve.points, strict=True)
    ]


def _ends(curve: Curve) -> tuple[list[float], list[float]]:
    return [point.low for point in curve.points], [point.high for point in curve.points]


def _says(point: Point, says: Any) -> str:
    """`0.5: 17/22, 77 % (57 % to 90 %)`."""
    spread = f" ({says(point.low)} to {says(point.high)})" if np.isfinite([point.low, point.high]).all() else ""
    return f"{point.value}: {says(point.figure)}{spread}, {point.trials}"


def _is_of(sweep: Sweep, row: Mapping[Any, Any]) -> bool:
    """Whether a row of the summary is drawn in a sweep."""
    if sweep.kind == "planners":
        return row["planner"] in sweep.variants and row["scenario"] == ALL
    return row["scenario"] in sweep.variants


def _rate_title(rates: str) -> str:
    return RATE if rates == RATE else f"{RATE}, {rates}"
