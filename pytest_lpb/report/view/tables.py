"""Rows of the tables of comparisons and trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pytest_lpb.report.view.common import Cell, PlannerStyle


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
    known_failure: str = ""  # why it was expected to fail


@dataclass(frozen=True)
class ComparisonSection:
    """The table of comparisons, drawn by the page's script.

    Attributes:
        kpis: (name, title) of what was compared.
        scenarios: names; `all` among them where there are several.
        verdicts: those that occur.
        note: what is left out.
        packed: see `comparison_section`.
    """

    kpis: Sequence[tuple[str, str]]
    scenarios: Sequence[str]
    verdicts: Sequence[str]
    styles: Sequence[PlannerStyle]
    note: str
    packed: str


@dataclass(frozen=True)
class TrialSection:
    """The table of trials."""

    heads: Sequence[str]
    rows: Sequence[TrialRow]
    note: str
    styles: Sequence[PlannerStyle]
    scenarios: Sequence[str]
    outcomes: Sequence[str]


@dataclass(frozen=True)
class TrialPages:
    """What the pages of single trials are made from, by the page's script.

    Attributes:
        index: see `trial_pages.index`.
        replays: (key, packed) of trials, robots and problems; see `replay`.
        note: which trials have time series and a replay.
        spatial: whether a robot in space is among them.
    """

    index: str
    replays: Sequence[tuple[str, str]]
    note: str
    spatial: bool
