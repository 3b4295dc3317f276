"""Collision bodies, the pairs that are checked, and what a clearance names."""

from math import isnan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.problem.collision import Clearance
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.planar.collision import PlanarCollision
from pytest_lpb.problem.planar.robot import PlanarRobot

from .entries import ARM, CART, POINT, Entry, circle, make_robot

WALL: Entry = {"name": "wall", "shape": "rectangle", "size": [0.2, 4.0], "position": [3.0, 0.0]}


def clearances(robot: PlanarRobot, q: list[float], obstacles: list[Entry]) -> tuple[Clearance, Clearance]:
    items = [Obstacle(entry) for entry in obstacles]
    collision = PlanarCollision(robot, items)
    for shape, item in zip(collision.shapes, items, strict=True):
        positions, angles = item.poses(np.zeros(1))
        shape.place(float(positions[0, 0]), float(positions[0, 1]), float(angles[0]))
    capsules = collision.capsules(robot.frames(q))
    return collision.clearance(capsules), collision.self_clearance(capsules)


def names(found: Clearance, distance: float) -> tuple[str, str]:
    """The body and the obstacle, or other body, of a clearance that has this distance."""
    assert found[0] == pytest.approx(distance)
    return found[1:]


def test_bodies() -> None:
    assert [body.name for body in make_robot(POINT).collision_bodies] == ["body"]
    assert [body.name for body in make_robot(CART).collision_bodies] == ["base"]
    bodies = make_robot(ARM).collision_bodies
    assert [body.name for body in bodies] == ["base", "link1", "link2", "link3"]
    assert bodies[0].capsules == ((0.0, 0.0, 0.0, 0.0, 0.05),)
    assert bodies[2].capsules == ((0.0, 0.0, 0.5, 0.0, 0.05),)


def test_all_pairs_but_adjacent_ones() -> None:
    assert make_robot(ARM).self_collision_pairs == (("base", "link2"), ("base", "link3"), ("link1", "link3"))
    assert make_robot(ARM, links=[1.0]).self_collision_pairs == ()
    assert make_robot(POINT).self_collision_pairs == make_robot(CART).self_collision_pairs == ()
    assert make_robot(ARM, self_collision_pairs=[]).self_collision_pairs == ()
    assert make_robot(ARM, self_collision_pairs=[["base", "link3"]]).self_collision_pairs == (("base", "link3"),)


def test_spheres_at_the_link_frames() -> None:
    robot = make_robot(ARM, collision={"link_spheres": 0.2})
    assert [body.name for body in robot.collision_bodies] == list(robot.link_names)
    assert all(body.capsules == ((0.0, 0.0, 0.0, 0.0, 0.2),) for body in robot.collision_bodies)
    # Stretched along x, frames at 0, 0, 1, 1.5, 2.3: an obstacle beside the middle of link1 is 0.5 from two of them.
    found, _ = clearances(robot, [0.0, 0.0, 0.0], [circle(0.5, 0.0, 0.1)])
    assert names(found, 0.5 - 0.2 - 0.1) == ("base", "disc")


def test_own_spheres() -> None:
    spheres = {"link1": [[0.5, 0.1, 0.0, 0.05], [0.9, 0.0, 0.0, 0.1]], "end": [[0.0, 0.0, 0.0, 0.2]]}
    robot = make_robot(ARM, collision={"spheres": spheres})
    assert [body.name for body in robot.collision_bodies] == ["link1", "end"]
    found, _ = clearances(robot, [pi / 2, 0.0, 0.0], [circle(-0.1, 0.2, 0.05)])
    assert names(found, 0.3 - 0.05 - 0.05) == ("link1", "disc")


def test_a_clearance_names_the_nearest_body_and_obstacle() -> None:
    robot = make_robot(ARM)
    near, far = circle(2.3, 0.6, 0.1, "near"), circle(0.0, 5.0, 0.1, "far")
    assert names(clearances(robot, [0.0] * 3, [far, near])[0], 0.6 - 0.1 - 0.05) == ("link3", "near")
    assert names(clearances(robot, [pi, 0.0, 0.0], [far, WALL])[0], 2.9 - 0.05) == ("base", "wall")
    assert names(clearances(robot, [0.0] * 3, [WALL])[0], 2.9 - 2.3 - 0.05) == ("link3", "wall")


def test_penetration_is_negative() -> None:
    # The wall's near side lies at x = 2.9.
    robot = make_robot(POINT)
    found, _ = clearances(robot, [2.8, 0.0], [WALL])
    assert names(found, 0.1 - 0.2) == ("body", "wall")
    (distance, _, _), _ = clearances(robot, [3.0, 0.0], [WALL])
    assert distance == pytest.approx(-0.1 - 0.2)


def test_nothing_to_measure_is_nan() -> None:
    obstacles, own = clearances(make_robot(POINT), [0.0, 0.0], [])
    assert isnan(obstacles[0])
    assert isnan(own[0])
    assert obstacles[1:] == own[1:] == ("", "")


def test_self_clearance_of_a_folded_arm() -> None:
    robot = make_robot(ARM, links=[1.0, 1.0, 1.0])
    # A square without its last side: link3 runs parallel to link1 at distance 1.
    _, (distance, first, second) = clearances(robot, [0.0, pi / 2, pi / 2], [])
    assert distance == pytest.approx(1.0 - 0.1)
    assert (first, second) in {("link1", "link3"), ("base", "link2"), ("base", "link3")}
    _, (distance, first, second) = clearances(robot, [0.0, 0.9 * pi, 0.9 * pi], [])
    assert distance < 0.0
    assert (first, second) == ("link1", "link3")


@given(
    st.lists(st.floats(-3.2, 3.2), min_size=3, max_size=3),
    st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.05, 1.0)), min_size=1, max_size=5),
)
def test_skipping_far_pairs_loses_no_minimum(q: list[float], discs: list[tuple[float, float, float]]) -> None:
    robot = make_robot(ARM)
    obstacles = [circle(x, y, radius, f"o{index}") for index, (x, y, radius) in enumerate(discs)]
    (together, body, obstacle), _ = clearances(robot, q, obstacles)
    alone = {entry["name"]: clearances(robot, q, [entry])[0] for entry in obstacles}
    assert together == pytest.approx(min(distance for distance, _, _ in alone.values()), abs=1e-12)
    assert together == pytest.approx(alone[obstacle][0], abs=1e-12)
    only = next(part for part in robot.collision_bodies if part.name == body)
    assert only.link == body
