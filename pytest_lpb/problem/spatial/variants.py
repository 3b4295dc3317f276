"""URDF models changed for PyBullet: locked joints made fixed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.urdf import UrdfModel
from pytest_lpb.problem.spatial.urdf_limits import fixed_at


def with_locked_joints(model: UrdfModel, locked: Mapping[str, float]) -> UrdfModel:
    """The model with every locked joint fixed at its position [rad or m]; joints that mimic one are fixed too."""
    positions = dict(locked)
    joints = []
    for joint in model.joints:
        if joint.mimic is not None and joint.mimic[0] in locked:
            source, multiplier, offset = joint.mimic
            positions[joint.name] = multiplier * locked[source] + offset
        joints.append(fixed_at(joint, positions[joint.name]) if joint.name in positions else joint)
    return replace(model, joints=tuple(joints))


def driven_joints(robot: SpatialRobot) -> tuple[list[tuple[str, int]], list[tuple[str, int, float, float]]]:
    """The joints of a robot's URDF that q moves.

    First those that are entries of q: name and entry. Then those that mimic one: name, entry, multiplier, offset.
    """
    index = {name: place for place, name in enumerate(robot.joint_names)}
    joints = [joint for joint in robot.urdf.joints if joint.kind != "fixed"]
    planned = [(joint.name, index[joint.name]) for joint in joints if joint.name in index]
    mimics = [(joint.name, *joint.mimic) for joint in joints if joint.mimic is not None]
    return planned, [
        (name, index[source], multiplier, offset) for name, source, multiplier, offset in mimics if source in index
    ]
