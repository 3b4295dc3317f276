"""Calls timed again, as a table for the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from pytest_lpb.aligned import aligned
from pytest_lpb.names import count
from pytest_lpb.retime.figures import RetimedRow, against
from pytest_lpb.retime.result import Retimed

HEADS = (
    "retimed",
    "planner",
    "trials",
    "calls",
    "p50 [ms]",
    "p95",
    "p99",
    "max",
    "first call",
    "deadline misses",
    "p50 against the fastest",
)


def retimed_table(retimed: Retimed) -> Iterator[str]:
    """One line per scenario and planner, then the noise floor and what it means."""
    rows = [HEADS, *(_cells(row, retimed) for row in retimed.rows)]
    yield from aligned(rows, left=2)
    yield from notes(retimed)


def _cells(row: RetimedRow, retimed: Retimed) -> Sequence[str]:
    times = (row.p50_ms, row.p95_ms, row.p99_ms, row.max_ms, row.first_call_ms)
    return (
        row.scenario,
        f"{row.planner}{' †' if row.contended else ''}",
        str(row.trials),
        str(row.calls),
        *(f"{time:.3g}" for time in times),
        misses(row),
        against(row, retimed.rows),
    )


def misses(row: RetimedRow) -> str:
    """Deadline misses, of how many calls, and the deadline."""
    return f"{row.deadline_misses} of {row.deadline_calls} (> {row.period_ms:g} ms)"


def notes(retimed: Retimed) -> Iterator[str]:
    """What to know when reading the figures."""
    passes = max((row.passes for row in retimed.rows), default=0)
    made = count(passes, "pass", "passes")
    yield f"calls: those recorded, each made in {made}; the first call of a trial is apart (its median)"
    floors = [retimed.floor(figure) for figure in ("p50", "p95")]
    if not any(map(math.isnan, floors)):
        yield (
            f"A/A noise floor of this machine: {percent(floors[0])} of p50, {percent(floors[1])} of p95, "
            "what two passes of the same calls differ by, at most; less between planners is called noise"
        )
    if any(row.contended for row in retimed.rows):
        yield "† these calls had to wait for a processor: no basis for comparisons"


def percent(share: float) -> str:
    """A share in percent, with two digits."""
    return f"{100.0 * share:.2g} %" if share < 1.0 else f"{100.0 * share:.0f} %"
