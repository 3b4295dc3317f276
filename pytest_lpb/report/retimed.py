"""The section about calls timed again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pytest_lpb.names import count
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import show, show_exact
from pytest_lpb.report.provenance import moment
from pytest_lpb.report.titles import MARK
from pytest_lpb.report.view import Cell, PlannerStyle
from pytest_lpb.retime.figures import RetimedRow, against
from pytest_lpb.retime.text import notes

HEADS = (
    "trials",
    "calls",
    "p50 [ms]",
    "p95 [ms]",
    "p99 [ms]",
    "max [ms]",
    "first call [ms]",
    "deadline misses",
    "p50 against the fastest",
)


@dataclass(frozen=True)
class RetimedEntry:
    """One planner in one scenario."""

    scenario: str
    style: PlannerStyle
    cells: Sequence[Cell]


@dataclass(frozen=True)
class RetimedSection:
    """Table, and what to know of it."""

    heads: Sequence[str]
    entries: Sequence[RetimedEntry]
    measured: str
    notes: Sequence[str]
    warnings: Sequence[str]


def retimed_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> RetimedSection | None:
    """The section; None where no calls were timed again."""
    retimed = data.retimed
    if retimed is None or not retimed.rows:
        return None
    entries = [RetimedEntry(row.scenario, styles[row.planner], _cells(row, retimed.rows)) for row in retimed.rows]
    where = f" on {retimed.machine}" if retimed.machine else ""
    return RetimedSection(
        heads=HEADS,
        entries=entries,
        measured=f"Measured {moment(retimed.moment)}{where}, one process, one thread for linear algebra.",
        notes=list(notes(retimed)),
        warnings=list(retimed.warnings),
    )


def _cells(row: RetimedRow, rows: Sequence[RetimedRow]) -> list[Cell]:
    fastest = min(other.p50_ms for other in rows if other.scenario == row.scenario)
    waited, mark = ("waited for a processor", MARK) if row.contended else ("", "")
    different = f"{row.different_trials} with other actions" if row.different_trials else ""
    return [
        Cell(str(row.trials), row.trials, different),
        Cell(show_exact(row.calls), row.calls, count(row.passes, "pass", "passes")),
        Cell(show(row.p50_ms), row.p50_ms, waited, mark),
        *(Cell(show(value), value, mark=mark) for value in (row.p95_ms, row.p99_ms, row.max_ms)),
        Cell(show(row.first_call_ms), row.first_call_ms, f"at most {show(row.first_call_max_ms)}", mark),
        Cell(
            f"{show_exact(row.deadline_misses)} of {show_exact(row.deadline_calls)}",
            row.deadline_misses / row.deadline_calls,
            f"period {show_exact(row.period_ms)} ms",
        ),
        Cell(against(row, rows), row.p50_ms / fastest),
    ]
