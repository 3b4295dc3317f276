"""The picture of a scenario."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pytest_lpb.report.view.common import PlannerStyle, Tick


@dataclass(frozen=True)
class Mark:
    """A path in a scene."""

    d: str
    css: str
    style: PlannerStyle | None = None
    width: float | None = None  # [px] stroke width where it is a size, such as a robot's link
    title: str = ""
    at: tuple[float, float] | None = None  # [px] where a marker lies; its path is around (0, 0)


@dataclass(frozen=True)
class Panel:
    """One view of a scene: marks from back to front, axes in [px]."""

    title: str
    width: float
    height: float
    left: float
    top: float
    right: float
    bottom: float
    x_label: str
    y_label: str
    x_ticks: Sequence[Tick]
    y_ticks: Sequence[Tick]
    marks: Sequence[Mark]


@dataclass(frozen=True)
class Line:
    """A curve in a timeline, in units of 1/1000 of its axes."""

    style: PlannerStyle
    d: str


@dataclass(frozen=True)
class Timeline:
    """A quantity over time, one line per planner."""

    title: str
    x_ticks: Sequence[Tick]
    y_ticks: Sequence[Tick]
    lines: Sequence[Line]
    limit: float | None  # [1/1000] from the top
    limit_label: str


@dataclass(frozen=True)
class SceneEntry:
    """One planner in a scene's legend."""

    style: PlannerStyle
    text: str
    outcome: str


@dataclass(frozen=True)
class Scene:
    """The picture of one scenario, with all planners."""

    number: int
    scenario: str
    caption: str
    panels: Sequence[Panel]
    timelines: Sequence[Timeline]
    entries: Sequence[SceneEntry]
    legend: Sequence[tuple[str, str]]  # (symbol, meaning)
    notes: Sequence[str]


@dataclass(frozen=True)
class ScenarioSection:
    """The picture of every scenario."""

    styles: Sequence[PlannerStyle]
    scenes: Sequence[Scene]
