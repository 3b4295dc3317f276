"""Distances in space: against closed forms, and the broad phase against measuring every pair."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_lpb.environment.engine import engine_for
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.spatial.space import SpatialSpace
from tests.problem.spatial.entries import panda_entry, point_entry, problem_of, scenario_entry, write_torus

EXACT = 1e-6  # [m]
EXACT_BY_SHAPE = {"cylinder": 1e-5}  # [m] Bullet's iterations towards a curved face end earlier
RANDOM = np.random.Generator(np.random.PCG64(7))


def turn(axis: np.ndarray[Any, Any], angle: float) -> np.ndarray[Any, Any]:
    """Rotation matrix of an angle about an axis (Rodrigues)."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix: np.ndarray[Any, Any] = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return matrix


def sphere_distance(p: np.ndarray[Any, Any], radius: float) -> float:
    return float(np.linalg.norm(p)) - radius


def box_distance(p: np.ndarray[Any, Any], size: list[float]) -> float:
    gap = np.abs(p) - 0.5 * np.array(size)
    return float(np.linalg.norm(np.maximum(gap, 0.0)) + min(gap.max(), 0.0))


def capsule_distance(p: np.ndarray[Any, Any], radius: float, length: float) -> float:
    return float(np.linalg.norm(p - [0.0, 0.0, np.clip(p[2], -0.5 * length, 0.5 * length)])) - radius


def cylinder_distance(p: np.ndarray[Any, Any], radius: float, length: float) -> float:
    gap = np.array([hypot(p[0], p[1]) - radius, abs(p[2]) - 0.5 * length])
    return float(np.linalg.norm(np.maximum(gap, 0.0)) + min(gap.max(), 0.0))


