"""Success bars and distributions of KPIs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pytest_lpb.report.view.common import PlannerStyle, Tick


@dataclass(frozen=True)
class BarRow:
    """A rate with its interval, all in [%]."""

    style: PlannerStyle
    rate: float | None
    low: float | None
    high: float | None
    label: str


@dataclass(frozen=True)
class BoxRow:
    """A distribution in units of 1/1000 of the axis: points, and a box where there are enough of them."""

    style: PlannerStyle
    points: str  # SVG path of dots
    median: float
    box: tuple[float, float] | None  # quartiles
    whiskers: tuple[float, float] | None
    label: str
    number: int  # trials with a value
    description: str


@dataclass(frozen=True)
class BarGroup:
    """Success of every planner in one scenario."""

    name: str
    rows: Sequence[BarRow]


@dataclass(frozen=True)
class BoxGroup:
    """One KPI of every planner in one scenario."""

    name: str
    rows: Sequence[BoxRow]


@dataclass(frozen=True)
class KpiFigure:
    """Distributions of one KPI."""

    name: str
    title: str
    group: str
    notes: Sequence[str]
    ticks: Sequence[Tick]
    zero: float | None  # [1/1000] where zero lies
    groups: Sequence[BoxGroup]


@dataclass(frozen=True)
class KpiSection:
    """Success and every KPI.

    Attributes:
        options: (group, KPI name, title) of the figures.
        without_values: names of KPIs that apply nowhere in the run.
        packed: the figures, drawn by the page's script; see `kpi_section`.
    """

    options: Sequence[tuple[str, str, str]]
    without_values: Sequence[str]
    packed: str
