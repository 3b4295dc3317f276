"""How far a joint can carry a body: bounds of a point's travel per radian or metre of each joint."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Protocol

import numpy as np

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.urdf import Joint
from pytest_lpb.problem.spatial.variants import driven_joints

UNBOUNDED_M = 1e7  # [m] stands for no bound; finite, so that a joint at rest still carries nothing
BEYOND = 2.0  # share of its range that a sliding joint is trusted to stay within, limits being checked, not clamped


class Carried(Protocol):
    """A body on a link: a ball of `radius` [m] around the frame of `name` holds it."""

    @property
    def name(self) -> str:
        """Of the link."""

    @property
    def radius(self) -> float:
        """Of the ball [m]."""


def reach_of_joints(robot: SpatialRobot, bodies: Sequence[Carried]) -> FloatArray:
    """Bounds (bodies, dof) of the distance [m] that any point of a body moves per unit of each entry of q.

    A revolute joint carries a point by no more than the length of the chain from its axis to the point; a prismatic one
    by its own motion.
    """
    reach = np.zeros((len(bodies), robot.dof))
    for row, levers in enumerate(_levers(robot, bodies)):
        for source, lever in levers.values():
            reach[row, source] += lever
    return np.minimum(reach, UNBOUNDED_M)


def reach_between(robot: SpatialRobot, bodies: Sequence[Carried], pairs: Sequence[tuple[int, int]]) -> FloatArray:
    """Bounds (pairs, dof) of how much the distance between two bodies changes per unit of each entry of q [m].

    Joints that carry both bodies do not change it.
    """
    all_levers = _levers(robot, bodies)
    reach = np.zeros((len(pairs), robot.dof))
    for row, (first, second) in enumerate(pairs):
        one, other = all_levers[first], all_levers[second]
        for name in one.keys() ^ other.keys():
            source, lever = one[name] if name in one else other[name]
            reach[row, source] += lever
    return np.minimum(reach, UNBOUNDED_M)


def _levers(robot: SpatialRobot, bodies: Sequence[Carried]) -> list[dict[str, tuple[int, float]]]:
    """For each body, by the joints of the URDF that carry it: the entry of q that moves it, and its bound per unit."""
    above = {joint.child: joint for joint in robot.urdf.joints}
    planned, followers = driven_joints(robot)
    driven = {name: (source, 1.0) for name, source in planned}
    driven |= {name: (source, abs(multiplier)) for name, source, multiplier, _ in followers}
    found = []
    for body in bodies:
        levers: dict[str, tuple[int, float]] = {}
        length, link = body.radius, body.name
        while link in above:
            joint = above[link]
            if joint.name in driven:
                source, multiplier = driven[joint.name]
                levers[joint.name] = source, multiplier * (1.0 if joint.kind == "prismatic" else length)
            length += float(np.linalg.norm(joint.origin[:3, 3])) + _slide(joint, robot)
            link = joint.parent
        found.append(levers)
    return found


def _slide(joint: Joint, robot: SpatialRobot) -> float:
    """The most [m] that a sliding joint adds to the length of its chain."""
    if joint.kind != "prismatic":
        return 0.0
    if joint.mimic is None and joint.name in robot.locked:
        return abs(robot.locked[joint.name])
    farthest = robot.farthest(joint)
    return BEYOND * farthest if isfinite(farthest) else UNBOUNDED_M
