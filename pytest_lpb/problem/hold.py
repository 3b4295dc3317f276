"""When a goal counts as reached: the first interval of rows within tolerance that lasts the hold time."""

import math

import numpy as np
from numpy.typing import NDArray

# ceil(0.5 / 0.05) must be 10 although the quotient may come out a rounding error above it.
_ROUNDING = 1e-9


def rows_to_hold(hold_time: float | str, dt: float) -> int | None:
    """Steps that span `hold_time`, for `first_held_row`.

    Args:
        hold_time: [s], or "end": to the last row.
        dt: step [s].

    Returns:
        The number of steps, rounded up; None for "end".
    """
    if isinstance(hold_time, str):
        return None
    return math.ceil(hold_time / dt - _ROUNDING)


def first_held_row(within: NDArray[np.bool_], hold_rows: int | None) -> int | None:
    """First row of the first interval of rows that are all within tolerance.

    Args:
        within: whether every sub-goal is within its tolerance, (N + 1,).
        hold_rows: the interval is rows k .. k + hold_rows; None: k .. N.

    Returns:
        k, or None when there is no such interval.

    Raises:
        ValueError: hold_rows is negative.
    """
    rows = len(within)
    if hold_rows is None:
        outside = np.flatnonzero(~within)
        first = int(outside[-1]) + 1 if len(outside) else 0
        return first if first < rows else None
    if hold_rows < 0:
        raise ValueError(f"hold_rows is {hold_rows}; allowed is 0 or more")
    if hold_rows >= rows:
        return None
    counts = np.concatenate(([0], np.cumsum(within)))
    starts = np.flatnonzero(counts[hold_rows + 1 :] - counts[: rows - hold_rows] == hold_rows + 1)
    return int(starts[0]) if len(starts) else None
