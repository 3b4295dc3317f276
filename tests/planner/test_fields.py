"""Distances and control points of potential fields, against exact geometry and finite differences."""

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from pytest_lpb.planner.base import ObstacleInfo
from pytest_lpb.planner.fields import ControlPoints, ObstacleField, SelfDistances
from pytest_lpb.planner.planar_rows import point_on_link
from pytest_lpb.problem.planar.robot import PlanarRobot
from pytest_lpb.problem.planar.shapes import SHAPES

from .problems import CART, POINT, Array, Entry, arm, circle, problem_of, reach, rectangle

COORDINATE = st.floats(-3.0, 3.0)
LENGTH = st.floats(0.05, 2.0)
CIRCLES = st.builds(circle, COORDINATE, COORDINATE, LENGTH)
RECTANGLES = st.builds(rectangle, COORDINATE, COORDINATE, LENGTH, LENGTH, st.floats(-4.0, 4.0))


def field_of(entries: list[Entry]) -> ObstacleField:
    return ObstacleField(
        [
            ObstacleInfo(o["name"], o["shape"], o.get("radius"), tuple(o["size"]) if "size" in o else None, False)
            for o in entries
        ]
    )


def distances(entries: list[Entry], points: list[tuple[float, float]]) -> tuple[Array, Array]:
    seen = {
        "obstacle_position": np.array([o["position"] for o in entries]),
        "obstacle_orientation": np.array([o["orientation"] for o in entries]),
    }
    return field_of(entries).distances(np.array(points), seen)


def exact(entry: Entry, x: float, y: float) -> float:
    shape = SHAPES[entry["shape"]](entry)
    shape.place(entry["position"][0], entry["position"][1], entry["orientation"])
    return shape.distance_to_segment(x, y, x, y)


@given(
    st.lists(CIRCLES | RECTANGLES, min_size=1, max_size=3),
    st.lists(st.tuples(COORDINATE, COORDINATE), min_size=1, max_size=3),
)
# The way out was 1.414 long: a subnormal offset has no length of its own.
@example([circle(0.0, 0.0, 0.5)], [(5e-324, 5e-324)])
@example([rectangle(0.0, 0.0, 1.0, 1.0, 1.0), circle(0.0, 0.0, 0.5)], [(5e-324, 5e-324)])
def test_distances_are_exact_inside_and_outside(entries: list[Entry], points: list[tuple[float, float]]) -> None:
    distance, away = distances(entries, points)
    expected = [[exact(entry, *point) for entry in entries] for point in points]
    assert distance == pytest.approx(np.array(expected), abs=1e-12)
    assert np.linalg.norm(away, axis=2) == pytest.approx(np.ones(distance.shape), abs=1e-12)


@given(CIRCLES | RECTANGLES, COORDINATE, COORDINATE)
def test_a_step_away_gains_its_whole_length(entry: Entry, x: float, y: float) -> None:
    distance, away = distances([entry], [(x, y)])
    step = 1e-4
    assume(distance[0, 0] > -0.01)  # deep inside, the nearest face may change on the way
    gained = exact(entry, *(np.array([x, y]) + step * away[0, 0])) - distance[0, 0]
    assert gained == pytest.approx(step, rel=1e-6)


def test_directions_lead_out_of_the_middle_of_an_obstacle() -> None:
    for entry in (circle(1.0, 2.0, 0.5), rectangle(1.0, 2.0, 0.6, 0.4, 0.3)):
        distance, away = distances([entry], [(1.0, 2.0)])
        assert distance[0, 0] == pytest.approx(exact(entry, 1.0, 2.0))
        assert exact(entry, *(np.array([1.0, 2.0]) - 1.001 * distance[0, 0] * away[0, 0])) == pytest.approx(
            0.0, abs=1e-3
        )


