"""The view models that the templates draw: text and places, ready to show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pytest_lpb.report.retimed import RetimedSection


@dataclass(frozen=True)
class PlannerStyle:
    """How a planner looks in every figure."""

    name: str
    number: int  # place among the planners
    colour: int  # number of a CSS colour variable
    dash: str  # SVG stroke-dasharray; empty: solid
    marker: str  # SVG path around (0, 0)


@dataclass(frozen=True)
class Tick:
    """A labelled place on an axis."""

    at: float  # [%] of the axis, or [px] in a scene
    label: str


@dataclass(frozen=True)
class Statement:
    """One sentence of the overview about one planner."""

    style: PlannerStyle
    text: str
    detail: str


@dataclass(frozen=True)
class Cell:
    """A number in a table: as shown, as sorted, and what there is to know about it."""

    text: str
    value: float | None = None
    note: str = ""
    mark: str = ""


@dataclass(frozen=True)
class MatrixRow:
    """Success of each planner in one scenario."""

    scenario: str
    cells: Sequence[Cell]


@dataclass(frozen=True)
class PlannerRow:
    """One planner in the summary table."""

    style: PlannerStyle
    cells: Sequence[Cell]


@dataclass(frozen=True)
class Share:
    """A part of a stacked bar."""

    outcome: str
    count: int
    percent: float


@dataclass(frozen=True)
class OutcomeBar:
    """How one planner's trials ended."""

    style: PlannerStyle
    shares: Sequence[Share]


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
class ComparisonRow:
    """What two planners differ by in one KPI."""

    a: PlannerStyle
    b: PlannerStyle
    scenario: str
    kpi: str
    title: str
    over: str
    verdict: str
    cells: Sequence[Cell]


@dataclass(frozen=True)
class TrialRow:
    """One trial in the table of trials."""

    node_id: str
    scenario: str
    style: PlannerStyle
    seed: int
    outcome: str
    success: bool
    cells: Sequence[Cell]
    message: str
    failed_criteria: str
    command: str


@dataclass(frozen=True)
class UserFigure:
    """A user's plot as an image, or why it could not be drawn."""

    title: str
    image: str  # data URI
    error: str = ""


@dataclass(frozen=True)
class Fact:
    """A line about the run: machine, version, command."""

    name: str
    text: str


@dataclass(frozen=True)
class PlannerSetup:
    """A planner's configuration as it ran."""

    style: PlannerStyle
    planner: str
    parameters: str
    facts: Sequence[Fact]


@dataclass(frozen=True)
class Provenance:
    """Where the numbers come from."""

    facts: Sequence[Fact]
    planners: Sequence[PlannerSetup]
    packages: Sequence[Fact]
    scenarios: Sequence[Fact]


@dataclass(frozen=True)
class Page:
    """Everything on the page, in reading order."""

    title: str
    subtitle: str
    styles: Sequence[PlannerStyle]
    statements: Sequence[Statement]
    notes: Sequence[str]
    warnings: Sequence[str]
    timing_contended: bool
    matrix_styles: Sequence[PlannerStyle]
    matrix: Sequence[MatrixRow]
    summary_heads: Sequence[str]
    summary: Sequence[PlannerRow]
    outcomes: Sequence[OutcomeBar]
    success: Sequence[BarGroup]
    kpi_figures: Sequence[KpiFigure]
    kpis_without_values: Sequence[str]
    comparison_heads: Sequence[str]
    comparisons: Sequence[ComparisonRow]
    comparisons_note: str
    scenes: Sequence[Scene]
    user_figures: Sequence[UserFigure]
    trial_heads: Sequence[str]
    trials: Sequence[TrialRow]
    trials_note: str
    provenance: Provenance
    retimed: RetimedSection | None = None
    scenario_names: Sequence[str] = field(default_factory=tuple)
    outcome_names: Sequence[str] = field(default_factory=tuple)
