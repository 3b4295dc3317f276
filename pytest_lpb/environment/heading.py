"""Where a base heads, as an arrow: in pictures, videos and replays."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pytest_lpb.errors import ScenarioError

if TYPE_CHECKING:
    from pytest_lpb.problem.robot import CollisionBody, FloatArray, Robot

BEYOND = 1.25  # of the way from the base's origin to its front: the arrow's tip is seen
SHORTEST_M = 0.1
HEAD, HALF_WIDTH = 0.3, 0.16  # of the arrow's head, in arrows
PROBED = 0.1  # [rad or m] by which joints are moved to see what moves with the base


def heading_of(robot: Robot) -> tuple[str, float] | None:
    """The link along whose x-axis a base heads, and the length of its arrow [m]; None for robots without a heading."""
    if not robot.headings:
        return None
    base = robot.link_names[0]
    reach = [_forward(robot, base, body) for body in _bodies_of_base(robot, base)]
    return base, BEYOND * max([*reach, SHORTEST_M])


def arrow(pose: FloatArray, length: float) -> tuple[FloatArray, FloatArray]:
    """Shaft (2, d) and head (3, d) [m] of an arrow along the x-axis of a pose (d + 1, d + 1)."""
    origin, forward, left = pose[:-1, -1], pose[:-1, 0], pose[:-1, 1]
    tip = origin + length * forward
    barb, side = tip - HEAD * length * forward, HALF_WIDTH * length * left
    return np.stack([origin, tip]), np.stack([barb + side, tip, barb - side])


def _bodies_of_base(robot: Robot, base: str) -> Iterator[CollisionBody]:
    """What moves with the base as one; nothing when a mesh cannot be read any more."""
    try:
        bodies = robot.collision_bodies
    except (ScenarioError, OSError):
        return
    for body in bodies:
        before, after = (_relative(robot, np.full(robot.dof, q), base, body.link) for q in (0.0, PROBED))
        if np.allclose(before, after):
            yield body


def _relative(robot: Robot, q: FloatArray, base: str, link: str) -> FloatArray:
    return np.asarray(np.linalg.inv(robot.forward_kinematics(q, base)) @ robot.forward_kinematics(q, link))


def _forward(robot: Robot, base: str, body: CollisionBody) -> float:
    """How far a body reaches ahead of the base's origin [m]."""
    d, pose = robot.dimension, _relative(robot, np.zeros(robot.dof), base, body.link)
    ends = np.array([[capsule[:d], capsule[d : 2 * d]] for capsule in body.capsules]).reshape(-1, d)
    radii = np.repeat([capsule[-1] for capsule in body.capsules], 2)
    return float((ends @ pose[0, :d] + pose[0, d] + radii).max(initial=0.0))