def test_rows_of_observations_beyond_the_obstacles_do_not_count() -> None:
    entry = circle(1.0, 0.0, 0.5)
    seen = {"obstacle_position": np.array([[1.0, 0.0], [0.0, 0.0]]), "obstacle_orientation": np.zeros(2)}
    assert field_of([entry]).distances(np.zeros((1, 2)), seen)[0].tolist() == [[0.5]]


ROBOTS = {"point": POINT, "arm": arm(0.6, 0.5, 0.4), "cart": CART}


def control_points(name: str, spacing: float = 0.2, lookahead: float = 0.3) -> tuple[PlanarRobot, ControlPoints]:
    robot = problem_of(ROBOTS[name], [reach({"point": "body", "arm": "end", "cart": "base"}[name], 0, 0)]).robot
    assert isinstance(robot, PlanarRobot)
    return robot, ControlPoints(robot, spacing, lookahead)


@pytest.mark.parametrize("name", ROBOTS)
def test_control_points_move_as_their_jacobians_say(name: str) -> None:
    robot, points = control_points(name)
    step = 1e-6
    for q in np.random.default_rng(2).uniform(-2.0, 2.0, (5, robot.dof)):
        _, jacobians = points.at(q)
        for column in range(robot.dof):
            move = step * np.eye(robot.dof)[column]
            slope = (points.at(q + move)[0] - points.at(q - move)[0]) / (2.0 * step)
            assert jacobians[:, :, column] == pytest.approx(slope, abs=1e-8)


def test_control_points_lie_along_the_links_ends_included() -> None:
    robot, points = control_points("arm", spacing=0.25)
    q = np.array([0.3, -0.8, 1.1])
    expected = [point_on_link(robot, "base", (0, 0), q)[0]]
    for link, length, count in (("link1", 0.6, 3), ("link2", 0.5, 2), ("link3", 0.4, 2)):
        expected += [point_on_link(robot, link, (length * i / count, 0), q)[0] for i in range(count + 1)]
    assert points.at(q)[0] == pytest.approx(np.array(expected), abs=1e-12)
    assert points.radii.tolist() == [0.05] * len(expected)
    assert points.owners == ["base"] + ["link1"] * 4 + ["link2"] * 3 + ["link3"] * 3


def test_a_cart_has_a_second_disc_ahead() -> None:
    _, points = control_points("cart", lookahead=0.4)
    positions, _ = points.at(np.array([1.0, 2.0, np.pi / 2]))
    assert positions == pytest.approx(np.array([[1.0, 2.0], [1.0, 2.4]]))
    assert points.radii.tolist() == [0.2, 0.2]


def test_only_the_nearest_point_of_each_body_is_pushed() -> None:
    _, points = control_points("arm", spacing=0.3)
    positions, _ = points.at(np.zeros(3))
    distance = np.hypot(positions[:, 0] - 0.85, positions[:, 1] - 0.3)[:, None]
    chosen = np.flatnonzero(points.nearest(distance))
    assert positions[chosen, 0] == pytest.approx([0.0, 0.6, 0.85, 1.1])  # base, then one of each link


@given(st.lists(st.floats(-2.5, 2.5), min_size=3, max_size=3))
def test_self_distances_are_those_of_the_nearest_points(q: list[float]) -> None:
    robot, points = control_points("arm", spacing=0.2)
    positions, _ = points.at(np.array(q))
    first, second, distance = SelfDistances(robot, points).nearest(positions, within=0.3)
    found: dict[tuple[str, str], float] = {}
    for i, j, d in zip(first.tolist(), second.tolist(), distance.tolist(), strict=True):
        found[points.owners[i], points.owners[j]] = d
    owners = np.array(points.owners)
    for one, other in robot.self_collision_pairs:
        a, b = positions[owners == one], positions[owners == other]
        least = np.min(np.linalg.norm(a[:, None] - b[None], axis=2)) - 0.1
        assert found.get((one, other), np.inf) == pytest.approx(least if least < 0.3 else np.inf, abs=1e-12)
