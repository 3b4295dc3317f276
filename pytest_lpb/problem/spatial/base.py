"""Bases of spatial robots: which entries of q and u are theirs, and how they move. Scalars, for the trial loop."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import ceil, cos, hypot, inf, pi, sin, tan
from typing import ClassVar

import numpy as np

from pytest_lpb.problem.planar.differential_drive import drive
from pytest_lpb.problem.planar.robot import integrate_holonomic
from pytest_lpb.problem.robot import FloatArray

State = tuple[list[float], list[float]]

POSE_JOINTS = ("x", "y", "theta")
POSE_KINDS = ("prismatic", "prismatic", "revolute")


class Base(ABC):
    """A base; q and u below are the base's own entries, which come before those of the arm.

    Args:
        control: acceleration, velocity or torque.
        wheel_base: axle distance of a bicycle, wheel separation of a differential drive [m].
    """

    joints: ClassVar[tuple[str, ...]] = ()
    kinds: ClassVar[tuple[str, ...]] = ()  # of the joints: prismatic [m] or revolute [rad]
    actions: ClassVar[tuple[str, ...]] = ()
    action_kinds: ClassVar[tuple[str, ...]] = ()

    def __init__(self, control: str, wheel_base: float) -> None:
        self.control = control
        self.wheel_base = wheel_base

    @abstractmethod
    def integrate(self, q: list[float], u: list[float], action: list[float], dt: float) -> State:
        """State after dt [s] under a constant action: du/dt under acceleration control, else u itself."""

    @abstractmethod
    def peak_rates(self, before: Sequence[float], after: Sequence[float], steepest: float) -> list[float]:
        """Bounds of the rates of the base's entries of q while u changes linearly between two values.

        The bound of the speed in the plane of a base that has one stands at x, and zero at y: together they bound how
        fast the base is. `steepest` bounds |delta| of a base that steers [rad].
        """

    @abstractmethod
    def joint_velocity(self, q: Sequence[float], u: Sequence[float]) -> list[float]:
        """qd at q under the actuated velocity u."""

    @abstractmethod
    def action_map(self, q: Sequence[float]) -> FloatArray:
        """B with qd = B u."""


class FixedBase(Base):
    """A base that stands."""

    def integrate(self, q: list[float], u: list[float], action: list[float], dt: float) -> State:  # noqa: ARG002
        """Nothing moves."""
        return [], []

    def peak_rates(self, before: Sequence[float], after: Sequence[float], steepest: float) -> list[float]:  # noqa: ARG002
        """Nothing moves."""
        return []

    def joint_velocity(self, q: Sequence[float], u: Sequence[float]) -> list[float]:  # noqa: ARG002
        """Nothing moves."""
        return []

    def action_map(self, q: Sequence[float]) -> FloatArray:  # noqa: ARG002
        """Nothing moves."""
        return np.zeros((0, 0))


class HolonomicBase(Base):
    """A base that moves in any direction and turns; u = qd."""

    joints = POSE_JOINTS
    kinds = POSE_KINDS
    actions = POSE_JOINTS
    action_kinds = POSE_KINDS

    def integrate(self, q: list[float], u: list[float], action: list[float], dt: float) -> State:
        """Each entry by itself."""
        return integrate_holonomic(self.control, q, u, action, dt)

    def peak_rates(self, before: Sequence[float], after: Sequence[float], steepest: float) -> list[float]:  # noqa: ARG002
        """The larger of both speeds, and of both |w|."""
        speed = max(hypot(before[0], before[1]), hypot(after[0], after[1]))
        return [speed, 0.0, max(abs(before[2]), abs(after[2]))]

    def joint_velocity(self, q: Sequence[float], u: Sequence[float]) -> list[float]:  # noqa: ARG002
        """u itself."""
        return list(u)

    def action_map(self, q: Sequence[float]) -> FloatArray:  # noqa: ARG002
        """The identity."""
        return np.eye(3)


class DifferentialDriveBase(Base):
    """Two driven wheels; u = (v, w) in the body frame: x forward, w > 0 turns left."""

    joints = POSE_JOINTS
    kinds = POSE_KINDS
    actions = ("v", "w")
    action_kinds = ("prismatic", "revolute")

    def integrate(self, q: list[float], u: list[float], action: list[float], dt: float) -> State:
        """An arc under a constant (v, w), a generalised clothoid under constant rates."""
        return drive(self.control, q, u, action, dt)

    def peak_rates(self, before: Sequence[float], after: Sequence[float], steepest: float) -> list[float]:  # noqa: ARG002
        """The larger of both |v|, and of both |w|."""
        return [max(abs(before[0]), abs(after[0])), 0.0, max(abs(before[1]), abs(after[1]))]

    def joint_velocity(self, q: Sequence[float], u: Sequence[float]) -> list[float]:
        """qd = (v cos theta, v sin theta, w)."""
        return [u[0] * cos(q[2]), u[0] * sin(q[2]), u[1]]

    def action_map(self, q: Sequence[float]) -> FloatArray:
        """B (3, 2)."""
        return np.array([[cos(q[2]), 0.0], [sin(q[2]), 0.0], [0.0, 1.0]])


_COUNT = 8  # Gauss-Legendre nodes per piece
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(_COUNT)
# Row i: weights of the integral from -1 to node i, exact for polynomials of degree below _COUNT.
_INTEGRALS = np.column_stack(
    [np.polynomial.legendre.legval(_POINTS, np.polynomial.legendre.legint(unit, lbnd=-1)) for unit in np.eye(_COUNT)]
) @ np.linalg.inv(np.polynomial.legendre.legvander(_POINTS, _COUNT - 1))
_NODES = tuple(
    (0.5 * (1.0 + float(point)), 0.5 * float(weight), tuple(0.5 * float(x) for x in row))
    for point, weight, row in zip(_POINTS, _WEIGHTS, _INTEGRALS, strict=True)
)
_MAX_TURN = 0.15  # [rad] of heading or steering within a piece: quadrature is exact to rounding then
_MAX_PIECES = 1000  # a planner that diverges must not stop the clock
_MAX_STEERING = 1.5  # [rad] beyond, the tangent says nothing


class BicycleBase(Base):
    """A car, by its rear axle: u = (v, rate of the steering angle delta); theta' = v tan(delta) / wheel_base."""

    joints = (*POSE_JOINTS, "delta")
    kinds = (*POSE_KINDS, "revolute")
    actions = ("v", "delta_rate")
    action_kinds = ("prismatic", "revolute")

    def integrate(self, q: list[float], u: list[float], action: list[float], dt: float) -> State:
        """By Gauss-Legendre quadrature of the heading, then of the position. Raises ValueError beyond ±1.5 rad."""
        if self.control == "velocity":
            u, rates = action, [0.0, 0.0]
        else:
            rates = action
        after = [u[0] + rates[0] * dt, u[1] + rates[1] * dt]
        steering = q[3] + (u[1] + 0.5 * rates[1] * dt) * dt
        steepest = max(abs(q[3]), abs(steering))
        if u[1] * after[1] < 0.0:  # the rate changes its sign on the way, where the angle has its extreme
            steepest = max(steepest, abs(q[3] - 0.5 * u[1] * u[1] / rates[1]))
        if not steepest < _MAX_STEERING:
            raise ValueError(f"a steering angle of {steepest:g} rad; allowed are ±{_MAX_STEERING:g}")
        fastest = (abs(u[0]) + abs(rates[0]) * dt) / self.wheel_base
        turn = max(fastest * tan(steepest) * dt, (abs(u[1]) + 0.5 * abs(rates[1]) * dt) * dt, fastest * dt * 0.25)
        pieces = max(1, ceil(min(turn / _MAX_TURN, _MAX_PIECES)))
        x, y, theta = q[0], q[1], q[2]
        for piece in range(pieces):
            x, y, theta = self._piece(x, y, theta, q[3], u, rates, piece * dt / pieces, dt / pieces)
        return [x, y, theta, steering], after

    def _piece(
        self,
        x: float,
        y: float,
        theta: float,
        delta: float,
        u: Sequence[float],
        rates: Sequence[float],
        start: float,
        length: float,
    ) -> tuple[float, float, float]:
        """Pose after the piece of time that begins at `start` and lasts `length` [s]."""
        speeds, turns = [], []
        for place, _, _ in _NODES:
            t = start + length * place
            speed = u[0] + rates[0] * t
            speeds.append(speed)
            turns.append(speed * tan(delta + (u[1] + 0.5 * rates[1] * t) * t) / self.wheel_base)
        along_x = along_y = turned = 0.0
        for (_, weight, row), speed, turn in zip(_NODES, speeds, turns, strict=True):
            heading = theta + length * sum(w * f for w, f in zip(row, turns, strict=True))
            along_x += weight * speed * cos(heading)
            along_y += weight * speed * sin(heading)
            turned += weight * turn
        return x + length * along_x, y + length * along_y, theta + length * turned

    def peak_rates(self, before: Sequence[float], after: Sequence[float], steepest: float) -> list[float]:
        """The larger of both |v|, |v| tan(delta) / wheel_base at the largest |delta|, and the larger of both rates."""
        speed = max(abs(before[0]), abs(after[0]))
        turn = tan(steepest) if steepest < 0.5 * pi else inf
        return [speed, 0.0, speed * turn / self.wheel_base, max(abs(before[1]), abs(after[1]))]

    def joint_velocity(self, q: Sequence[float], u: Sequence[float]) -> list[float]:
        """qd = (v cos theta, v sin theta, v tan(delta) / wheel_base, delta rate)."""
        return [u[0] * cos(q[2]), u[0] * sin(q[2]), u[0] * tan(q[3]) / self.wheel_base, u[1]]

    def action_map(self, q: Sequence[float]) -> FloatArray:
        """B (4, 2)."""
        return np.array([[cos(q[2]), 0.0], [sin(q[2]), 0.0], [tan(q[3]) / self.wheel_base, 0.0], [0.0, 1.0]])


# A new base is one class here and one word in the schema.
BASES: dict[str, type[Base]] = {
    "fixed": FixedBase,
    "holonomic": HolonomicBase,
    "differential_drive": DifferentialDriveBase,
    "bicycle": BicycleBase,
}
