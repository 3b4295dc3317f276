"""Obstacles in space: their shapes, where they are, and how they are turned."""

from math import cos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.spatial.rotations import from_axis_angle, matrix_of

from .entries import point_entry, problem_of, write_torus

TIMES = np.array([0.0, 0.5, 2.0])


def obstacle(**keys: Any) -> Obstacle:
    return Obstacle({"name": "thing", "shape": "sphere", "radius": 0.2, "position": [1.0, 2.0, 3.0], **keys})


def box(**keys: Any) -> Obstacle:
    return Obstacle({"name": "thing", "shape": "box", "size": [0.2, 0.4, 0.6], "position": [1.0, 2.0, 3.0], **keys})


def test_what_is_said_of_each_shape() -> None:
    assert obstacle().radius == 0.2
    assert box().size == (0.2, 0.4, 0.6)
    pillar = obstacle(shape="cylinder", length=1.5)
    assert (pillar.radius, pillar.length) == (0.2, 1.5)
    mesh = Obstacle({"name": "ring", "shape": "mesh", "file": "ring.obj", "position": [0.0, 0.0, 1.0]})
    assert (mesh.file, mesh.scale, mesh.concave) == ("ring.obj", 1.0, False)
    scaled = Obstacle({**mesh.entry, "scale": 0.001, "concave": True})
    assert (scaled.scale, scaled.concave) == (0.001, True)
    assert (scaled.radius, scaled.size, scaled.length) == (None, None, None)


@pytest.mark.parametrize("orientation", [{}, {"orientation": None}])
def test_upright_by_default(orientation: dict[str, Any]) -> None:
    thing = obstacle(**orientation)
    positions, turns = thing.poses(TIMES)
    assert_array_equal(positions, [[1.0, 2.0, 3.0]] * 3)
    assert_array_equal(turns, [[1.0, 0.0, 0.0, 0.0]] * 3)
    assert not thing.moving


def test_a_quaternion_is_brought_to_length_one() -> None:
    positions, turns = box(orientation=[1.0, 2.0, -2.0, 4.0]).poses(TIMES)
    assert_allclose(turns, [[0.2, 0.4, -0.4, 0.8]] * 3, rtol=1e-15)
    assert positions.shape == (3, 3)


def test_an_axis_and_an_angle() -> None:
    """Half a turn about the diagonal of y and z exchanges these axes; the axis may have any length."""
    _, turns = box(orientation={"axis": [0.0, 5.0, 5.0], "angle": pi}).poses(TIMES)
    assert_allclose(matrix_of(turns[0]) @ [1.0, 2.0, 3.0], [-1.0, 3.0, 2.0], atol=1e-15)
    assert_array_equal(turns[0], turns[2])


def test_turning_about_an_axis() -> None:
    thing = box(orientation={"axis": [0.0, 0.0, 2.0], "angle": "3*t"})
    assert thing.moving
    assert not thing.motion.moving
    turns = thing.poses(TIMES)[1]
    assert_allclose(turns, [[cos(1.5 * t), 0.0, 0.0, sin(1.5 * t)] for t in TIMES], atol=1e-15)


def test_moving_and_turning_are_apart() -> None:
    flying = obstacle(position=None, trajectory=["t", "0", "1 - t"])
    assert flying.moving
    assert not flying.turning.moving
    assert_allclose(flying.poses(TIMES)[0], [[t, 0.0, 1.0 - t] for t in TIMES])
    along = box(position=None, spline=[[0.0, 0.0, 0.0, 0.0], [2.0, 1.0, 2.0, 3.0]], orientation=[0.0, 0.0, 0.0, 1.0])
    positions, turns = along.poses(np.array([0.0, 1.0, 9.0]))
    assert_allclose(positions, [[0.0, 0.0, 0.0], [0.5, 1.0, 1.5], [1.0, 2.0, 3.0]], atol=1e-15)
    assert_array_equal(turns, [[0.0, 0.0, 0.0, 1.0]] * 3)


