"""Arrays as short lists of whole numbers: quantised, and each the difference to the one before it."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def listed(values: FloatArray, step: float) -> dict[str, Any]:
    """An array (N,) or (N, M) to a multiple of `step`, column after column; None where it is not finite.

    Read back: the running sum of the differences, None left out, times `s`.
    """
    matrix = values[:, None] if values.ndim == 1 else values
    known = np.isfinite(matrix)
    whole = np.round(np.where(known, matrix, 0.0) / step).astype(np.int64)
    differences: list[int | None] = []
    for column, present in zip(whole.T, known.T, strict=True):
        changes = np.diff(column[present], prepend=0)
        full = np.full(len(column), None, dtype=object)
        full[present] = changes.tolist()
        differences += full.tolist()
    return {"s": float(f"{step:.6g}"), "n": len(matrix), "d": differences}


def fine_step(values: FloatArray, parts: int) -> float:
    """A step that divides the range of the finite values into `parts`; 1 where they do not differ."""
    known = values[np.isfinite(values)]
    span = float(known.max() - known.min()) if len(known) else 0.0
    largest = float(np.abs(known).max()) if len(known) else 0.0
    # Whole numbers up to 2^53 are exact in JSON and in JavaScript.
    return max(span / parts, largest / 2.0**50) or 1.0


def thinned_rows(values: FloatArray, most: int) -> NDArray[np.intp]:
    """At most about `most` rows of a series (N,), among them the smallest and the largest of each stretch.

    The first and last finite rows are kept, and a row that is not finite wherever a stretch has no other.
    """
    count = len(values)
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, most // 2 + 1).astype(int)
    known = np.isfinite(values)
    low, high = np.where(known, values, np.inf), np.where(known, values, -np.inf)
    rows = [
        row
        for begin, end in pairwise(edges)
        for row in (begin + int(low[begin:end].argmin()), begin + int(high[begin:end].argmax()))
    ]
    return np.unique([0, *rows, count - 1])


def needed_rows(t: FloatArray, values: FloatArray, tolerance: float) -> NDArray[np.intp]:
    """Rows of a series (N,) over t (N,) whose straight lines pass every row within `tolerance`.

    Ramer, Douglas and Peucker's algorithm with distances along the values' axis; the first and last rows, the
    smallest and the largest are kept.
    """
    if len(values) < 3:
        return np.arange(len(values))
    kept = {0, len(values) - 1, int(values.argmin()), int(values.argmax())}
    open_stretches = list(pairwise(sorted(kept)))
    while open_stretches:
        begin, end = open_stretches.pop()
        inner = slice(begin + 1, end)
        off = np.abs(values[inner] - np.interp(t[inner], t[[begin, end]], values[[begin, end]]))
        if len(off) and off.max() > tolerance:
            worst = begin + 1 + int(off.argmax())
            kept.add(worst)
            open_stretches += [(begin, worst), (worst, end)]
    return np.array(sorted(kept))


def changed_rows(values: FloatArray, tolerance: float) -> NDArray[np.intp]:
    """Rows of a series (N,) that differ from the one kept before by more than `tolerance`; the first and the last."""
    kept: list[int] = []
    for row, value in enumerate(values.tolist()):
        if not kept or abs(value - values[kept[-1]]) > tolerance:
            kept.append(row)
    return np.unique([*kept, len(values) - 1]) if kept else np.arange(0)
