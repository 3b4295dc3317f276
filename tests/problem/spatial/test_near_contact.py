"""Distances about contact against closed forms, to the last digits that numbers have."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.spatial.convex.cores import CORES, Core, Points, cores_of
from pytest_lpb.problem.spatial.near_contact import NEAR_M, exact_distance
from pytest_lpb.problem.spatial.rotations import from_axis_angle, from_matrix, matrix_of
from pytest_lpb.problem.spatial.space import SpatialSpace
from tests.problem.spatial.convex_shapes import Array
from tests.problem.spatial.test_exact_distances import KINDS, VERTICES, pose_of, robot_of

EXACT = 1e-8  # [m]
GAPS = [0.0, 1e-12, 1e-9, 1e-7, 2e-6, 1e-4, 1e-3, 3e-3, 0.05]  # [m] and as deep
TABLE = {"shape": "box", "size": [20.0, 20.0, 2.0]}


def core(kind: str) -> Core:
    return Points(VERTICES) if kind == "mesh" else CORES[kind](KINDS[kind].obstacle)


def turns() -> list[Array]:
    """Rotation matrices: in line, and any."""
    generator = np.random.Generator(np.random.PCG64(11))
    axes = [((0.0, 0.0, 1.0), 0.0), ((1.0, 0.0, 0.0), 0.5 * np.pi), ((0.0, 1.0, 0.0), 1e-5)]
    axes += [(tuple(generator.standard_normal(3)), generator.uniform(0.0, np.pi)) for _ in range(4)]
    return [matrix_of(from_axis_angle(axis, angle)) for axis, angle in axes]


def xyzw(matrix: Array) -> tuple[float, ...]:
    w, x, y, z = from_matrix(matrix)
    return x, y, z, w


@pytest.mark.parametrize("kind", KINDS)
def test_a_shape_on_a_wide_table_is_as_far_as_its_lowest_point(kind: str) -> None:
    down = np.array([[0.0, 0.0, -1.0]])
    table = cores_of(TABLE)
    for turn in turns():
        lowest = float(KINDS[kind].convex.support(down @ turn)[0])
        for gap in [*GAPS, *(-gap for gap in GAPS)]:
            # Table and shape are turned as one, and far from the origin.
            for whole, shift in ((np.eye(3), np.zeros(3)), (turn, np.array([40.0, -30.0, 20.0]))):
                place = whole @ np.array([0.3, -0.2, 1.0 + lowest + gap]) + shift
                poses = (place.tolist(), xyzw(whole @ turn)), (shift.tolist(), xyzw(whole))
                found = exact_distance((core(kind),), table, poses)
                assert found == pytest.approx(gap, abs=EXACT), (kind, gap)


@pytest.mark.parametrize("angle", [0.0, 1e-7, 1e-3, 0.4, 0.5 * np.pi])
def test_two_cylinders_whose_sides_meet(angle: float) -> None:
    one, other = core("cylinder"), core("cylinder")
    turn = matrix_of(from_axis_angle((1.0, 0.0, 0.0), angle))
    for gap in [*GAPS, *(-gap for gap in GAPS)]:
        poses = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), ((0.6 + gap, 0.02, 0.01), xyzw(turn))
        found = exact_distance((one,), (other,), poses)
        expected = float(np.hypot(0.6 + gap, 0.02)) - 0.6 if angle == 0.0 else gap
        if 0.0 < angle < 0.1:  # neither parallel nor crossed along their lengths: in between
            assert gap - EXACT < found < np.hypot(0.6 + gap, 0.02) - 0.6 + EXACT
        else:
            assert found == pytest.approx(expected, abs=EXACT), gap


def test_of_a_mesh_of_two_objects_the_nearer_one_counts() -> None:
    corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
    body = [Points(corners + np.array([offset, 0.0, 0.0])) for offset in (-2.0, 2.0)]
    for gap in GAPS:
        for side in (-1.0, 1.0):
            poses = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), ((side * (2.75 + gap), 0.1, 0.0), (0.0, 0.0, 0.0, 1.0))
            assert exact_distance(body, (core("sphere"),), poses) == pytest.approx(gap, abs=EXACT)


def test_a_flat_hull_that_is_touched_has_no_depth() -> None:
    square = Points(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]))
    still = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    assert exact_distance((square,), (square,), (still, still)) == 0.0
    for gap in GAPS:
        beside = ((1.0 + gap, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
        assert exact_distance((square,), (square,), (beside, still)) == pytest.approx(gap, abs=EXACT)


@pytest.mark.parametrize("kind", KINDS)
def test_what_touches_a_box_has_the_same_distance_at_a_link(kind: str, tmp_path: Path) -> None:
    """Of an obstacle, through all that measures the distance of a robot from it."""
    box = {"name": "box", "shape": "box", "size": [4.0, 5.0, 6.0], "position": [9.0, 0.3, 0.2]}
    robot = robot_of(tmp_path, KINDS["sphere"], KINDS[kind])
    space = SpatialSpace(robot, [Obstacle(box)])
    for angles in ([0.0, 0.0, 0.0], [0.0, 0.0, 0.5 * np.pi], [0.3, -1.1, 2.0]):
        turn = pose_of(np.zeros(3), np.array(angles))[:3, :3]
        farthest = float(KINDS[kind].convex.support(np.array([[1.0, 0.0, 0.0]]) @ turn)[0])
        for gap in [*GAPS, *(-gap for gap in GAPS)]:
            found, link, _ = space.clearance([7.0 - farthest - gap, 0.2, 0.1, *angles])
            assert link == "c_link"
            assert found == pytest.approx(gap, abs=1e-6 if abs(gap) > NEAR_M else EXACT), gap
    space.close()


# Where Bullet 3.2.7 measures far too much: faces and axes are exactly parallel.
ALIGNED = [
    ([0.2, 0.3, -0.7], [np.pi, -np.pi, -np.pi], 0.0),  # Bullet: 0.2600
    ([-0.2, 0.7, -0.4], [-np.pi, -0.5 * np.pi, -np.pi], 0.4),  # Bullet: 0.4373
]


@pytest.mark.parametrize("link", ["box", "capsule"])
@pytest.mark.parametrize(("position", "angles", "distance"), ALIGNED)
def test_parallel_faces_are_measured_right(
    link: str, position: list[float], angles: list[float], distance: float, tmp_path: Path
) -> None:
    other = {"box": "capsule", "capsule": "box"}[link]
    pose = pose_of(np.array(position), np.array(angles))
    away = np.array([8.0, 0.0, 0.0])  # from the robot's other link
    obstacle = {"name": "still", "shape": other, **KINDS[other].obstacle, "position": away.tolist()}
    state = [*(away + pose[:3, 3]), *angles]
    if link == "capsule":
        back: Array = np.linalg.inv(pose).astype(np.float64)
        obstacle |= {"position": (away + back[:3, 3]).tolist(), "orientation": list(from_matrix(back[:3, :3]))}
        state = [*away, 0.0, 0.0, 0.0]
    robot = robot_of(tmp_path, KINDS["sphere"], KINDS[link])
    with SpatialSpace(robot, [Obstacle(obstacle)]) as space:
        found, _, _ = space.clearance(state)
    assert found == pytest.approx(distance, abs=1e-6)
