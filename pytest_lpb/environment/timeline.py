"""Where moving things are at each row: motions evaluated in blocks, so that a step only copies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_lpb.motion import Motion
from pytest_lpb.problem.robot import FloatArray

BLOCK = 512  # rows evaluated at once


class Timeline:
    """States of several motions of one size at the rows t = k dt.

    Args:
        motions: n motions of `size` coordinates each.
        size: coordinates of each motion.
        dt: step [s].
    """

    def __init__(self, motions: Sequence[Motion], size: int, dt: float) -> None:
        self._motions = motions
        self._size = size
        self._dt = dt
        self._first = 0
        self.moving = any(motion.moving for motion in motions)
        self._block = self._evaluate(self._times(0, BLOCK if self.moving else 1))

    def at(self, row: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity and acceleration, each (n, size), at t = row dt."""
        if not self.moving:
            row = 0
        elif not self._first <= row < self._first + BLOCK:
            self._first = row - row % BLOCK
            self._block = self._evaluate(self._times(self._first, BLOCK))
        index = row - self._first
        position, velocity, acceleration = self._block
        return position[index], velocity[index], acceleration[index]

    def _times(self, first: int, count: int) -> FloatArray:
        return np.arange(first, first + count, dtype=np.float64) * self._dt

    def positions(self, times: FloatArray) -> FloatArray:
        """Positions at times (m,) [s]: (n, m, size)."""
        return np.swapaxes(self._evaluate(times)[0], 0, 1)

    def _evaluate(self, times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        states = np.zeros((3, len(times), len(self._motions), self._size))
        for index, motion in enumerate(self._motions):
            states[:, :, index] = motion.evaluate(times)
        return states[0], states[1], states[2]
