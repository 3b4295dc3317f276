"""The goal as a task: errors, velocities and Jacobians of all sub-goals, stacked, per actuated velocity."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.actuation import actuation_of
from pytest_lpb.planner.base import FloatArray, GoalInfo, Observation, PlannerProblem
from pytest_lpb.planner.known import check_goals
from pytest_lpb.planner.planar_rows import PLANAR_ROWS
from pytest_lpb.planner.rows import Row
from pytest_lpb.planner.spatial_rows import SPATIAL_ROWS, angular_velocity

ROWS: Mapping[int, Mapping[str, Row]] = {2: PLANAR_ROWS, 3: SPATIAL_ROWS}  # by dimension
SUPPORTED: Mapping[str, tuple[str, ...]] = {"control": ("acceleration", "velocity")}  # these laws know no masses
POINTS = ("point", "point_3d")


class Task:
    """All sub-goals of a problem, stacked.

    Args:
        problem: what the planner was told.
        lookahead: distance ahead of a non-holonomic base at which it is steered [m].
    """

    def __init__(self, problem: PlannerProblem, lookahead: float) -> None:
        self._robot = problem.robot
        self.actuation = actuation_of(problem.robot, problem.control, problem.period, lookahead)
        rows = ROWS[problem.dimension]
        self._rows = [(f"goal_{goal.name}", rows[goal.type], goal) for goal in problem.goal]
        self._dimension = problem.dimension
        self.moving = any(goal.moving for goal in problem.goal)
        sizes = [self._error_size(goal) for goal in problem.goal]
        ends = np.cumsum(sizes).tolist()
        # Rows and weight of each sub-goal.
        self.blocks = [
            (slice(end - size, end), goal.weight) for goal, size, end in zip(problem.goal, sizes, ends, strict=True)
        ]
        only = problem.goal[0]
        plain = only.type == "position" and not set(only.entry) & {"axes", "point", "relative_to"}
        # The error is goal_position - q, its Jacobian the identity.
        self.direct = problem.robot.model in POINTS and len(problem.goal) == 1 and plain and only.weight == 1.0

    def error(self, observation: Observation) -> tuple[FloatArray, FloatArray]:
        """Weighted error (m,) and Jacobian (m, n_actions) of the task's value."""
        q = observation["q"]
        actuation = self.actuation
        errors, jacobians = [], []
        for key, row, goal in self._rows:
            error, jacobian = row(observation[key], self._robot, goal, q)
            errors.append(goal.weight * error)
            jacobians.append(goal.weight * actuation.per_input(jacobian, q, actuation.lookahead_at(error)))
        if len(errors) == 1:
            return errors[0], jacobians[0]
        return np.concatenate(errors), np.vstack(jacobians)

    def _error_size(self, goal: GoalInfo) -> int:
        """Rows of a sub-goal's error: those of its target, but rotation vectors of turns in space."""
        return 3 if self._dimension == 3 and goal.type in ("orientation", "alignment") else goal.size

    def target_velocity(self, observation: Observation) -> FloatArray:
        """Weighted velocity of the targets (m,) [m/s or rad/s]."""
        return np.concatenate([goal.weight * self._velocity(key, goal, observation) for key, _, goal in self._rows])

    def _velocity(self, key: str, goal: GoalInfo, observation: Observation) -> FloatArray:
        velocity = observation[f"{key}_velocity"]
        if self._error_size(goal) == goal.size:
            return velocity
        return angular_velocity(observation[key], velocity) if goal.type == "orientation" else np.zeros(3)


def check_control(planner: str, problem: PlannerProblem) -> None:
    """Raise ConfigurationError for torque control, where nobody has looked at what the planner supports."""
    check_goals(planner, problem)
    if problem.control not in SUPPORTED["control"]:
        raise ConfigurationError(
            f"{planner} gives accelerations or velocities, not torques; use control: acceleration with dynamics: true"
        )


def damped_inverse(jacobian: FloatArray, damping: float) -> FloatArray:
    """J^T (J J^T + damping^2 I)^-1: bounded near singular arms (Nakamura and Hanafusa, 1986)."""
    square: FloatArray = jacobian @ jacobian.T
    square.flat[:: len(square) + 1] += damping * damping
    return np.asarray(np.linalg.solve(square, jacobian).T, dtype=np.float64)
