"""Balls that cover links: against points of the shapes themselves, and by hand."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from itertools import combinations
from math import hypot, sqrt
from pathlib import Path
from timeit import repeat

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.cover import PAYS, Ball, covering_balls, enclosing_ball, link_balls
from pytest_lpb.problem.spatial.meshes import mesh_vertices
from pytest_lpb.problem.spatial.rotations import matrix_of_rpy
from pytest_lpb.problem.spatial.urdf import Geometry, translation
from tests.problem.spatial.robots import ENTRIES, HUSKY, KUKA, PANDA, POINT, TILTED, Entry, spatial_robot

ROUNDING = 1e-9  # [m]
COARSE = 3e-4  # share of a mesh's size: PyBullet rounds the vertices of its convex hull

PAIR_URDF = """<robot name="pair">
  <link name="bare"/>
  <link name="both">
    <collision><origin xyz="0 0 1"/><geometry><sphere radius="0.1"/></geometry></collision>
    <collision><origin xyz="0.5 0 0"/><geometry><box size="0.2 0.2 0.4"/></geometry></collision>
  </link>
  <joint name="turn" type="revolute"><parent link="bare"/><child link="both"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
</robot>
"""


def outside(points: FloatArray, balls: Sequence[Ball]) -> float:
    """How far the worst of points (n, 3) is from the nearest ball [m]; 0 or less: all are in some ball."""
    rows = np.array(balls)
    gaps = np.linalg.norm(points[:, None] - rows[None, :, :3], axis=2) - rows[:, 3]
    return float(gaps.min(axis=1).max())


def only(balls: Sequence[Ball]) -> Ball:
    (ball,) = balls
    return ball


def directions(count: int, rng: np.random.Generator) -> FloatArray:
    rows: FloatArray = rng.standard_normal((count, 3))
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    return rows


def box_points(size: tuple[float, ...], count: int, rng: np.random.Generator) -> FloatArray:
    points = rng.uniform(-0.5, 0.5, (count, 3))
    side = rng.integers(0, 3, count)
    points[np.arange(count), side] = np.round(points[np.arange(count), side] + 0.5) - 0.5  # onto the faces
    return np.vstack([points, rng.uniform(-0.5, 0.5, (count, 3)), np.round(points + 0.5) - 0.5]) * size


def sphere_points(size: tuple[float, ...], count: int, rng: np.random.Generator) -> FloatArray:
    rows = directions(count, rng) * size[0]
    return np.vstack([rows, rows * rng.uniform(0.0, 1.0, (count, 1))])


def cylinder_points(size: tuple[float, ...], count: int, rng: np.random.Generator) -> FloatArray:
    radius, length = size
    angle, height = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(-0.5, 0.5, count) * length
    wall = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    rim = np.column_stack([wall[:, :2], 0.5 * length * np.sign(height)])
    return np.vstack([wall, rim, rim * np.column_stack([*[rng.uniform(0.0, 1.0, count)] * 2, np.ones(count)])])


def capsule_points(size: tuple[float, ...], count: int, rng: np.random.Generator) -> FloatArray:
    radius, length = size
    caps = directions(count, rng) * radius
    caps[:, 2] += 0.5 * length * np.sign(caps[:, 2])
    return np.vstack([caps, [[0.0, 0.0, 0.5 * length + radius]], cylinder_points(size, count, rng)])


POINTS: dict[str, Callable[[tuple[float, ...], int, np.random.Generator], FloatArray]] = {
    "box": box_points,
    "sphere": sphere_points,
    "cylinder": cylinder_points,
    "capsule": capsule_points,
}


def points_of(shape: Geometry, count: int, rng: np.random.Generator) -> FloatArray:
    """Points on a shape and in it, in the link's frame, at least `count`."""
    if shape.file is None:
        points = POINTS[shape.kind](shape.size, count, rng)
    else:
        vertices = mesh_vertices(shape.file, (shape.size[0], shape.size[1], shape.size[2]))
        points = np.vstack([vertices, between(vertices, count, rng)])
    return points @ shape.origin[:3, :3].T + shape.origin[:3, 3]


