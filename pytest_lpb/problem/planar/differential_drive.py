"""A cart with two driven wheels. q = (x, y, theta), u = (v, w) in the body frame: x forward, w > 0 turns left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, cos, sin
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pytest_lpb.problem.planar.robot import Frame, PlanarRobot, Scalar
from pytest_lpb.problem.robot import CollisionBody, FloatArray

# Gauss-Legendre nodes: exact to rounding while the heading changes by at most MAX_TURN within a piece.
_NODES = tuple(zip(*(array.tolist() for array in np.polynomial.legendre.leggauss(8)), strict=True))
_MAX_TURN = 0.5  # [rad]
_MAX_PIECES = 1000  # a planner that diverges must not stop the clock: beyond, a step is not resolved
_STRAIGHT = 1e-4  # [rad] below this turn sin(x)/x is taken from its series


class DifferentialDrive(PlanarRobot):
    """Differential drive with the single link `base`, a disc of `body_radius`."""

    def __init__(self, entry: Mapping[str, Any]) -> None:
        self.wheel_base = float(entry["wheel_base"])  # [m] separation of the wheels
        super().__init__(entry)

    def _joints(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        return ("x", "y", "theta"), ("prismatic", "prismatic", "revolute")

    def _links(self) -> tuple[str, ...]:
        return ("base",)

    def _count_actions(self) -> int:
        return 2

    @property
    def action_kinds(self) -> tuple[str, ...]:
        """v is the rate of a length, w of an angle."""
        return ("prismatic", "revolute")

    @property
    def action_names(self) -> tuple[str, ...]:
        """Forward speed and turning rate."""
        return ("v", "w")

    def _geometry(self) -> tuple[CollisionBody, ...]:
        return (CollisionBody("base", "base", ((0.0, 0.0, 0.0, 0.0, self.body_radius),)),)

    def _adjacent(self, first: str, second: str) -> bool:
        return first == second

    def frames(self, q: Sequence[Any], cos: Scalar = cos, sin: Scalar = sin) -> list[Frame]:
        """The base's frame, x forward."""
        return [(q[0], q[1], cos(q[2]), sin(q[2]))]

    def joint_velocity(self, q: Sequence[float], u: list[float]) -> list[float]:
        """qd = (v cos theta, v sin theta, w)."""
        return [u[0] * cos(q[2]), u[0] * sin(q[2]), u[1]]

    def wheel_speeds(self, u: Sequence[float]) -> tuple[float, float]:
        """Ground speeds of the left and right wheel [m/s] at u = (v, w)."""
        half = 0.5 * self.wheel_base * u[1]
        return u[0] - half, u[0] + half

    def integrate(
        self, q: list[float], u: list[float], action: list[float], dt: float
    ) -> tuple[list[float], list[float]]:
        """State after dt [s]: an arc under a constant (v, w), a generalised clothoid under constant (dv, dw)."""
        return drive(self.control, q, u, action, dt)

    def link_speeds(self, before: list[float], after: list[float]) -> list[tuple[float, float]]:
        """The larger of both |v| and of both |w|."""
        return [(max(abs(before[0]), abs(after[0])), max(abs(before[1]), abs(after[1])))]

    def action_map(self, q: ArrayLike) -> FloatArray:
        """B with qd = B u, (3, 2)."""
        theta = float(np.asarray(q, dtype=float)[2])
        return np.array([[cos(theta), 0.0], [sin(theta), 0.0], [0.0, 1.0]])

    def jacobian(self, q: ArrayLike, link: str) -> FloatArray:  # noqa: ARG002 - constant
        """Velocity of the base per qd, (3, 3)."""
        self.link_index(link)
        return np.eye(3)

    def link_positions(self, q: FloatArray) -> FloatArray:
        """Positions of the base along a trajectory, (N, 1, 2) [m]."""
        return q[:, None, :2]


def drive(
    control: str, q: Sequence[float], u: Sequence[float], action: Sequence[float], dt: float
) -> tuple[list[float], list[float]]:
    """Pose (x, y, theta) and (v, w) after dt [s] under a constant action: (v, w), or their rates."""
    if control == "velocity":
        return _arc(q, action[0], action[1], dt), list(action)
    after = [u[0] + action[0] * dt, u[1] + action[1] * dt]
    if not any(action):
        return _arc(q, u[0], u[1], dt), after
    turn = abs(u[1]) * dt + abs(action[1]) * dt * dt
    pieces = max(1, ceil(min(turn / _MAX_TURN, _MAX_PIECES)))
    return _clothoid(q, u, action, dt, pieces), after


def _arc(q: Sequence[float], v: float, w: float, dt: float) -> list[float]:
    """Pose after moving along a circle: the chord has length v dt sin(h)/h at the mean heading, h = w dt / 2."""
    half = 0.5 * w * dt
    ratio = sin(half) / half if abs(half) > _STRAIGHT else 1.0 - half * half / 6.0
    chord = v * dt * ratio
    return [q[0] + chord * cos(q[2] + half), q[1] + chord * sin(q[2] + half), q[2] + w * dt]


def _clothoid(q: Sequence[float], u: Sequence[float], action: Sequence[float], dt: float, pieces: int) -> list[float]:
    """Pose after constant accelerations: the integral of v(t) (cos, sin)(theta(t)) by Gauss-Legendre quadrature."""
    x = y = 0.0
    half = 0.5 * dt / pieces
    for piece in range(pieces):
        middle = (2 * piece + 1) * half
        for node, weight in _NODES:
            t = middle + half * node
            theta = q[2] + (u[1] + 0.5 * action[1] * t) * t
            speed = weight * (u[0] + action[0] * t)
            x += speed * cos(theta)
            y += speed * sin(theta)
    return [q[0] + half * x, q[1] + half * y, q[2] + (u[1] + 0.5 * action[1] * dt) * dt]
