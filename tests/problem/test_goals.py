"""Errors of sub-goals, by hand."""

from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.problem.angles import angle_error
from pytest_lpb.problem.goal import SubGoal, goal_from

from .entries import ARM, CART, POINT, Entry, make_problem, make_robot, position_goal

Q = [pi / 2, -pi / 2, 0.0]  # of the arm of lengths 1, 0.5, 0.8: up, then right; the tip is at (1.3, 1)


def sub_goal(entry: Entry, robot: Entry = ARM) -> SubGoal:
    return goal_from([{"name": "g", **entry}], make_robot(robot))[0]


def error(goal: SubGoal, q: list[float], t: float = 0.0) -> float:
    target = goal.motion.evaluate(np.array([t]))[0][0].tolist()
    return goal.distance(goal.value(q, goal.robot.frames(q)), target)


def position(link: str = "end", **keys: Any) -> SubGoal:
    return sub_goal({"type": "position", "link": link, **keys})


def test_position() -> None:
    assert error(position(target=[1.3, 1.0]), Q) == pytest.approx(0.0, abs=1e-15)
    assert error(position(target=[1.3 + 3.0, 1.0 - 4.0]), Q) == pytest.approx(5.0)
    assert error(position("link3", target=[0.5, 1.0]), Q) == pytest.approx(0.0, abs=1e-15)
    assert position(target=[0.0, 0.0]).unit == "m"


def test_position_on_one_axis_of_the_world() -> None:
    assert error(position(target=[0.4], axes=[1]), Q) == pytest.approx(0.6)
    assert error(position(target=[0.4], axes=[0]), Q) == pytest.approx(0.9)
    assert error(position(target=[1.0, 1.3], axes=[1, 0]), Q) == pytest.approx(0.0, abs=1e-15)


def test_position_of_a_point_in_the_link() -> None:
    # link1 points up: its own x is the world's y.
    assert error(position("link1", target=[-0.2, 0.3], point=[0.3, 0.2]), Q) == pytest.approx(0.0, abs=1e-15)
    assert error(position("end", target=[1.4, 1.2], point=[0.1, 0.2]), Q) == pytest.approx(0.0, abs=1e-15)


def test_position_relative_to_a_link_turns_with_it() -> None:
    # Seen from link1 (at the origin, x up): the tip (1.3, 1) is 1 ahead and 1.3 to the right.
    assert error(position(target=[1.0, -1.3], relative_to="link1"), Q) == pytest.approx(0.0, abs=1e-15)
    turned = [pi / 2 + 0.7, *Q[1:]]
    assert error(position(target=[1.0, -1.3], relative_to="link1"), turned) == pytest.approx(0.0, abs=1e-14)
    assert error(position(target=[1.3, 1.0], relative_to="world"), Q) == pytest.approx(0.0, abs=1e-15)


def test_orientation_wraps() -> None:
    goal = sub_goal({"type": "orientation", "link": "base", "target": [pi - 0.1]}, CART)
    assert goal.unit == "rad"
    assert error(goal, [0.0, 0.0, -pi + 0.1]) == pytest.approx(0.2)
    assert error(goal, [0.0, 0.0, pi - 0.1 + 6.0 * pi]) == pytest.approx(0.0, abs=1e-14)
    assert error(goal, [0.0, 0.0, -0.1]) == pytest.approx(pi)


def test_orientation_of_an_arm_adds_up_its_joints() -> None:
    goal = sub_goal({"type": "orientation", "link": "end", "target": [0.5]})
    assert error(goal, [0.1, 0.2, 0.3]) == pytest.approx(0.1)


@given(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.integers(-5, 5))
def test_angle_errors_ignore_whole_turns(value: float, target: float, turns: int) -> None:
    exact = angle_error(value, target)
    assert 0.0 <= exact <= pi
    assert angle_error(value + 2.0 * pi * turns, target) == pytest.approx(exact, abs=1e-12)
    assert angle_error(target, value) == pytest.approx(exact, abs=1e-12)


