"""Kinematics of spatial robots as CasADi expressions, for planners that optimise or differentiate them."""

from __future__ import annotations

from typing import Any

import casadi
import numpy as np

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.urdf import Joint, joint_motion


def casadi_kinematics(robot: SpatialRobot, q: Any, link: str) -> tuple[Any, Any]:
    """Position (3, 1) [m] and rotation matrix (3, 3) of a link's frame in the world.

    The chain is that of `robot.forward_kinematics`: moving base, joints that mimic others and locked joints included.
    Constant poses between joints are multiplied in, so that expressions hold sines and cosines of q only.

    Args:
        robot: the robot.
        q: positions as casadi.SX or casadi.MX (dof, 1); casadi.DM gives numbers.
        link: one of `robot.link_names`.

    Raises ValueError: unknown link, or q of another size.
    """
    if q.numel() != robot.dof:
        raise ValueError(f"q has {q.numel()} entries; {robot.name} has {robot.dof}: {', '.join(robot.joint_names)}")
    robot.link_index(link)
    index = {name: place for place, name in enumerate(robot.joint_names)}
    position, rotation = casadi.DM.zeros(3, 1), casadi.DM.eye(3)
    still = np.eye(4)  # what follows the last joint that q moves
    for joint in _chain(robot, link):
        still = still @ joint.origin
        if joint.kind == "fixed":
            continue
        source, multiplier, offset = joint.mimic or (joint.name, 1.0, 0.0)
        if source not in index:
            still = still @ joint_motion(joint, multiplier * robot.locked.get(source, 0.0) + offset)
            continue
        position, rotation = _followed(position, rotation, still)
        still = np.eye(4)
        position, rotation = _moved(position, rotation, joint, multiplier * q[index[source]] + offset)
    position, rotation = _followed(position, rotation, still)
    kind = type(q)  # links that q does not move are constants, in the type of all others
    return casadi.densify(kind(position)), casadi.densify(kind(rotation))


def _chain(robot: SpatialRobot, link: str) -> list[Joint]:
    """Joints from the root to a link."""
    above = {joint.child: joint for joint in robot.urdf.joints}
    joints = []
    while link in above:
        joints.append(above[link])
        link = above[link].parent
    return joints[::-1]


def _constant(numbers: FloatArray) -> Any:
    """Numbers as a matrix whose zeros take no part in expressions."""
    return casadi.sparsify(casadi.DM(numbers))


def _followed(position: Any, rotation: Any, pose: FloatArray) -> tuple[Any, Any]:
    """The frame at a constant pose (4, 4) in the given one."""
    moved = position + rotation @ _constant(pose[:3, 3])
    return moved, rotation @ _constant(pose[:3, :3])


def _moved(position: Any, rotation: Any, joint: Joint, value: Any) -> tuple[Any, Any]:
    """The frame moved by a joint in it: by `value` [m] along its axis, or [rad] about it (Rodrigues)."""
    axis = np.array(joint.axis)
    if joint.kind == "prismatic":
        return position + rotation @ (value * _constant(axis)), rotation
    x, y, z = joint.axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = (
        _constant(np.eye(3))
        + casadi.sin(value) * _constant(cross)
        + (1.0 - casadi.cos(value)) * _constant(cross @ cross)
    )
    return position, rotation @ turn