@pytest.mark.parametrize("rows", [0, 1, 5])
def test_poses_have_a_row_per_time(rows: int) -> None:
    positions, turns = box(orientation={"axis": [1.0, 0.0, 0.0], "angle": "t"}).poses(np.zeros(rows))
    assert positions.shape == (rows, 3)
    assert turns.shape == (rows, 4)
    planar = Obstacle({"name": "bar", "shape": "rectangle", "size": [1.0, 0.1], "position": [1.0, 2.0]})
    positions, turns = planar.poses(np.zeros(rows))
    assert positions.shape == (rows, 2)
    assert turns.shape == (rows,)


def loaded(folder: Path, *obstacles: dict[str, Any]) -> Problem:
    """A problem loaded from a scenario file with these obstacles."""
    return problem_of(folder, point_entry(0.1, list(obstacles), start={"q": [0.0, 0.0, 0.0]}))


def test_obstacles_of_a_scenario_file(tmp_path: Path) -> None:
    problem = loaded(
        tmp_path,
        {"shape": "sphere", "radius": 0.3, "position": [2.0, 0.0, 1.0]},
        {"shape": "box", "size": [1.0, 0.1, 0.5], "position": [0.0, 3.0, 1.0], "orientation": [0.0, 0.0, 3.0, 4.0]},
        {
            "name": "fan",
            "shape": "capsule",
            "radius": 0.1,
            "length": 0.5,
            "position": [0.0, -3.0, 1.0],
            "orientation": {"axis": [0, 1, 0], "angle": "0.5*t"},
        },
    )
    ball, bar, fan = problem.obstacles
    assert [thing.name for thing in problem.obstacles] == ["obstacle0", "obstacle1", "fan"]
    assert_array_equal(ball.poses(TIMES)[1], [[1.0, 0.0, 0.0, 0.0]] * 3)
    assert_allclose(bar.poses(TIMES)[1], [[0.0, 0.0, 0.6, 0.8]] * 3, rtol=1e-15)
    assert_allclose(fan.poses(TIMES)[1], [from_axis_angle([0.0, 1.0, 0.0], 0.5 * t) for t in TIMES])
    assert [thing.moving for thing in problem.obstacles] == [False, False, True]
    again = Problem.from_dict(problem.to_dict())
    assert again.problem_hash == problem.problem_hash
    for first, second in zip(problem.obstacles, again.obstacles, strict=True):
        for mine, other in zip(first.poses(TIMES), second.poses(TIMES), strict=True):
            assert_array_equal(mine, other)


def ring(**keys: Any) -> dict[str, Any]:
    return {"name": "ring", "shape": "mesh", "file": "torus.obj", "position": [0.0, 0.0, 3.0], **keys}


def test_a_mesh_is_identified_by_its_content(tmp_path: Path) -> None:
    hashes = []
    for name in ("here", "there"):
        folder = tmp_path / name
        folder.mkdir()
        mesh = write_torus(folder / "torus.obj", major=0.5, minor=0.1, around=6, across=4)
        hashes.append(loaded(folder, ring()).problem_hash)
    assert hashes[0] == hashes[1]
    text = mesh.read_text(encoding="utf-8")
    mesh.write_text(text.replace("f ", "f  ", 1), encoding="utf-8")
    assert loaded(folder, ring()).problem_hash != hashes[0]


@pytest.mark.parametrize(
    "change", [{"scale": 2.0}, {"concave": True}, {"orientation": [0.0, 1.0, 0.0, 0.0]}, {"position": [0.0, 0.0, 4.0]}]
)
def test_all_that_a_mesh_is_counts_in_the_hash(change: dict[str, Any], tmp_path: Path) -> None:
    write_torus(tmp_path / "torus.obj", major=0.5, minor=0.1, around=6, across=4)
    assert loaded(tmp_path, ring(**change)).problem_hash != loaded(tmp_path, ring()).problem_hash