def between(corners: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    """Convex combinations (2 count, 3) of corners: of few at a time, near the surface, and of two."""
    few = rng.dirichlet(np.full(len(corners), 0.05), count) @ corners
    first, second = corners[rng.integers(0, len(corners), (2, count))]
    return np.vstack([few, first + rng.uniform(0.0, 1.0, (count, 1)) * (second - first)])


LENGTHS = st.floats(0.001, 2.0)


@st.composite
def shapes(draw: st.DrawFn, kinds: tuple[str, ...] = tuple(POINTS)) -> Geometry:
    kind = draw(st.sampled_from(kinds))
    size = draw(st.tuples(*[LENGTHS] * {"box": 3, "sphere": 1}.get(kind, 2)))
    origin = translation(*draw(st.tuples(*[st.floats(-2.0, 2.0)] * 3)))
    origin[:3, :3] = matrix_of_rpy(*draw(st.tuples(*[st.floats(-3.1, 3.1)] * 3)))
    return Geometry(kind, size, origin)


@settings(deadline=None)
@given(shape=shapes(), excess=st.floats(0.0, 0.5), most=st.integers(1, 12), seed=st.integers(0, 1000))
def test_balls_hold_every_point_of_a_shape(shape: Geometry, excess: float, most: int, seed: int) -> None:
    balls = covering_balls(shape, excess, most)
    assert 1 <= len(balls) <= most
    assert outside(points_of(shape, 300, np.random.default_rng(seed)), balls) < ROUNDING


def write_mesh(path: Path, corners: FloatArray) -> Geometry:
    """A mesh of all corners (n, 3) [m]; which triangles there are does not matter to its convex hull."""
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in corners.tolist()]
    lines += [f"f {index} {index + 1} {index + 2}" for index in range(1, len(corners) - 1)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    origin = translation(0.3, -0.2, 0.1)
    origin[:3, :3] = matrix_of_rpy(0.3, -0.8, 1.9)
    return Geometry("mesh", (1.0, 1.0, 1.0), origin, file=path)


@pytest.mark.parametrize("stretch", [(1.0, 1.0, 1.0), (1.0, 0.1, 0.1), (1.0, 1.0, 0.01), (1.0, 1.0, 0.0)], ids=str)
@pytest.mark.parametrize("count", [5, 60])
def test_balls_hold_a_mesh_of_any_form(count: int, stretch: tuple[float, ...], tmp_path: Path) -> None:
    rng = np.random.default_rng(count)
    corners = 0.3 * rng.standard_normal((count, 3)) * stretch
    shape = write_mesh(tmp_path / "mesh.obj", corners)
    points, largest = points_of(shape, 1000, rng), []
    for most in (1, 2, 3, 5, 8):
        balls = covering_balls(shape, 0.0, most)
        assert len(balls) <= most
        assert outside(points, balls) < ROUNDING
        assert outside(corners @ shape.origin[:3, :3].T + shape.origin[:3, 3], balls) < COARSE * np.ptp(corners)
        largest.append(max(ball[3] for ball in balls))
    assert largest[-1] < 0.75 * largest[0]


def test_a_ball_within_another_is_left_out(tmp_path: Path) -> None:
    """The best cover of this tetrahedron by five balls or fewer has four pieces; the ball of one is in another's."""
    corners = np.array([[0.1, -0.2, 0.4], [0.0, -0.2, -0.2], [-0.3, 0.1, 0.0], [0.1, 0.3, 0.0]])
    shape = write_mesh(tmp_path / "tetrahedron.obj", corners)
    balls = covering_balls(shape, 0.0, 5)
    assert len(balls) == 3
    for one, other in combinations(balls, 2):
        assert np.linalg.norm(np.subtract(one[:3], other[:3])) > abs(one[3] - other[3])  # neither in the other
    assert outside(points_of(shape, 3000, np.random.default_rng(3)), balls) < ROUNDING


@pytest.mark.parametrize("entry", [PANDA, KUKA, HUSKY], ids=lambda entry: str(entry["model"]))
@pytest.mark.parametrize("most", [1, 4, 7])
def test_balls_hold_the_links_of_robots(entry: Entry, most: int) -> None:
    robot, rng = spatial_robot(entry), np.random.default_rng(1)
    balls = link_balls(robot, 0.03, most)
    assert tuple(balls) == robot.body_names
    for name, own in balls.items():
        shapes = robot.urdf.link(name).collisions
        assert len(own) <= most * len(shapes)
        for shape in shapes:
            assert outside(points_of(shape, 1000, rng), own) < ROUNDING


def test_a_sphere_is_its_own_ball() -> None:
    assert covering_balls(Geometry("sphere", (0.2,), translation(1.0, 2.0, 3.0)), 0.0, 4) == ((1.0, 2.0, 3.0, 0.2),)
    assert link_balls(spatial_robot(POINT), 0.0, 4) == {"body": ((0.0, 0.0, 0.0, 0.2),)}


def test_capsules_by_hand() -> None:
    """Two balls 0.45 m apart, of 0.375 m, meet 0.3 m off the axis, and reach 0.6 m along it, as the capsule does."""
    capsule = Geometry("capsule", (0.3, 0.6), translation(1.0, 0.0, 0.0))
    expected = {(1.0, 0.0, -0.225, 0.375), (1.0, 0.0, 0.225, 0.375)}
    for excess, most in ((0.076, 9), (0.0, 2)):
        balls = covering_balls(capsule, excess, most)
        assert np.array(sorted(balls)) == pytest.approx(np.array(sorted(expected)))
    assert only(covering_balls(capsule, 0.31, 9)) == pytest.approx((1.0, 0.0, 0.0, 0.6))
    assert only(covering_balls(Geometry("capsule", (0.3, 0.0)), 0.0, 9)) == pytest.approx((0.0, 0.0, 0.0, 0.3))


@given(radius=LENGTHS, length=LENGTHS, excess=st.floats(0.001, 0.5), most=st.integers(2, 30))
def test_a_capsule_has_the_fewest_balls_that_meet_on_its_surface(
    radius: float, length: float, excess: float, most: int
) -> None:
    capsule = Geometry("capsule", (radius, length))
    balls = covering_balls(capsule, excess, most)
    count, beyond = len(balls), balls[0][3] - radius
    assert count == most or beyond <= excess
    if count > 1:
        spacing = (balls[-1][2] - balls[0][2]) / (count - 1)
        assert balls[0][3] == pytest.approx(hypot(radius, 0.5 * spacing))
        assert covering_balls(capsule, excess, count - 1)[0][3] - radius > excess


def test_boxes_by_hand() -> None:
    """A box of two cubes: one ball reaches 0.145 m beyond its long sides, and one ball per cube 0.073 m."""
    origin = translation(1.0, 0.0, 0.0)
    origin[:3, :3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]  # its z is the link's x
    box = Geometry("box", (0.2, 0.2, 0.4), origin)
    assert only(covering_balls(box, 0.146, 4)) == pytest.approx((1.0, 0.0, 0.0, 0.1 * sqrt(6.0)))
    first, second = sorted(covering_balls(box, 0.074, 4))
    assert first == pytest.approx((0.9, 0.0, 0.0, 0.1 * sqrt(3.0)))
    assert second == pytest.approx((1.1, 0.0, 0.0, 0.1 * sqrt(3.0)))


def test_a_cube_is_not_split_in_vain() -> None:
    """A half cube's ball reaches farther beyond the cube than the cube's own, and a quarter's hardly less."""
    cube = Geometry("box", (0.2, 0.2, 0.2))
    assert only(covering_balls(cube, 0.0, 4)) == pytest.approx((0.0, 0.0, 0.0, 0.1 * sqrt(3.0)))
    assert len(covering_balls(cube, 0.0, 8)) == 8


def test_a_box_is_split_for_a_little_only_where_that_is_enough() -> None:
    """One ball reaches 0.099 m beyond this box and two reach 0.088 m: an eighth less."""
    box = Geometry("box", (0.2, 0.2, 0.28))
    assert [len(covering_balls(box, excess, 2)) for excess in (0.1, 0.09, 0.08)] == [1, 2, 1]


@given(radius=LENGTHS, length=LENGTHS)
def test_a_cylinders_ball_is_hardly_larger_than_need_be(radius: float, length: float) -> None:
    ball = only(covering_balls(Geometry("cylinder", (radius, length)), 0.0, 1))
    exact = hypot(radius, 0.5 * length)
    assert exact <= ball[3] < 1.005 * exact


def reach(shape: Geometry, balls: Sequence[Ball]) -> float:
    """How far balls with centres in a box reach beyond its surface [m]."""
    rows = np.array(balls)
    local = (rows[:, :3] - shape.origin[:3, 3]) @ shape.origin[:3, :3]
    return float((rows[:, 3] + (np.abs(local) - 0.5 * np.array(shape.size)).max(axis=1)).max())


@settings(deadline=None, max_examples=30)
@given(shape=shapes(("box",)), excess=st.floats(0.0, 0.5), most=st.integers(2, 10))
def test_a_box_is_split_until_no_ball_reaches_far_beyond_it(shape: Geometry, excess: float, most: int) -> None:
    balls = covering_balls(shape, excess, most)
    reaches = [reach(shape, covering_balls(shape, 0.0, count)) for count in range(1, most + 1)]
    enough = excess if min(reaches) <= excess else PAYS * min(reaches)
    assert reach(shape, balls) <= enough + ROUNDING
    for fewer in range(1, len(balls)):  # none of which would have done
        assert reach(shape, covering_balls(shape, excess, fewer)) > max(excess, reach(shape, balls)) - ROUNDING


@settings(deadline=None, max_examples=30)
@given(shape=shapes(("box", "cylinder", "capsule")), excess=st.floats(0.0, 0.1))
def test_more_balls_are_no_larger(shape: Geometry, excess: float) -> None:
    largest = [max(ball[3] for ball in covering_balls(shape, excess, most)) for most in (1, 2, 3, 5, 9)]
    assert np.diff(largest).max() <= ROUNDING


def volume(balls: Sequence[Ball], rng: np.random.Generator) -> float:
    """Of the union of balls [m^3], from random points."""
    rows = np.array(balls)
    low, high = (rows[:, :3] - rows[:, 3:]).min(axis=0), (rows[:, :3] + rows[:, 3:]).max(axis=0)
    points = rng.uniform(low, high, (4000, 3))
    inside = (np.linalg.norm(points[:, None] - rows[None, :, :3], axis=2) < rows[:, 3]).any(axis=1)
    return float(inside.mean() * np.prod(high - low))


def test_the_panda_takes_few_balls_and_four_per_link_fill_half_as_much_space_as_one() -> None:
    robot, rng = spatial_robot(PANDA), np.random.default_rng(2)
    balls = link_balls(robot, 0.03, 4)
    assert 20 <= sum(map(len, balls.values())) <= 28
    assert max(ball[3] for own in balls.values() for ball in own) < 0.11
    assert len(balls["panda_leftfinger"]) == 1
    volumes = [sum(volume(own, rng) for own in link_balls(robot, 0.03, most).values()) for most in (1, 2, 4)]
    assert volumes[1] < 0.65 * volumes[0]
    assert volumes[2] < min(0.58 * volumes[0], volumes[1])


def test_all_shapes_of_a_link_are_covered(tmp_path: Path) -> None:
    path = tmp_path / "pair.urdf"
    path.write_text(PAIR_URDF, encoding="utf-8")
    robot = spatial_robot({"urdf": str(path), "joints": ["turn"]})
    sphere, box = robot.urdf.link("both").collisions
    balls = link_balls(robot, 0.08, 4)
    assert balls == {"both": (*covering_balls(sphere, 0.08, 4), *covering_balls(box, 0.08, 4))}
    assert len(balls["both"]) == 3


def test_robots_of_equal_geometry_are_covered_once() -> None:
    robot = spatial_robot(ENTRIES["panda"])
    balls = link_balls(robot, 0.03, 4)
    assert link_balls(spatial_robot(ENTRIES["panda"], control="velocity"), 0.03, 4) is balls
    assert link_balls(robot, 0.03, 2) != balls
    elsewhere = link_balls(spatial_robot(PANDA, base_pose={**TILTED, "position": [7.0, 0.0, 0.0]}), 0.03, 4)
    assert elsewhere == balls
    assert min(repeat(lambda: link_balls(robot, 0.03, 4), number=20, repeat=20)) < 20 * 1e-4  # [s]


def test_a_mesh_that_changes_is_covered_anew(tmp_path: Path) -> None:
    corners = 0.1 * np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
    shape = write_mesh(tmp_path / "mesh.obj", corners)
    assert covering_balls(shape, 1.0, 1)[0][3] == pytest.approx(0.1 * sqrt(3.0), rel=COARSE)
    write_mesh(tmp_path / "mesh.obj", 2.0 * corners)
    os.utime(tmp_path / "mesh.obj", (0, 0))
    assert covering_balls(shape, 1.0, 1)[0][3] == pytest.approx(0.2 * sqrt(3.0), rel=COARSE)


def smallest_radius(points: FloatArray) -> float:
    """Of the balls through one to four of the points that hold all, the smallest [m]."""
    best = np.inf
    for count in (1, 2, 3, 4):
        for first, *others in combinations(points, min(count, len(points))):
            spans = np.array(others).reshape(-1, 3) - first
            centre = first + np.linalg.pinv(2.0 * spans) @ (spans**2).sum(axis=1)
            best = min(best, float(np.linalg.norm(points - centre, axis=1).max()))
    return best


COORDINATES = st.one_of(st.integers(-2, 2).map(float), st.floats(-2.0, 2.0).map(lambda x: round(x, 3)))


@settings(deadline=None)
@given(rows=st.lists(st.tuples(*[COORDINATES] * 3), min_size=1, max_size=7))
def test_the_smallest_ball_is_that_of_all_subsets(rows: list[tuple[float, ...]]) -> None:
    points = np.array(rows)
    centre, radius = enclosing_ball(points)
    assert np.linalg.norm(points - centre, axis=1).max() == pytest.approx(radius, abs=1e-12)
    assert radius == pytest.approx(smallest_radius(points), abs=1e-6)
