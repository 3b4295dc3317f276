"""The top of the page: who solved what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pytest_lpb.report.view.common import Cell, PlannerStyle


@dataclass(frozen=True)
class Statement:
    """One sentence of the overview about one planner."""

    style: PlannerStyle
    text: str
    detail: str


@dataclass(frozen=True)
class MatrixRow:
    """Success of each planner in one scenario."""

    scenario: str
    cells: Sequence[Cell]
    is_scenario: bool = True  # else the mean over all of them


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
class HeatMap:
    """What the heat map can show, one KPI at a time; drawn by the page's script.

    Attributes:
        options: (group, KPI name, title) of what can be chosen.
        packed: see `heat.heat_map`.
    """

    options: Sequence[tuple[str, str, str]]
    packed: str


@dataclass(frozen=True)
class KnownFailure:
    """A failure that files expect, of one planner in one scenario."""

    scenario: str
    style: PlannerStyle
    reason: str
    failed: int  # trials that failed as foretold
    trials: int  # of the planner in the scenario


@dataclass(frozen=True)
class Winner:
    """Who is ahead in one scenario (`all`: over all of them), and by what."""

    scenario: str
    styles: Sequence[PlannerStyle]  # none: nobody solved anything
    text: str
    standing: str  # ahead, equal, undecided, nobody


@dataclass(frozen=True)
class Overview:
    """Everything of the overview."""

    warnings: Sequence[str]
    notes: Sequence[str]
    statements: Sequence[Statement]
    winners_summary: str
    winners: Sequence[Winner]
    matrix_styles: Sequence[PlannerStyle]
    matrix: Sequence[MatrixRow]
    heat: HeatMap | None
    summary_heads: Sequence[str]
    summary: Sequence[PlannerRow]
    outcomes: Sequence[OutcomeBar]
    several_scenarios: bool