SHAPES: dict[str, tuple[dict[str, Any], Callable[[np.ndarray[Any, Any]], float]]] = {
    "sphere": ({"radius": 0.35}, lambda p: sphere_distance(p, 0.35)),
    "box": ({"size": [0.8, 0.5, 1.1]}, lambda p: box_distance(p, [0.8, 0.5, 1.1])),
    "thin box": ({"size": [0.8, 0.004, 1.1]}, lambda p: box_distance(p, [0.8, 0.004, 1.1])),
    "capsule": ({"radius": 0.3, "length": 0.9}, lambda p: capsule_distance(p, 0.3, 0.9)),
    "cylinder": ({"radius": 0.4, "length": 0.7}, lambda p: cylinder_distance(p, 0.4, 0.7)),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_a_sphere_among_shapes_that_are_turned_and_moved_has_the_analytic_distance(shape: str, tmp_path: Path) -> None:
    size, distance = SHAPES[shape]
    problem = problem_of(tmp_path, point_entry(0.1, []))
    space = SpatialSpace(problem.robot, [])  # type: ignore[arg-type] # spatial
    worst = 0.0
    for number in range(300):
        axis, angle = RANDOM.standard_normal(3), RANDOM.uniform(0.0, np.pi)
        position, point = RANDOM.uniform(-1.0, 1.0, 3), RANDOM.uniform(-1.5, 1.5, 3)
        half = axis / np.linalg.norm(axis) * np.sin(0.5 * angle)
        entry = {
            "name": f"o{number}",
            "shape": shape.rpartition(" ")[2],
            "position": position.tolist(),
            "orientation": [float(np.cos(0.5 * angle)), *half.tolist()],
            **size,
        }
        expected = distance(turn(axis, angle).T @ (point - position)) - 0.1
        found = space.clearance_of(Obstacle(entry), point.tolist())
        if expected > -0.1:  # deeper, the sphere's centre is inside
            worst = max(worst, abs(found - expected))
    space.close()
    assert worst < EXACT_BY_SHAPE.get(shape, EXACT)


def test_capsules_of_an_arm_against_a_sphere(tmp_path: Path) -> None:
    ball = {"name": "ball", "shape": "sphere", "radius": 0.2, "position": [0.7, 0.5, 0.3]}
    entry = scenario_entry({"model": "arm_3d", "links": [0.6, 0.4], "body_radius": 0.05}, [ball], joint="joint1")
    problem = problem_of(tmp_path, entry)
    robot = problem.robot
    space = SpatialSpace(robot, problem.obstacles)  # type: ignore[arg-type] # spatial
    for _ in range(50):
        q = RANDOM.uniform(-2.0, 2.0, robot.dof)
        joints = [robot.forward_kinematics(q, name)[:3, 3] for name in ("link1", "link2", "end")]
        centre, nearest = np.array(ball["position"]), np.inf
        for a, b in pairwise(joints):
            share = np.clip((centre - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
            nearest = min(nearest, float(np.linalg.norm(a + share * (b - a) - centre)) - 0.2 - 0.05)
        found = space.clearance(q.tolist())[0]
        if nearest > -0.05:
            assert found == pytest.approx(min(nearest, np.linalg.norm(joints[0] - centre) - 0.25), abs=EXACT)
    space.close()


def test_boxes_of_a_car_against_a_box(tmp_path: Path) -> None:
    wall = {"name": "wall", "shape": "box", "size": [0.2, 4.0, 1.0], "position": [3.0, 0.0, 0.5]}
    problem = problem_of(tmp_path, scenario_entry({"model": "car"}, [wall], joint="x"))
    robot = problem.robot
    body = robot.urdf.link("base").collisions[0]  # type: ignore[attr-defined] # spatial
    front = body.origin[0, 3] + 0.5 * body.size[0]
    space = SpatialSpace(robot, problem.obstacles)  # type: ignore[arg-type] # spatial
    assert space.clearance([0.0, 0.3, 0.0, 0.0])[0] == pytest.approx(2.9 - front, abs=EXACT)
    assert space.clearance([2.95 - front, 0.0, 0.0, 0.0])[0] == pytest.approx(-0.05, abs=EXACT)
    space.close()


def test_a_sphere_passes_through_a_torus_of_a_concave_mesh(tmp_path: Path) -> None:
    write_torus(tmp_path / "torus.obj", major=0.5, minor=0.1)
    ring = {"name": "ring", "shape": "mesh", "file": "torus.obj", "concave": True, "position": [0.0, 0.0, 1.0]}
    problem = problem_of(tmp_path, point_entry(0.1, [ring], start={"q": [0.0, 0.0, 0.0]}))
    space = SpatialSpace(problem.robot, problem.obstacles)  # type: ignore[arg-type] # spatial
    assert space.clearance([0.0, 0.0, 1.0])[0] == pytest.approx(0.3, abs=0.003)
    assert space.clearance([0.35, 0.0, 1.0])[0] == pytest.approx(-0.05, abs=0.003)
    solid = Obstacle({**problem.obstacles[0].entry, "concave": False})
    assert space.clearance_of(solid, [0.0, 0.0, 1.0]) < -0.1
    space.close()


def brute_force(problem: Any, q: list[float], t: float) -> tuple[float, float]:
    """Distances by measuring everything anew, with obstacles where they are at t."""
    moved = []
    for obstacle in problem.obstacles:
        positions, orientations = obstacle.poses(np.array([t]))
        entry = {key: value for key, value in obstacle.entry.items() if key not in ("trajectory", "spline")}
        entry |= {"position": positions[0].tolist(), "orientation": orientations[0].tolist()}
        moved.append(Obstacle(entry))
    space = SpatialSpace(problem.robot, moved)
    found = space.clearance(q)[0], space.self_clearance(q)[0]
    space.close()
    return found


@pytest.mark.parametrize("base", ["fixed", "differential_drive"])
def test_the_broad_phase_loses_nothing_while_robot_and_obstacles_move(base: str, tmp_path: Path) -> None:
    obstacles: list[dict[str, Any]] = [
        {"name": "ball", "shape": "sphere", "radius": 0.1, "trajectory": ["0.5 - 0.4*t", "-0.4 + 0.5*t", "0.6"]},
        {
            "name": "beam",
            "shape": "box",
            "size": [0.1, 1.0, 0.1],
            "position": [0.5, 0.4, 0.5],
            "orientation": {"axis": [1, 0, 0], "angle": "3*t"},
        },
        {"name": "post", "shape": "cylinder", "radius": 0.1, "length": 1.0, "position": [-0.5, 0.3, 0.5]},
    ]
    robot: dict[str, Any] = {"base": base}
    start: dict[str, Any] = {"q": [1.0, 0.0, 0.0, -1.5, 0.0, 1.8675, 0.0]}
    if base != "fixed":
        robot |= {"base_size": [0.6, 0.5, 0.3], "base_pose": {"position": [0.1, 0.0, 0.3]}}
        start = {"q": [0.0, -1.0, 0.3, *start["q"]]}
    problem = problem_of(tmp_path, panda_entry(obstacles, robot=robot, start=start))
    engine = engine_for(problem)
    engine.set_state(problem.start_q.tolist(), problem.start_u.tolist())
    action = [2.0 * (-1.0) ** index for index in range(problem.robot.n_actions)]
    for row in range(60):
        t = row * problem.dt
        poses = [obstacle.poses(np.array([t])) for obstacle in problem.obstacles]
        engine.place_obstacles([p[0].tolist() for p, _ in poses], [o[0].tolist() for _, o in poses])
        (clearance, *_), (own, *_) = engine.clearance()
        expected, expected_own = brute_force(problem, engine.q, t)
        assert clearance == pytest.approx(expected, abs=1e-9)
        assert own == pytest.approx(expected_own, abs=1e-9)
        engine.advance(action)
    engine.close()


def test_names_of_what_is_nearest(tmp_path: Path) -> None:
    far = {"name": "far", "shape": "sphere", "radius": 0.1, "position": [2.0, 2.0, 0.5]}
    near = {"name": "near", "shape": "sphere", "radius": 0.1, "position": [0.45, 0.55, 0.5]}
    problem = problem_of(tmp_path, panda_entry([far, near]))
    space = SpatialSpace(problem.robot, problem.obstacles)  # type: ignore[arg-type] # spatial
    _, body, obstacle = space.clearance(problem.start_q.tolist())
    space.close()
    assert obstacle == "near"
    assert body in ("panda_link7", "panda_hand", "panda_leftfinger", "panda_rightfinger", "panda_link6")


def test_pairs_that_always_overlap_are_left_out(tmp_path: Path) -> None:
    robot = problem_of(tmp_path, panda_entry()).robot
    own = {frozenset(pair) for pair in robot.self_collision_pairs}
    assert frozenset({"panda_hand", "panda_link7"}) not in own  # rigidly joined
    assert frozenset({"panda_link0", "panda_link1"}) not in own  # adjacent
    assert frozenset({"panda_link0", "panda_link7"}) in own
    left_out = {frozenset(pair) for pair in robot.left_out_pairs}  # type: ignore[attr-defined] # spatial
    assert not own & left_out
