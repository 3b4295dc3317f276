"""A motion on the unit sphere: what a quaternion's target or an obstacle's orientation does."""

from __future__ import annotations

import numpy as np

from pytest_lpb.motion.directions import LONGEST, SHORTEST
from pytest_lpb.motion.jets import FloatArray
from pytest_lpb.motion.motion import Motion


class NormalisedMotion(Motion):
    """Another motion brought to length one, with the derivatives that follow."""

    def __init__(self, motion: Motion) -> None:
        self._motion = motion
        self.size = motion.size
        self.moving = motion.moving

    def evaluate(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Unit vector n = p / |p| and its derivatives, see `Motion.evaluate`; NaN where p is zero."""
        p, v, a = self._motion.evaluate(t)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            length = np.sqrt((p * p).sum(axis=1, keepdims=True))
            if not ((length > SHORTEST) & (length < LONGEST)).all():
                # All three over one number leave the direction and its derivatives as they are.
                largest = np.abs(p).max(axis=1, keepdims=True)
                p, v, a = p / largest, v / largest, a / largest
                length = np.sqrt((p * p).sum(axis=1, keepdims=True))
            n = p / length
            speed = (n * v).sum(axis=1, keepdims=True)  # d|p|/dt
            first = (v - speed * n) / length
            change = (first * v).sum(axis=1, keepdims=True) + (n * a).sum(axis=1, keepdims=True)  # d2|p|/dt2
            second = (a - 2.0 * speed * first - change * n) / length
        return n, first, second

    def speed_bound(self, start: FloatArray, end: FloatArray) -> FloatArray:  # noqa: ARG002 - at all times alike
        """Zeros for what stands, else none: how near to zero a moving vector comes is not looked at."""
        return np.full(len(start), np.inf if self.moving else 0.0)

    def component_name(self, index: int) -> str:
        """As the motion itself calls it."""
        return self._motion.component_name(index)
