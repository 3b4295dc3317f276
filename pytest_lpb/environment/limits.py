"""What a robot's limits leave of an action. Clipped actions are counted, never silently applied."""

from __future__ import annotations

from math import inf, isfinite

from pytest_lpb.errors import DivergedError
from pytest_lpb.problem.robot import Robot

POSITION_SLACK = 1e-9  # [rad or m] beyond a position limit before it counts as violated
_ROUNDING = 1e-12  # relative slack of velocity limits: a robot that coasts at its limit is not limited


class ActionLimits:
    """Velocity and acceleration limits of the actuated velocities, as scalars for the trial loop.

    Under acceleration control the action is clipped to the acceleration limits, then reduced so that the velocity
    stays within its limits at the end of the step, as far as the acceleration limits allow. Under velocity control the
    action is clipped to the velocity limits, then its change to what the acceleration limits allow within a step.
    Torques are clipped to the effort limits.
    """

    def __init__(self, robot: Robot, dt: float) -> None:
        self._dt = dt
        self._velocity = [tuple(row) for row in robot.limits.velocity.tolist()]
        self._acceleration = [tuple(row) for row in robot.limits.acceleration.tolist()]
        self._effort = [tuple(row) for row in robot.limits.effort.tolist()]
        self._apply, counting = {
            "velocity": (self._by_velocity, (*self._velocity, *self._acceleration)),
            "acceleration": (self._by_acceleration, (*self._velocity, *self._acceleration)),
            "torque": (self._by_torque, self._effort),
        }[robot.control]
        self._unlimited = not any(isfinite(x) for row in counting for x in row)

    def apply(self, action: list[float], u: list[float]) -> list[float]:
        """The action that the robot carries out at actuated velocity u, (n_actions,)."""
        if self._unlimited:
            return action
        return self._apply(action, u)

    def _by_acceleration(self, action: list[float], u: list[float]) -> list[float]:
        dt = self._dt
        applied = []
        for a, v, (slowest, fastest), (lowest, highest) in zip(
            action, u, self._velocity, self._acceleration, strict=True
        ):
            a = min(max(a, lowest), highest)
            after = v + a * dt
            if after > fastest + _ROUNDING * abs(fastest):
                a = max((fastest - v) / dt, lowest)
            elif after < slowest - _ROUNDING * abs(slowest):
                a = min((slowest - v) / dt, highest)
            applied.append(a)
        return applied

    def _by_velocity(self, action: list[float], u: list[float]) -> list[float]:
        dt = self._dt
        applied = []
        for wanted, v, (slowest, fastest), (lowest, highest) in zip(
            action, u, self._velocity, self._acceleration, strict=True
        ):
            wanted = min(max(wanted, slowest), fastest)
            applied.append(min(max(wanted, v + lowest * dt), v + highest * dt))
        return applied

    def _by_torque(self, action: list[float], u: list[float]) -> list[float]:  # noqa: ARG002 - speed limits no torque
        return [
            min(max(wanted, lowest), highest) for wanted, (lowest, highest) in zip(action, self._effort, strict=True)
        ]


class PositionLimits:
    """Position limits that are finite, for the joint-limit check of each row."""

    def __init__(self, robot: Robot) -> None:
        self._limits = [
            (index, lower - POSITION_SLACK, upper + POSITION_SLACK)
            for index, (lower, upper) in enumerate(robot.limits.position.tolist())
            if lower > -inf or upper < inf
        ]

    def violated(self, q: list[float]) -> int | None:
        """Index of the first joint beyond its limits, or None."""
        for index, lower, upper in self._limits:
            if not lower <= q[index] <= upper:
                return index
        return None


def check_measure(q: list[float], action: list[float], beyond: float) -> None:
    """Raise DivergedError for positions beyond all measure [m or rad]."""
    for value in q:
        if not -beyond < value < beyond:
            raise DivergedError(f"the actions drove the robot's position beyond {beyond:g} (last action {action})")