def test_joints_count_by_their_largest_error() -> None:
    goal = sub_goal({"type": "joint", "joints": ["joint3", "joint1"], "target": [1.0, -1.0]})
    assert error(goal, [-0.8, 99.0, 1.1]) == pytest.approx(0.2)
    assert goal.unit == "rad"


def test_the_unit_of_joint_goals_follows_the_joints() -> None:
    def unit(joints: list[str], robot: Entry) -> str:
        return sub_goal({"type": "joint", "joints": joints, "target": [0.0] * len(joints)}, robot).unit

    assert unit(["x", "y"], POINT) == "m"
    assert unit(["theta"], CART) == "rad"
    assert sub_goal({"type": "joint", "joints": ["joint1"], "target": [0.0]}).unit == "rad"


def test_alignment_with_the_world() -> None:
    keys = {"type": "alignment", "link": "link1", "axis": [1.0, 0.0], "other": "world"}
    assert error(sub_goal({**keys, "other_axis": [0.0, 2.0]}), Q) == pytest.approx(0.0, abs=1e-15)
    assert error(sub_goal({**keys, "other_axis": [0.0, -1.0]}), Q) == pytest.approx(pi)
    assert error(sub_goal({**keys, "other_axis": [1.0, 1.0]}), Q) == pytest.approx(pi / 4)


def test_alignment_with_another_link() -> None:
    keys = {"type": "alignment", "link": "end", "axis": [0.0, 3.0], "other": "link1", "other_axis": [1.0, 0.0]}
    assert error(sub_goal(keys), Q) == pytest.approx(0.0, abs=1e-15)
    assert error(sub_goal(keys), [0.4, -pi / 2 + 0.3, 0.2]) == pytest.approx(0.5)


def test_a_moving_target() -> None:
    goal = position(trajectory=["1.3 + t", "sin(t)"])
    assert goal.moving
    assert error(goal, Q, t=pi / 2) == pytest.approx(pi / 2)
    assert not position(target=[0.0, 0.0]).moving
    spline = position(spline=[[0.0, 1.3, 1.0], [1.0, 1.3, 1.0], [2.0, 1.3, 4.0]])
    assert error(spline, Q, t=0.0) == pytest.approx(0.0, abs=1e-15)
    assert error(spline, Q, t=9.0) == pytest.approx(3.0)  # held outside


def test_primary() -> None:
    first, second = position_goal([1.0, 0.0], name="a"), position_goal([2.0, 0.0], name="b")
    assert make_problem(goal=[first, second]).primary.name == "a"
    assert make_problem(goal=[first, {**second, "primary": True}]).primary.name == "b"


def test_distance_is_euclidean() -> None:
    goal = make_problem(goal=[position_goal([1.0, 1.0])]).primary
    assert error(goal, [0.0, 0.0]) == pytest.approx(sqrt(2.0))


def test_heading_of_a_base_is_wrapped_and_an_arm_joint_is_not() -> None:
    cart = make_robot(CART)
    heading = goal_from([{"name": "h", "type": "joint", "joints": ["theta"], "target": [3.0], "tolerance": 0.1}], cart)
    assert heading[0].distance([-3.0], [3.0]) == pytest.approx(2 * pi - 6.0)
    arm = make_robot(ARM)
    joint = goal_from([{"name": "j", "type": "joint", "joints": ["joint1"], "target": [3.0], "tolerance": 0.1}], arm)
    assert joint[0].distance([-3.0], [3.0]) == pytest.approx(6.0)


def test_targets_beyond_an_arms_reach() -> None:
    arm = make_robot(ARM, links=[1.0, 0.5])
    reach = goal_from([position_goal([1.6, 0.0], "end", tolerance=0.05)], arm)[0]
    assert reach.beyond_reach([1.56, 0.0])
    assert not reach.beyond_reach([0.0, 1.54])
    assert not goal_from([position_goal([99.0, 0.0])], make_robot(POINT))[0].beyond_reach([99.0, 0.0])
