"""Performance profiles and interquartile means: planners over all scenarios."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.report.canvas import path_through
from pytest_lpb.report.data import ReportData, ReportedKpi
from pytest_lpb.report.numbers import count, show, show_exact, unit_text
from pytest_lpb.report.scale import LARGEST, Scale
from pytest_lpb.report.titles import compared_title, timing_mark, value_title
from pytest_lpb.report.view import Cell, Line, PlannerStyle, Tick
from pytest_lpb.run.profiles import RATIO, KpiProfile, kpi_profile

FloatArray = NDArray[np.float64]

MAIN = ("time_to_goal_s", "path_length_m", "clearance_min_m", "solver_time_p50_ms")
USER = "user"  # group of users' own KPIs
HEADS = ("scenarios", "problems", "mean of the scenarios' means", "interquartile mean of problems")
MAX_SHOWN_RATIO = 100.0  # beyond, a planner is so far from the best that the rest of the picture would vanish
SHARES = [Tick(float(100 - share), f"{share} %") for share in (0, 25, 50, 75, 100)]


@dataclass(frozen=True)
class ProfileFigure:
    """Curves of one KPI, one per planner, in units of 1/1000 of the axes; bands are areas."""

    title: str
    note: str
    unit: str  # of the axis
    x_ticks: Sequence[Tick]
    y_ticks: Sequence[Tick]
    bands: Sequence[Line]
    lines: Sequence[Line]


@dataclass(frozen=True)
class AggregateRow:
    """One planner and KPI over all scenarios."""

    title: str
    style: PlannerStyle
    over: str
    cells: Sequence[Cell]


@dataclass(frozen=True)
class ProfileSection:
    """Figures of the main KPIs and of users' own, and a table of every KPI."""

    figures: Sequence[ProfileFigure]
    heads: Sequence[str]
    rows: Sequence[AggregateRow]
    styles: Sequence[PlannerStyle]


def profile_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> ProfileSection | None:
    """The section; None without any figure."""
    shown = [kpi for kpi in with_profile(data) if kpi.name in MAIN or kpi.group == USER]
    profiles = [(kpi, profile) for kpi in shown if (profile := profile_of(kpi, data)) is not None]
    figures = [profile_figure(profile, kpi, data, styles) for kpi, profile in profiles]
    rows = list(_rows(data, styles))
    return ProfileSection(figures, HEADS, rows, list(styles.values())) if figures or rows else None


def with_profile(data: ReportData) -> Iterator[ReportedKpi]:
    """KPIs that have a direction and values."""
    for kpi in data.kpis:
        if kpi.direction != "none" and kpi.name in data.trials and profile_of(kpi, data) is not None:
            yield kpi


def profile_of(kpi: ReportedKpi, data: ReportData) -> KpiProfile | None:
    """The profile of a KPI; None where it has none."""
    return kpi_profile(data.trials, kpi) if len(data.trials) else None


def profile_figure(
    profile: KpiProfile, kpi: ReportedKpi, data: ReportData, styles: Mapping[str, PlannerStyle]
) -> ProfileFigure:
    """A profile as lines and areas."""
    scale = axis_of(profile)
    across = 1000 * scale.place(profile.bounds)
    lines, bands = [], []
    for planner, curve in profile.curves.items():
        share, low, high = (1000 * (1 - values) for values in (curve.share, curve.low, curve.high))
        there, back = np.column_stack([across, low]), np.column_stack([across, high])[::-1]
        lines.append(Line(styles[planner], path_through(np.column_stack([across, share]))))
        bands.append(Line(styles[planner], path_through(np.concatenate([there, back]), closed=True)))
    return ProfileFigure(
        title=value_title(kpi) + timing_mark(kpi, data),
        note=explained(profile),
        unit="x" if profile.kind == RATIO else unit_text(profile.unit),
        x_ticks=scale.ticks(6),
        y_ticks=SHARES,
        bands=bands,
        lines=lines,
    )


def axis_of(profile: KpiProfile) -> Scale:
    """The axis of the bounds: of ratios from 1 on, logarithmic from a factor of 5 on."""
    low, high = float(profile.bounds.min()), float(profile.bounds.max())
    if profile.kind == RATIO:
        return Scale(1.0, min(high, MAX_SHOWN_RATIO), logarithmic=high > 5.0)
    return Scale(max(low, -LARGEST), min(high, LARGEST))


def explained(profile: KpiProfile) -> str:
    """What a profile shows, and over how much."""
    within = "within a factor of the best planner's on the same problem"
    if profile.kind != RATIO:
        within = "of at least the bound" if profile.at_least else "of at most the bound"
    over = f"{count(profile.problems, 'problem')}, {count(profile.scenarios, 'scenario')}"
    return f"share of problems with a value {within}; {over}"


def _rows(data: ReportData, styles: Mapping[str, PlannerStyle]) -> Iterator[AggregateRow]:
    kpis = {kpi.name: kpi for kpi in data.kpis}
    for row in data.aggregates.to_dict("records"):
        if row["problems"] == 0:
            continue
        kpi = kpis[row["kpi"]]
        interval = "" if math.isnan(row["iqm_low"]) else f"95 %: {show(row['iqm_low'])} to {show(row['iqm_high'])}"
        yield AggregateRow(
            title=compared_title(kpi) + timing_mark(kpi, data),
            style=styles[str(row["planner"])],
            over="solved by all" if row["over"] == "solved" else "",
            cells=[
                Cell(show_exact(row["scenarios"]), float(row["scenarios"])),
                Cell(show_exact(row["problems"]), float(row["problems"])),
                Cell(show(row["mean_of_scenarios"]), float(row["mean_of_scenarios"])),
                Cell(show(row["iqm"]), float(row["iqm"]), interval),
            ],
        )
