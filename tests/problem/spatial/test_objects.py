"""Wavefront files of several objects or groups: what is one convex hull, for everybody who asks."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import robot_from
from pytest_lpb.problem.spatial.cover import covering_balls
from pytest_lpb.problem.spatial.hulls import mesh_hulls
from pytest_lpb.problem.spatial.library import library_robot
from pytest_lpb.problem.spatial.meshes import surface_points
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.solids import solids_of
from pytest_lpb.problem.spatial.urdf import Geometry
from pytest_lpb.problem.spatial.urdf_reader import load_urdf
from pytest_lpb.problem.spatial.world import World
from pytest_lpb.scenario.schema.robot import Robot
from pytest_lpb.scenario.spatial import SpatialDescription
from tests.scenario.urdfs import joint, link, mesh, write_urdf

CORNERS = list(product((-1, 1), repeat=3))
SIDES = ((1, 2, 4, 3), (5, 6, 8, 7), (1, 2, 6, 5), (3, 4, 8, 7), (1, 3, 7, 5), (2, 4, 8, 6))


def vertices(x: float, corners: Sequence[int] = range(1, 9)) -> str:
    """Corners of a cube of 2 m around (x, 0, 0)."""
    return "".join(f"v {x + CORNERS[i - 1][0]} {CORNERS[i - 1][1]} {CORNERS[i - 1][2]}\n" for i in corners)


def faces(start: int) -> str:
    return "".join("f " + " ".join(str(start + corner) for corner in side) + "\n" for side in SIDES)


TWO = f"o first\n{vertices(0)}{faces(0)}g second\n{vertices(6)}{faces(8)}"
GROUPED = vertices(0) + "".join(f"g side{i}\nf {' '.join(map(str, side))}\n" for i, side in enumerate(SIDES))
SEPARATE = "".join(f"g side{i}\n{vertices(0, side)}f -4 -3 -2 -1\n" for i, side in enumerate(SIDES))
MIXED = f"{SEPARATE}o second\n{vertices(6)}{faces(24)}"


def written(folder: Path, content: str) -> Path:
    path = folder / "a.obj"
    path.write_text(content)
    return path


@pytest.mark.parametrize(
    ("content", "centres"),
    [(TWO, [0, 6]), (GROUPED, [0]), (SEPARATE, [0]), (MIXED, [0, 6]), (vertices(0) + faces(0), [0])],
    ids=["two objects", "sides that share corners", "sides with their own corners", "both", "no object"],
)
def test_closed_objects_are_hulls_of_their_own(content: str, centres: list[int], tmp_path: Path) -> None:
    path = written(tmp_path, content)
    hulls = mesh_hulls(path, (1.0, 1.0, 1.0))
    assert sorted(hull[:, 0].mean() for hull in hulls) == pytest.approx(centres)
    assert all(len(np.unique(hull, axis=0)) == 8 for hull in hulls)
    points = surface_points(str(path), 1.0, 0.5, concave=False)
    assert not ((points[:, 0] > 1.001) & (points[:, 0] < 4.999)).any()
    assert len(solids_of(Geometry("mesh", (1.0, 1.0, 1.0), file=path))) == len(centres)


def ball(x: float, y: float) -> Obstacle:
    entry = {"name": "ball", "shape": "sphere", "radius": 0.2, "position": [x, y, 0.0]}
    return Obstacle({**entry, "orientation": [1.0, 0.0, 0.0, 0.0]})


def slider(folder: Path) -> SpatialRobot:
    """A link with the mesh `a.obj`, which slides along z."""
    path = write_urdf(
        folder / "r.urdf", (link("base", ""), link("tool", mesh("a.obj")), joint("j", "base", "tool", "prismatic"))
    )
    text = path.read_text("utf-8").replace('<origin xyz="0.5 0 0"/>', "")
    path.write_text(text, "utf-8")
    robot = robot_from(SpatialDescription(Robot(urdf=str(path))).entry)
    assert isinstance(robot, SpatialRobot)
    return robot


@pytest.mark.parametrize(
    ("content", "x", "distance"), [(TWO, 3.0, 1.8), (TWO, 6.0, -1.2), (GROUPED, 0.0, -1.2), (SEPARATE, 0.0, -1.2)]
)
def test_links_are_measured_by_these_hulls(content: str, x: float, distance: float, tmp_path: Path) -> None:
    """Between two cubes there is room; within a cube whose sides are groups there is none, forces or not."""
    written(tmp_path, content)
    robot = slider(tmp_path)
    with closing(robot.collision_space([ball(x, 0.0)])) as space:
        assert space.clearance([0.0])[0] == pytest.approx(distance, abs=1e-6)
    simulated = World(robot, simulated=True)
    simulated.set_obstacles([ball(x, 0.0)])
    simulated.place(0, (x, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    simulated.client.call("performCollisionDetection")
    touching = simulated.client.call("getContactPoints", simulated.robot, simulated.obstacles[0])
    assert bool(touching) == (distance < 0.0)
    simulated.close()


def test_spheres_of_planners_hold_all_hulls(tmp_path: Path) -> None:
    path = written(tmp_path, TWO)
    found = np.array(covering_balls(Geometry("mesh", (1.0, 1.0, 1.0), file=path), 0.1, 8))
    for hull in mesh_hulls(path, (1.0, 1.0, 1.0)):
        distances = np.linalg.norm(hull[:, None] - found[:, :3], axis=2) - found[:, 3]
        assert (distances.min(axis=1) < 1e-3).all()


def test_parts_of_a_convex_decomposition_stay_apart() -> None:
    """The xArm that comes with PyBullet, by V-HACD."""
    model = load_urdf(library_robot("xarm6").path)
    counts = [
        len(mesh_hulls(shape.file, (1.0, 1.0, 1.0))) for one in model.links for shape in one.collisions if shape.file
    ]
    assert counts == [5, 2, 3, 3, 5, 2, 1]
