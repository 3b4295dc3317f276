"""The least clearances on the way to each row of a trial, looked for after it: the loop only excludes contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan

from pytest_lpb.environment.engine import Engine, continuous
from pytest_lpb.problem.continuous_collision import CLEARANCE_TOLERANCE_M, least_distance


@dataclass(frozen=True)
class Rows:
    """What a trial went through: q and u of each row, the action applied from it (one less)."""

    q: Sequence[list[float]]
    u: Sequence[list[float]]
    applied: Sequence[list[float]]


def least_on_the_way(
    engine: Engine, rows: Rows, clearance: Sequence[float], margin: float, *, own: bool = False
) -> list[float]:
    """The least clearance on the way to each row, from the row before it on (N + 1,) [m].

    It is found to `CLEARANCE_TOLERANCE_M` in steps on which the least of all may depend, and in those between two rows
    of more than `margin` that may go below it. In others it is that of the nearer row. So is that of all rows where an
    engine does not know what is between them.

    Args:
        engine: has simulated the trial.
        rows: of the trial.
        clearance: of each row [m]; NaN without bodies to measure.
        margin: below which every dip counts [m].
        own: whether `clearance` is that between the robot's own bodies.
    """
    least = [*clearance[:1], *map(min, clearance[:-1], clearance[1:])]
    last = min(len(rows.q) - 1, len(rows.applied))
    motion = continuous(engine)
    if motion is None or last < 1 or isnan(clearance[0]):
        return least
    nearest = min(clearance)
    wanted = max(nearest - CLEARANCE_TOLERANCE_M, margin)
    bounds = []
    for row in range(1, last + 1):
        travel = motion.travel_of(row, rows.u[row - 1], rows.q[row], rows.u[row])[own]
        bound = 0.5 * (clearance[row - 1] + clearance[row] - travel)
        if bound < wanted:
            bounds.append((bound, row))
    for bound, row in sorted(bounds):
        dips = bound < margin <= least[row]
        floor = max(nearest, margin) if dips else nearest
        if bound < floor - CLEARANCE_TOLERANCE_M:
            step = motion.swept_bodies_of(
                row, rows.q[row - 1], rows.u[row - 1], rows.applied[row - 1], (rows.q[row], rows.u[row])
            )
            least[row] = least_distance(step, least[row], floor, own=own)
            nearest = min(nearest, least[row])
    motion.restore()
    return least
