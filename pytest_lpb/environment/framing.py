"""What a picture holds: robot, goal and path, and what lies near them; what is far away does not shrink it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pytest_lpb.problem.robot import FloatArray

NEAR = 0.15  # sizes of the frame around it within which something is near


def with_neighbours(
    low: FloatArray, high: FloatArray, boxes: Iterable[tuple[FloatArray, FloatArray]]
) -> tuple[FloatArray, FloatArray]:
    """Corners (d,) [m] of a frame that also holds the boxes (corners) near it that are no larger than it."""
    size = float((high - low).max())
    reach = NEAR * size
    found_low, found_high = low, high
    for box_low, box_high in boxes:
        near = (box_low <= high + reach).all() and (box_high >= low - reach).all()
        if near and float((box_high - box_low).max()) <= size:
            found_low, found_high = np.minimum(found_low, box_low), np.maximum(found_high, box_high)
    return found_low, found_high
