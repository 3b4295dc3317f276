"""Errors and Jacobians of spatial sub-goals, per qd; those of turns are rotation vectors in world axes [rad]."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, sqrt

import numpy as np

from pytest_lpb.planner.base import FloatArray, GoalInfo
from pytest_lpb.planner.rows import Row, joint_row
from pytest_lpb.problem.robot import Robot
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.rotations import from_matrix, inverse, multiply, normalised, rotation_vector

SMALL = 1e-9  # of a cross product: axes that are (anti)parallel have no direction to turn in


def cross_matrix(v: FloatArray) -> FloatArray:
    """The matrix (3, 3) of w -> v x w."""
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _frame(robot: Robot, link: str, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    assert isinstance(robot, SpatialRobot)
    return robot.frame_and_jacobian(q, link)


def _position(target: FloatArray, robot: Robot, goal: GoalInfo, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    pose, whole = _frame(robot, goal.link or "", q)
    position, jacobian = pose[:3, 3], whole[:3]
    point = goal.entry.get("point")
    if point:
        arm = pose[:3, :3] @ np.asarray(point, dtype=float)
        position, jacobian = position + arm, jacobian - cross_matrix(arm) @ whole[3:]
    reference = goal.entry.get("relative_to")
    if reference not in (None, "world"):
        other, other_jacobian = _frame(robot, str(reference), q)
        turn, offset = other[:3, :3].T, position - other[:3, 3]
        jacobian = turn @ (jacobian - other_jacobian[:3] + cross_matrix(offset) @ other_jacobian[3:])
        position = turn @ offset
    axes = goal.entry.get("axes")
    if axes:
        return target - position[axes], jacobian[axes]
    return target - position, jacobian


def _orientation(target: FloatArray, robot: Robot, goal: GoalInfo, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    pose, jacobian = _frame(robot, goal.link or "", q)
    turn = multiply(normalised(target.tolist()), inverse(from_matrix(pose[:3, :3])))
    return np.array(rotation_vector(turn)), jacobian[3:]


def _alignment(
    target: FloatArray,  # noqa: ARG001 - it is an angle of zero
    robot: Robot,
    goal: GoalInfo,
    q: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """The shortest turn that brings the axis onto the other one."""
    pose, whole = _frame(robot, goal.link or "", q)
    axis = pose[:3, :3] @ np.array(goal.entry["axis"], dtype=float)
    other_axis = np.array(goal.entry["other_axis"], dtype=float)
    jacobian = whole[3:]
    other = goal.entry.get("other", "world")
    if other != "world":
        other_pose, other_whole = _frame(robot, str(other), q)
        other_axis = other_pose[:3, :3] @ other_axis
        jacobian = jacobian - other_whole[3:]
    a, b = axis / np.linalg.norm(axis), other_axis / np.linalg.norm(other_axis)
    normal = cross_matrix(a) @ b
    sine, cosine = sqrt(float(normal @ normal)), float(a @ b)
    if sine < SMALL:  # parallel: nothing to do; opposed: any axis across will do
        across = cross_matrix(a) @ np.eye(3)[int(np.abs(a).argmin())]
        normal, sine = across, float(np.linalg.norm(across))
        angle = 0.0 if cosine > 0.0 else np.pi
    else:
        angle = atan2(sine, cosine)
    # A turn about the axes themselves says nothing: it is taken out of the Jacobian.
    free = np.eye(3) - np.outer(a, a)
    return normal * (angle / sine), free @ jacobian


def angular_velocity(quaternion: FloatArray, rate: FloatArray) -> FloatArray:
    """Angular velocity (3,) [rad/s] in world axes of a unit quaternion (4,) that changes at a rate (4,) [1/s]."""
    return 2.0 * np.array(multiply(rate.tolist(), inverse(quaternion.tolist()))[1:])


# One entry per sub-goal type in space.
SPATIAL_ROWS: Mapping[str, Row] = {
    "position": _position,
    "orientation": _orientation,
    "joint": joint_row,
    "alignment": _alignment,
}
