"""Errors and Jacobians of planar sub-goals, per qd."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, pi, remainder
from typing import Any

import numpy as np

from pytest_lpb.planner.base import FloatArray, GoalInfo
from pytest_lpb.planner.rows import Row, joint_row
from pytest_lpb.problem.robot import Robot


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
    "joint": joint_row,
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
