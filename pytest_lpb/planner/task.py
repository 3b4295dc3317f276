"""The goal as a task: errors, velocities and Jacobians of all sub-goals, stacked, per actuated velocity."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import atan2, cos, pi, remainder, sin, sqrt
from typing import Any

import numpy as np

from pytest_lpb.planner.base import FloatArray, GoalInfo, Observation, PlannerProblem
from pytest_lpb.problem.robot import Robot

# (target, robot, sub-goal, q) -> error (m,), Jacobian (m, dof) of the value whose error it is
Row = Callable[[FloatArray, Robot, GoalInfo, FloatArray], tuple[FloatArray, FloatArray]]


def _position(target: FloatArray, robot: Robot, goal: GoalInfo, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    position, jacobian = point_on_link(robot, goal.link or "", goal.entry.get("point") or (0.0, 0.0), q)
    reference = goal.entry.get("relative_to")
    if reference not in (None, "world"):
        position, jacobian = _relative(robot, str(reference), q, position, jacobian)
    axes = list(goal.entry.get("axes") or range(robot.dimension))
    return target - position[axes], jacobian[axes]


def _orientation(target: FloatArray, robot: Robot, goal: GoalInfo, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    pose = robot.forward_kinematics(q, goal.link or "")
    error = remainder(float(target[0]) - atan2(pose[1, 0], pose[0, 0]), 2.0 * pi)
    return np.array([error]), robot.jacobian(q, goal.link or "")[2:]


def _joint(target: FloatArray, robot: Robot, goal: GoalInfo, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    indices = [robot.joint_names.index(name) for name in goal.entry["joints"]]
    error = target - q[indices]
    for place, index in enumerate(indices):
        if index in robot.headings:
            error[place] = remainder(error[place], 2.0 * pi)
    return error, np.eye(robot.dof)[indices]


def _alignment(target: FloatArray, robot: Robot, goal: GoalInfo, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    other = goal.entry.get("other", "world")
    axis = robot.forward_kinematics(q, goal.link or "")[:2, :2] @ np.array(goal.entry["axis"][:2])
    other_axis = np.array(goal.entry["other_axis"][:2])
    jacobian = robot.jacobian(q, goal.link or "")[2:]
    if other != "world":
        other_axis = robot.forward_kinematics(q, other)[:2, :2] @ other_axis
        jacobian = jacobian - robot.jacobian(q, other)[2:]
    angle = atan2(other_axis[0] * axis[1] - other_axis[1] * axis[0], float(other_axis @ axis))
    return np.array([remainder(float(target[0]) - angle, 2.0 * pi)]), jacobian


# One entry per planar sub-goal type.
PLANAR_ROWS: Mapping[str, Row] = {
    "position": _position,
    "orientation": _orientation,
    "joint": _joint,
    "alignment": _alignment,
}


def point_on_link(robot: Robot, link: str, point: Any, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Position (2,) of a point of a link's frame in the world, and its Jacobian (2, dof)."""
    pose = robot.forward_kinematics(q, link)
    arm = pose[:2, :2] @ np.asarray(point[:2], dtype=float)
    jacobian = robot.jacobian(q, link)
    return pose[:2, 2] + arm, jacobian[:2] + np.outer([-arm[1], arm[0]], jacobian[2])


def _relative(
    robot: Robot, reference: str, q: FloatArray, position: FloatArray, jacobian: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """A position and its Jacobian in another link's frame."""
    pose, frame_jacobian = robot.forward_kinematics(q, reference), robot.jacobian(q, reference)
    turn = pose[:2, :2].T
    offset = position - pose[:2, 2]
    spin = np.outer([-offset[1], offset[0]], frame_jacobian[2])
    return turn @ offset, turn @ (jacobian - frame_jacobian[:2] - spin)


class Actuation:
    """Maps Jacobians per qd to Jacobians per u.

    A non-holonomic base cannot move sideways at once. A point `lookahead` ahead of it can, so its Jacobian stands in
    for the base's (input-output linearisation: Siciliano et al., "Robotics", 2009, section 11.6.1).
    """

    def __init__(self, robot: Robot, lookahead: float) -> None:
        self._robot = robot
        self.lookahead = lookahead  # [m]
        self.direct = not robot.non_holonomic  # u is qd

    def per_input(self, jacobian: FloatArray, q: FloatArray, lookahead: float | None = None) -> FloatArray:
        """A Jacobian's columns per u, (.., m, dof) to (.., m, n_actions); `lookahead` [m] by default the robot's."""
        if self.direct:
            return jacobian
        mapped: FloatArray = jacobian @ self._robot.action_map(q)
        theta, ahead = float(q[2]), self.lookahead if lookahead is None else lookahead
        mapped[..., 1] += jacobian[..., :2] @ np.array([-ahead * sin(theta), ahead * cos(theta)])
        return mapped

    def lookahead_at(self, error: FloatArray) -> float:
        """The lookahead [m] that steers to a goal this far away.

        A fixed one would let the base come to rest with the goal beside it: its bearing then grows to a right angle.
        Half the distance left keeps it facing the goal; a sixth of the lookahead bounds the turn rate.
        """
        distance = sqrt(float(error @ error))
        return min(max(0.5 * distance, self.lookahead / 6.0), self.lookahead)


class Task:
    """All sub-goals of a problem, stacked.

    Args:
        problem: what the planner was told.
        lookahead: distance ahead of a non-holonomic base at which it is steered [m].
    """

    def __init__(self, problem: PlannerProblem, lookahead: float) -> None:
        self._robot = problem.robot
        self.actuation = Actuation(problem.robot, lookahead)
        self._rows = [(f"goal_{goal.name}", PLANAR_ROWS[goal.type], goal) for goal in problem.goal]
        self.moving = any(goal.moving for goal in problem.goal)
        ends = np.cumsum([goal.size for goal in problem.goal]).tolist()
        # Rows and weight of each sub-goal.
        self.blocks = [(slice(end - goal.size, end), goal.weight) for goal, end in zip(problem.goal, ends, strict=True)]
        only = problem.goal[0]
        plain = only.type == "position" and not set(only.entry) & {"axes", "point", "relative_to"}
        # The error is goal_position - q, its Jacobian the identity.
        self.direct = problem.robot.model == "point" and len(problem.goal) == 1 and plain and only.weight == 1.0

    def error(self, observation: Observation) -> tuple[FloatArray, FloatArray]:
        """Weighted error (m,) and Jacobian (m, n_actions) of the task's value."""
        q = observation["q"]
        actuation = self.actuation
        errors, jacobians = [], []
        for key, row, goal in self._rows:
            error, jacobian = row(observation[key], self._robot, goal, q)
            ahead = None if actuation.direct else actuation.lookahead_at(error)
            errors.append(goal.weight * error)
            jacobians.append(goal.weight * actuation.per_input(jacobian, q, ahead))
        if len(errors) == 1:
            return errors[0], jacobians[0]
        return np.concatenate(errors), np.vstack(jacobians)

    def target_velocity(self, observation: Observation) -> FloatArray:
        """Weighted velocity of the targets (m,) [m/s or rad/s]."""
        return np.concatenate([goal.weight * observation[f"{key}_velocity"] for key, _, goal in self._rows])


def damped_inverse(jacobian: FloatArray, damping: float) -> FloatArray:
    """J^T (J J^T + damping^2 I)^-1: bounded near singular arms (Nakamura and Hanafusa, 1986)."""
    square: FloatArray = jacobian @ jacobian.T
    square.flat[:: len(square) + 1] += damping * damping
    return np.asarray(np.linalg.solve(square, jacobian).T, dtype=np.float64)
