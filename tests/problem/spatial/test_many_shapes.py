"""Robots with more links and shapes than PyBullet tells the state of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.spatial.layout import MOST_JOINTS
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.rotations import matrix_of
from pytest_lpb.problem.spatial.space import SpatialSpace
from pytest_lpb.problem.spatial.world import World
from tests.problem.spatial.robots import DEFAULTS, PANDA, TILTED


def chain_of(folder: Path, links: int, moving: int) -> SpatialRobot:
    """A chain of links with a small sphere each, some of whose joints move, the others are fixed and bent."""
    parts = ['<robot name="chain"><link name="l0"/>']
    every = max(links // moving, 1)
    for index in range(1, links + 1):
        turns = index % every == 0 and index // every <= moving
        inertia = '<inertia ixx="1e-4" iyy="1e-4" izz="1e-4"/>'
        inertial = f'<inertial><origin xyz="0 0.01 0"/><mass value="0.1"/>{inertia}</inertial>'
        shape = '<collision><origin xyz="0 0 0.01"/><geometry><sphere radius="0.01"/></geometry></collision>'
        parts.append(f'<link name="l{index}">{inertial}{shape}</link>')
        parts.append(
            f'<joint name="j{index}" type="{"revolute" if turns else "fixed"}"><parent link="l{index - 1}"/>'
            f'<child link="l{index}"/><origin xyz="0.02 0 0.01" rpy="0.1 -0.05 0.2"/><axis xyz="0 0 1"/>'
            '<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
        )
    path = folder / "chain.urdf"
    path.write_text("\n".join([*parts, "</robot>"]), encoding="utf-8")
    joints = [f"j{index}" for index in range(every, every * moving + 1, every)]
    return SpatialRobot({**DEFAULTS, "urdf": str(path), "name": "chain", "joints": joints})


@pytest.mark.parametrize("simulated", [False, True])
def test_links_that_move_as_one_are_merged_and_keep_names_frames_and_shapes(tmp_path: Path, simulated: bool) -> None:
    robot = chain_of(tmp_path, links=150, moving=10)
    world = World(robot, simulated=simulated)
    assert world.client.call("getNumJoints", world.robot) <= MOST_JOINTS
    assert [body.name for body in world.bodies] == [f"l{index}" for index in range(1, 151)]
    for q in np.random.default_rng(5).uniform(-1.0, 1.0, (3, robot.dof)):
        world.set_q(q.tolist())
        poses = robot.link_frames(q)
        for index, pose in enumerate(poses):
            frame = world.frame(index)
            assert np.array(frame[:3]) == pytest.approx(pose[:3, 3], abs=1e-9)
            assert np.array(matrix_of(frame[3:])) == pytest.approx(pose[:3, :3], abs=1e-9)
        probe = Obstacle({"name": "probe", "shape": "sphere", "radius": 0.1, "position": [0.0, 0.0, 0.0]})
        world.set_obstacles([probe])
        for body in world.bodies[::10]:
            world.bring(body)
            (point,) = world.client.call("getClosestPoints", body.id, world.obstacles[0], 100.0, body.link, -1)
            pose = robot.forward_kinematics(q, body.name)
            centre = pose[:3, 3] + 0.01 * pose[:3, 2]
            assert point[8] == pytest.approx(float(np.linalg.norm(centre)) - 0.11, abs=1e-9)
    world.close()


def test_merged_links_have_the_mass_of_all(tmp_path: Path) -> None:
    world = World(chain_of(tmp_path, links=150, moving=10), simulated=True)
    count = world.client.call("getNumJoints", world.robot)
    masses = [world.client.call("getDynamicsInfo", world.robot, index)[0] for index in range(count)]
    world.close()
    assert sum(masses) == pytest.approx(150 * 0.1, abs=0.01)


def test_more_moving_joints_than_pybullet_takes_are_counted(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"'chain' has 131 joints .* up to 127"):
        World(chain_of(tmp_path, links=130, moving=130))


def test_spheres_in_any_number_stand_for_the_geometry_of_a_robot() -> None:
    """Of the Panda, 128: one by one as if there were few."""
    generator = np.random.default_rng(7)
    rows = {
        f"panda_link{link}": [[*generator.uniform(-0.1, 0.1, 3).tolist(), 0.02] for _ in range(16)] for link in range(8)
    }
    entry = {**DEFAULTS, **PANDA, "name": "panda", "base_pose": TILTED}
    robot = SpatialRobot({**entry, "collision": {"spheres": rows}})
    probe = Obstacle({"name": "probe", "shape": "box", "size": [0.2, 0.3, 0.4], "position": [0.5, 0.3, 0.6]})
    space = SpatialSpace(robot, [probe])
    for q in generator.uniform(-1.0, 1.0, (5, 7)):
        expected = np.inf
        for link, spheres in rows.items():
            pose = robot.forward_kinematics(q, link)
            centres = np.array(spheres)[:, :3] @ pose[:3, :3].T + pose[:3, 3]
            gap = np.maximum(np.abs(centres - [0.5, 0.3, 0.6]) - [0.1, 0.15, 0.2], 0.0)
            expected = min(expected, float(np.linalg.norm(gap, axis=1).min()) - 0.02)
        found, name, _ = space.clearance(q.tolist())
        assert name in rows
        if expected > 0.0:
            assert found == pytest.approx(expected, abs=1e-6)
    space.close()
