"""Files that change while a process runs are read anew, whatever their time and size are."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.spatial.content import file_digest
from pytest_lpb.problem.spatial.cover import covering_balls
from pytest_lpb.problem.spatial.mesh_files import check_mesh
from pytest_lpb.problem.spatial.meshes import surface_points
from pytest_lpb.problem.spatial.pool import borrow_world, give_back
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.space import SpatialSpace
from pytest_lpb.problem.spatial.urdf import Geometry
from tests.problem.spatial.entries import point_entry, problem_of
from tests.problem.spatial.robots import DEFAULTS

FACES = (
    *((1, 2, 4), (1, 4, 3), (5, 8, 6), (5, 7, 8), (1, 6, 2), (1, 5, 6)),
    *((3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5), (2, 8, 4), (2, 6, 8)),
)
SECOND_NS = 1_000_000_000


def write_cube(path: Path, half: float, time_ns: int = 10 * SECOND_NS) -> None:
    """A cube of equal size in bytes for all `half` of one decimal, with a time of its own choice."""
    signs = [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    lines = [f"v {x:+.1f} {y:+.1f} {z:+.1f}" for x, y, z in signs]
    path.write_text("\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in FACES), ""]), encoding="utf-8")
    os.utime(path, ns=(time_ns, time_ns))


def clearances(problem: Problem, q: list[float]) -> float:
    space = SpatialSpace(problem.robot, problem.obstacles)  # type: ignore[arg-type] # spatial
    found = space.clearance(q)[0]
    space.close()
    return found


@pytest.mark.parametrize("concave", [False, True])
def test_an_obstacle_s_mesh(tmp_path: Path, concave: bool) -> None:
    mesh = tmp_path / "cube.obj"
    write_cube(mesh, 0.5)
    cube = {"name": "cube", "shape": "mesh", "file": "cube.obj", "position": [0.0, 0.0, 0.0], "concave": concave}
    problem = problem_of(tmp_path, point_entry(0.1, [cube], start={"q": [1.0, 0.0, 0.0]}))
    assert clearances(problem, [1.0, 0.0, 0.0]) == pytest.approx(0.4, abs=1e-6)
    before = file_digest(mesh)
    write_cube(mesh, 0.1)
    assert file_digest(mesh) != before
    assert clearances(problem, [1.0, 0.0, 0.0]) == pytest.approx(0.8, abs=1e-6)
    points = surface_points(str(mesh), 1.0, 0.1, concave=concave)
    assert abs(points).max() == pytest.approx(0.1, abs=1e-4)


def link_of(folder: Path) -> SpatialRobot:
    """A cube on a slide."""
    path = folder / "robot.urdf"
    path.write_text(
        '<robot name="r"><link name="base"/><link name="tool"><collision><geometry><mesh filename="cube.obj"/>'
        '</geometry></collision></link><joint name="j" type="prismatic"><parent link="base"/><child link="tool"/>'
        '<axis xyz="1 0 0"/><limit lower="-5" upper="5" effort="1" velocity="1"/></joint></robot>',
        encoding="utf-8",
    )
    return SpatialRobot({**DEFAULTS, "urdf": str(path), "name": "r", "joints": ["j"]})


def test_a_link_s_mesh(tmp_path: Path) -> None:
    mesh = tmp_path / "cube.obj"
    ball = Obstacle({"name": "ball", "shape": "sphere", "radius": 0.1, "position": [1.0, 0.0, 0.0]})
    found: list[Any] = []
    for half in (0.5, 0.1):
        write_cube(mesh, half)
        robot = link_of(tmp_path)
        space = SpatialSpace(robot, [ball])
        found.append(space.clearance([0.0])[0])
        space.close()
        balls = covering_balls(Geometry("mesh", (1.0, 1.0, 1.0), file=mesh), 0.01, 1)
        assert balls[0][3] == pytest.approx(half * 3.0**0.5, abs=1e-3)
    assert found == pytest.approx([0.4, 0.8], abs=1e-9)


def test_a_world_waits_for_the_robot_that_it_was_made_of(tmp_path: Path) -> None:
    write_cube(tmp_path / "cube.obj", 0.5)
    robot = link_of(tmp_path)
    first = borrow_world(robot)
    give_back(robot, first)
    again = borrow_world(robot)
    assert again is first
    give_back(robot, again)
    write_cube(tmp_path / "cube.obj", 0.1)
    other = borrow_world(robot)
    assert other is not first
    other.close()


def test_a_material_that_a_mesh_names(tmp_path: Path) -> None:
    mesh, material = tmp_path / "cube.obj", tmp_path / "cube.mtl"
    write_cube(mesh, 0.5)
    mesh.write_text("mtllib cube.mtl\n" + mesh.read_text(encoding="utf-8"), encoding="utf-8")
    material.write_text("newmtl grey\nKd 0.5 0.5 0.5\n", encoding="utf-8")
    check_mesh(mesh)
    material.write_text("newmtl grey\nmap_Kd ../../../../../../../../../../etc/passwd\n", encoding="utf-8")
    with pytest.raises(ScenarioError, match="passwd"):
        check_mesh(mesh)
