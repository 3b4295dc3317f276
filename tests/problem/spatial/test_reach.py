"""Bounds of how far joints carry bodies, and distances that rely on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.spatial.clearance import SpatialCollision
from pytest_lpb.problem.spatial.pool import borrow_world, give_back
from pytest_lpb.problem.spatial.space import place_at_start
from tests.problem.spatial.robots import spatial_robot

CRANE_URDF = """<robot name="crane">
  <link name="root"/><link name="boom"/>
  <link name="hook"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="root"/><child link="boom"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
  <joint name="slide" type="prismatic"><parent link="boom"/><child link="hook"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.1"/></joint>
</robot>
"""
PLACES = ([5.0, 0.0, 1.0], [0.0, 5.0, 0.0])


@pytest.mark.parametrize("limit", [[0.0, 5.0], None], ids=["wider", "none"])
def test_distances_hold_beyond_the_limits_of_the_file(limit: list[float] | None, tmp_path: Path) -> None:
    """The hook swings at 5 m from one obstacle to another; the file's own limit is 0.1 m."""
    path = tmp_path / "crane.urdf"
    path.write_text(CRANE_URDF, encoding="utf-8")
    entry = {"urdf": str(path), "joints": ["turn", "slide"]}
    # A world of the same model, left by a robot of narrower limits, must not lend its bounds.
    narrow = spatial_robot(entry, limits={"position": [[-3.0, 3.0], [0.0, 0.1]]})
    give_back(narrow, borrow_world(narrow))
    robot = spatial_robot(entry, limits={"position": [[-3.0, 3.0], limit]})
    shape = {"shape": "sphere", "radius": 0.2, "orientation": [1.0, 0.0, 0.0, 0.0]}
    world = borrow_world(robot)
    place_at_start(world, [Obstacle({"name": f"o{i}", "position": place, **shape}) for i, place in enumerate(PLACES)])
    collision = SpatialCollision(robot, world, ["o0", "o1"])
    q, step = np.array([0.0, 5.0]), np.array([0.00785, 0.0])
    worst = 0.0
    for _ in range(200):
        world.set_q(q.tolist())
        hook = robot.forward_kinematics(q, "hook")[:3, 3]
        expected = min(float(np.linalg.norm(hook - place)) for place in PLACES) - 0.3
        worst = max(worst, abs(collision.obstacles.nearest()[0] - expected))
        q += step
        collision.moved(step)
    give_back(robot, world)
    assert worst < 1e-9
