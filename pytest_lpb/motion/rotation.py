"""How an obstacle turns: an angle in the plane, a unit quaternion wxyz in space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion.directions import unit
from pytest_lpb.motion.jets import FloatArray
from pytest_lpb.motion.motion import ExpressionMotion, FixedMotion, Motion
from pytest_lpb.motion.normalised import NormalisedMotion

Orientation = float | str | Sequence[float] | Mapping[str, Any]


class AxisTurn(Motion):
    """The quaternion (m = 4) of a turn about a fixed axis by an angle that may depend on time.

    Args:
        axis: of any length but zero.
        angle: [rad], a number or an expression in t.
    """

    size = 4

    def __init__(self, axis: Sequence[float], angle: float | str) -> None:
        direction = np.array(axis, dtype=np.float64)
        if not direction.any():
            raise ScenarioError("the axis is a vector of zeros; it has no direction")
        with np.errstate(over="ignore"):
            length = np.linalg.norm(direction)
        self._axis = unit(direction, length)
        self._angle = angle_motion(angle)
        self.moving = self._angle.moving

    def evaluate(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Quaternion wxyz and its derivatives, see `Motion.evaluate`; NaN where the angle is not finite."""
        half, rate, change = (0.5 * values for values in self._angle.evaluate(t))
        with np.errstate(over="ignore", invalid="ignore"):
            along = np.concatenate([np.cos(half), np.sin(half) * self._axis], axis=1)
            across = np.concatenate([-np.sin(half), np.cos(half) * self._axis], axis=1)
            return along, rate * across, change * across - rate * rate * along

    def speed_bound(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Half of the bound of the angle's rate, see `Motion.speed_bound`."""
        return 0.5 * self._angle.speed_bound(start, end)

    def component_name(self, index: int) -> str:  # noqa: ARG002 - the angle is what was written
        """The angle itself."""
        return self._angle.component_name(0)


def angle_motion(orientation: float | str) -> Motion:
    """The motion (m = 1) of a planar orientation: an angle [rad], or an expression in t."""
    return ExpressionMotion([orientation]) if isinstance(orientation, str) else FixedMotion([orientation])


def turning_motion(orientation: Any) -> Motion:
    """The motion (m = 4) of an orientation in space: a quaternion wxyz, or {axis, angle}."""
    if isinstance(orientation, Mapping):
        return AxisTurn(orientation["axis"], orientation["angle"])
    return NormalisedMotion(FixedMotion(orientation))
