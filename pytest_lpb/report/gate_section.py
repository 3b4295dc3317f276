"""The section about the regression gate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pytest_lpb.names import count
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.gate_text import (
    HEADS,
    change_texts,
    conclusion,
    doubt,
    left_out_lines,
    notes,
    subject,
    verdict_cells,
)
from pytest_lpb.report.view import PlannerStyle
from pytest_lpb.run.gate import INCONCLUSIVE, REGRESSED, SAME, GateVerdict

MAX_CHANGES = 50  # rows of problems below a verdict
# How the comparisons' verdicts look, which say the same.
LOOKS = {SAME: "better", REGRESSED: "worse", INCONCLUSIVE: "inconclusive"}


@dataclass(frozen=True)
class GateEntry:
    """One verdict."""

    style: PlannerStyle
    kpi: str
    cells: Sequence[str]
    verdict: str
    look: str


@dataclass(frozen=True)
class ChangedProblem:
    """A problem on which a planner is worse than its baseline."""

    scenario: str
    seed: int
    old: str
    new: str
    node_id: str
    command: str


@dataclass(frozen=True)
class ChangedProblems:
    """Those of a KPI that regressed."""

    title: str
    problems: Sequence[ChangedProblem]


@dataclass(frozen=True)
class GateSection:
    """Table of verdicts, what to know of them, and which problems changed."""

    conclusion: str
    baseline: str
    closed: bool
    heads: Sequence[str]
    entries: Sequence[GateEntry]
    notes: Sequence[str]
    changes: Sequence[ChangedProblems]


def gate_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> GateSection | None:
    """The section; None where nothing was compared with a baseline."""
    gate = data.gate
    if gate is None or not gate.verdicts:
        return None
    doubts = [f"{subject(entry)}: {doubt(entry)}" for entry in gate.verdicts if entry.verdict == INCONCLUSIVE]
    return GateSection(
        conclusion=conclusion(gate),
        baseline=gate.baseline,
        closed=gate.closed,
        heads=HEADS[2:-1],
        entries=[_entry(verdict, styles) for verdict in gate.verdicts],
        notes=[*doubts, *left_out_lines(gate), *notes(gate)],
        changes=[_changes(verdict) for verdict in gate.verdicts if verdict.verdict == REGRESSED],
    )


def _entry(verdict: GateVerdict, styles: Mapping[str, PlannerStyle]) -> GateEntry:
    _, kpi, *cells, text = verdict_cells(verdict)
    return GateEntry(styles[verdict.planner], kpi, cells, text, LOOKS[verdict.verdict])


def _changes(verdict: GateVerdict) -> ChangedProblems:
    shown = verdict.changes[:MAX_CHANGES]
    more = f"; the worst {len(shown)} of them" if len(verdict.changes) > len(shown) else ""
    return ChangedProblems(
        title=f"{subject(verdict)}: worse on {len(verdict.changes)} of {count(verdict.problems, 'problem')}{more}",
        problems=[
            ChangedProblem(
                change.scenario, change.seed, *change_texts(verdict.margin, change), change.node_id, change.command
            )
            for change in shown
        ],
    )
