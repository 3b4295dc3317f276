"""URDF models changed for PyBullet: locked joints made fixed, one collision shape per link."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.urdf import Joint, Link, UrdfModel
from pytest_lpb.problem.spatial.urdf_limits import fixed_at

PART = "#"  # in the names of links made for further shapes of a link: `hand#1`


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


def one_shape_per_link(model: UrdfModel) -> tuple[UrdfModel, dict[str, str]]:
    """The model with further collision shapes of a link moved to links of their own, and which link each belongs to.

    Bullet measures a link as a whole, and shapes of one link may have different margins.
    """
    links: list[Link] = []
    joints: list[Joint] = []
    owners: dict[str, str] = {}
    by_child = {joint.child: joint for joint in model.joints}
    for link in model.links:
        links.append(replace(link, collisions=link.collisions[:1]))
        if link.name in by_child:
            joints.append(by_child[link.name])
        owners[link.name] = link.name
        for index, geometry in enumerate(link.collisions[1:], start=1):
            part = f"{link.name}{PART}{index}"
            links.append(Link(name=part, collisions=(geometry,), visuals=(), inertial=None))
            joints.append(_welded(part, link.name))
            owners[part] = link.name
    return replace(model, links=tuple(links), joints=tuple(joints)), owners


def _welded(child: str, parent: str) -> Joint:
    return Joint(f"{child}_joint", "fixed", parent, child)
