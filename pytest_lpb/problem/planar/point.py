"""A point mass in the plane: a disc that moves in any direction. q = (x, y)."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, sin
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pytest_lpb.problem.planar.robot import Frame, PlanarRobot, Scalar, integrate_holonomic
from pytest_lpb.problem.robot import CollisionBody, FloatArray


class Point(PlanarRobot):
    """Planar point with the single link `body`."""

    def _joints(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        return ("x", "y"), ("prismatic", "prismatic")

    def _links(self) -> tuple[str, ...]:
        return ("body",)

    def _geometry(self) -> tuple[CollisionBody, ...]:
        return (CollisionBody("body", "body", ((0.0, 0.0, 0.0, 0.0, self.body_radius),)),)

    def _adjacent(self, first: str, second: str) -> bool:
        return first == second

    def frames(self, q: Sequence[Any], cos: Scalar = cos, sin: Scalar = sin) -> list[Frame]:  # noqa: ARG002 - it does not turn
        """The body's frame; it does not turn."""
        return [(q[0], q[1], 1.0, 0.0)]

    def integrate(
        self, q: list[float], u: list[float], action: list[float], dt: float
    ) -> tuple[list[float], list[float]]:
        """State after dt [s] under the constant action, exact."""
        return integrate_holonomic(self.control, q, u, action, dt)

    def link_speeds(self, before: list[float], after: list[float]) -> list[tuple[float, float]]:
        """The larger of both speeds: between them it is smaller; nothing turns."""
        return [(max(hypot(*before), hypot(*after)), 0.0)]

    def jacobian(self, q: ArrayLike, link: str) -> FloatArray:  # noqa: ARG002 - constant
        """Velocity of the body per qd, (3, 2); it never turns."""
        self.link_index(link)
        return np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])

    def link_positions(self, q: FloatArray) -> FloatArray:
        """Positions of the body along a trajectory, (N, 1, 2) [m]."""
        return q[:, None, :2]
