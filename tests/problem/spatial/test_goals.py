"""Errors of sub-goals in space: by hand, and against rotation matrices."""

from collections.abc import Sequence
from math import cos, hypot, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from pytest_lpb.problem.goal import SubGoal, goal_from
from pytest_lpb.problem.spatial.robot import Frame, SpatialRobot
from pytest_lpb.problem.spatial.rotations import from_axis_angle, matrix_of, multiply, normalised

from .robots import ARM, CART, MOUNTED, PANDA, POINT, TILTED, Entry, spatial_robot

ARM_ROBOT = spatial_robot(ARM)  # links of 0.5, 0.4 and 0.3 m; the first joint turns about z, the others about y
Q = [pi / 2, -pi / 2, 0.0]  # the first link along the world's y, the others straight up; the end is at (0, 0.5, 0.7)
RANDOM = np.random.Generator(np.random.PCG64(3))

AXES = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda axis: hypot(*axis) > 0.1)
TURNS = st.builds(from_axis_angle, AXES, st.floats(-pi, pi))
POINTS = st.tuples(*[st.floats(-5.0, 5.0)] * 3)
FRAMES = st.builds(lambda point, turn: (*point, *turn), POINTS, TURNS)


def sub_goal(robot: SpatialRobot = ARM_ROBOT, **entry: Any) -> SubGoal:
    return goal_from([{"name": "g", **entry}], robot)[0]


def position(robot: SpatialRobot = ARM_ROBOT, link: str = "end", **keys: Any) -> SubGoal:
    return sub_goal(robot, type="position", link=link, **keys)


def error(goal: SubGoal, q: Sequence[float], t: float = 0.0) -> float:
    target = goal.motion.evaluate(np.array([t]))[0][0].tolist()
    return goal.distance(goal.value(q, goal.robot.frames(q)), target)


def frames_with(goal: SubGoal, **frames: Frame) -> list[Frame]:
    """Frames of all links: those given, others at the origin."""
    rest: Frame = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    return [frames.get(name, rest) for name in goal.robot.link_names]


def at(x: float, y: float, z: float, axis: Sequence[float] = (0.0, 0.0, 1.0), angle: float = 0.0) -> Frame:
    return (x, y, z, *from_axis_angle(axis, angle))


# Position


def test_position() -> None:
    assert error(position(target=[0.0, 0.5, 0.7]), Q) == pytest.approx(0.0, abs=1e-15)
    assert error(position(target=[2.0, 0.5 - 3.0, 0.7 + 6.0]), Q) == pytest.approx(7.0)
    assert error(position(link="link3", target=[0.0, 0.5, 0.4]), Q) == pytest.approx(0.0, abs=1e-15)
    assert position(target=[0.0, 0.0, 0.0]).unit == "m"


@pytest.mark.parametrize(
    ("axes", "target", "distance"),
    [([2], [0.4], 0.3), ([0], [0.4], 0.4), ([2, 1], [0.7, 0.5], 0.0), ([0, 2], [0.3, 1.1], 0.5)],
)
def test_position_on_some_axes_of_the_world(axes: list[int], target: list[float], distance: float) -> None:
    assert error(position(axes=axes, target=target), Q) == pytest.approx(distance, abs=1e-15)


def test_position_of_a_point_in_the_link() -> None:
    # link2 points up: its x is the world's z, its y the world's -x, its z the world's -y.
    assert error(position(link="link2", point=[0.1, 0.2, 0.3], target=[-0.2, 0.2, 0.1]), Q) == pytest.approx(
        0.0, abs=1e-15
    )
    assert error(position(point=[0.0, 0.0, 0.0], target=[0.0, 0.5, 0.7]), Q) == pytest.approx(0.0, abs=1e-15)


def test_position_relative_to_a_link_turns_with_it() -> None:
    # Seen from link1 (at the origin, its x along the world's y): the end is half a metre ahead and 0.7 up.
    goal = position(relative_to="link1", target=[0.5, 0.0, 0.7])
    assert error(goal, Q) == pytest.approx(0.0, abs=1e-15)
    assert error(goal, [Q[0] + 0.7, *Q[1:]]) == pytest.approx(0.0, abs=1e-15)
    assert error(position(relative_to="world", target=[0.0, 0.5, 0.7]), Q) == pytest.approx(0.0, abs=1e-15)


def test_axes_of_a_relative_position_are_those_of_the_other_link() -> None:
    assert error(position(relative_to="link1", axes=[0], target=[0.1]), Q) == pytest.approx(0.4)


@given(FRAMES, FRAMES, POINTS)
def test_a_point_seen_from_another_link_is_what_matrices_say(own: Frame, other: Frame, point: Any) -> None:
    goal = position(relative_to="link1", point=list(point), target=[0.0, 0.0, 0.0])
    found = goal.value([], frames_with(goal, end=own, link1=other))
    in_world = matrix_of(own[3:]) @ point + own[:3]
    assert_allclose(found, matrix_of(other[3:]).T @ (in_world - other[:3]), atol=1e-13)


# Orientation


def orientation(target: Sequence[float], robot: SpatialRobot = ARM_ROBOT, **keys: Any) -> SubGoal:
    return sub_goal(robot, type="orientation", link="end", target=list(target), **keys)


def test_orientation_is_the_angle_of_the_turn_that_is_left() -> None:
    assert orientation([1.0, 0.0, 0.0, 0.0]).unit == "rad"
    assert error(orientation([1.0, 0.0, 0.0, 0.0]), [0.4, 0.0, 0.0]) == pytest.approx(0.4)
    assert error(orientation([0.0, 0.0, 0.0, 1.0]), [0.4, 0.0, 0.0]) == pytest.approx(pi - 0.4)
    about_y = from_axis_angle([0.0, 1.0, 0.0], 0.9)
    assert error(orientation(about_y), [0.0, 0.3, 0.6]) == pytest.approx(0.0, abs=1e-15)


def test_both_quaternions_of_a_turn_are_one_target() -> None:
    target = from_axis_angle([1.0, 2.0, 3.0], 2.5)
    for sign in (1.0, -1.0):
        goal = orientation([sign * x for x in target])
        assert error(goal, Q) == pytest.approx(error(orientation(target), Q))
        assert goal.distance(target, [sign * x for x in target]) == pytest.approx(0.0, abs=1e-15)


def test_targets_need_not_be_of_length_one() -> None:
    target = from_axis_angle([1.0, 2.0, 3.0], 2.5)
    long = orientation([4.0 * x for x in target])
    assert error(long, Q) == pytest.approx(error(orientation(target), Q))
    assert_allclose(long.motion.evaluate(np.zeros(1))[0][0], target, rtol=1e-15)


@given(TURNS, AXES, st.floats(0.0, pi))
def test_a_turn_by_an_angle_is_that_far_away(turn: Sequence[float], axis: Any, angle: float) -> None:
    goal = orientation([1.0, 0.0, 0.0, 0.0])
    assert goal.distance(multiply(from_axis_angle(axis, angle), turn), turn) == pytest.approx(angle, abs=1e-14)


@pytest.mark.parametrize("angle", [1e-9, 1e-6, pi - 1e-9])
def test_small_and_large_angles_are_not_lost_in_rounding(angle: float) -> None:
    goal = orientation([1.0, 0.0, 0.0, 0.0])
    assert goal.distance(from_axis_angle([0.0, 1.0, 0.0], angle), [1.0, 0.0, 0.0, 0.0]) == pytest.approx(
        angle, rel=1e-9, abs=1e-15
    )


# Moving targets


def test_a_moving_target() -> None:
    goal = position(trajectory=["sin(t)", "0.5", "0.7 + t"])
    assert goal.moving
    assert error(goal, Q, t=0.0) == pytest.approx(0.0, abs=1e-15)
    assert error(goal, Q, t=2.0) == pytest.approx(hypot(sin(2.0), 2.0))
    held = position(spline=[[0.0, 0.0, 0.5, 0.7], [1.0, 0.0, 0.5, 3.7]])
    assert error(held, Q, t=9.0) == pytest.approx(3.0)


def turning(**keys: Any) -> SubGoal:
    return sub_goal(type="orientation", link="end", **keys)


def test_a_moving_orientation_has_length_one_at_all_times() -> None:
    """Three times a turn about z by t: the factor goes, its derivatives too."""
    goal = turning(trajectory=["3*(1 + t)*cos(t/2)", "0", "0", "3*(1 + t)*sin(t/2)"])
    t = np.linspace(0.0, 3.0, 7)
    value, velocity, acceleration = goal.motion.evaluate(t)
    along = np.column_stack([np.cos(t / 2), 0 * t, 0 * t, np.sin(t / 2)])
    across = np.column_stack([-np.sin(t / 2), 0 * t, 0 * t, np.cos(t / 2)])
    assert_allclose(value, along, atol=1e-14)
    assert_allclose(velocity, 0.5 * across, atol=1e-13)
    assert_allclose(acceleration, -0.25 * along, atol=1e-13)
    assert goal.moving
    assert error(goal, [0.5, 0.0, 0.0], t=2.0) == pytest.approx(1.5)


def test_an_orientation_along_a_spline_passes_between_its_rows() -> None:
    goal = turning(spline=[[0.0, 1.0, 0.0, 0.0, 0.0], [2.0, cos(0.6), 0.0, 0.0, sin(0.6)]])
    value, velocity, _ = goal.motion.evaluate(np.array([0.0, 1.0, 2.0, 5.0]))
    assert_allclose(np.linalg.norm(value, axis=1), 1.0, atol=1e-15)
    assert_allclose(value[1], [cos(0.3), 0.0, 0.0, sin(0.3)], atol=1e-15)  # half way, by symmetry
    assert_allclose(velocity[[0, 2, 3]], 0.0, atol=1e-13)
    assert error(goal, [1.2, 0.0, 0.0], t=5.0) == pytest.approx(0.0, abs=1e-15)


# Joints


def test_joints_count_by_their_largest_error() -> None:
    goal = sub_goal(type="joint", joints=["joint3", "joint1"], target=[1.0, -1.0])
    assert error(goal, [-0.8, 99.0, 1.1]) == pytest.approx(0.2)
    assert goal.unit == "rad"


def test_the_unit_of_joint_goals_follows_the_joints() -> None:
    def unit(entry: Entry, *joints: str) -> str:
        return sub_goal(spatial_robot(entry), type="joint", joints=list(joints), target=[0.0] * len(joints)).unit

    assert unit(POINT, "x", "z") == "m"
    assert unit(CART, "theta") == "rad"
    fingers = {**PANDA, "joints": [*PANDA["joints"], "panda_finger_joint1"], "locked_joints": {}}
    assert unit(fingers, "panda_finger_joint1") == "m"
    assert unit(fingers, "panda_joint4") == "rad"


def test_the_heading_of_a_base_is_wrapped_and_an_arms_joint_is_not() -> None:
    robot = spatial_robot({**MOUNTED, "base": "holonomic"})
    goal = sub_goal(robot, type="joint", joints=["theta", "panda_joint1"], target=[3.0, 1.0])
    assert goal.distance([-3.0, 1.0], [3.0, 1.0]) == pytest.approx(2.0 * pi - 6.0)
    assert goal.distance([3.0, -3.0], [3.0, 3.0]) == pytest.approx(6.0)
    assert goal.residual([-3.0, -3.0], [3.0, 3.0]) == pytest.approx([2.0 * pi - 6.0, -6.0])


# Alignment


def alignment(link: str = "end", **keys: Any) -> SubGoal:
    return sub_goal(type="alignment", link=link, **{"axis": [1.0, 0.0, 0.0], "other": "world", **keys})


def test_alignment_with_the_world() -> None:
    assert alignment(other_axis=[0.0, 0.0, 1.0]).unit == "rad"
    assert error(alignment(other_axis=[0.0, 0.0, 3.0]), Q) == pytest.approx(0.0, abs=1e-15)  # points up
    assert error(alignment(other_axis=[0.0, 0.0, -1.0]), Q) == pytest.approx(pi)
    assert error(alignment(other_axis=[1.0, 1.0, 0.0]), Q) == pytest.approx(pi / 2)
    assert error(alignment(axis=[0.0, 0.0, 0.2], other_axis=[0.0, -1.0, 1.0]), Q) == pytest.approx(pi / 4)


def test_alignment_does_not_mind_a_turn_about_the_axis() -> None:
    goal = alignment(axis=[0.0, 0.0, 1.0], other_axis=[0.0, 0.0, 1.0])
    assert error(goal, [1.3, 0.2, 0.1]) == pytest.approx(0.3)
    assert error(goal, [-2.0, 0.2, 0.1]) == pytest.approx(0.3)


def test_alignment_with_another_link() -> None:
    goal = alignment(other="link2", other_axis=[1.0, 0.0, 0.0])
    assert error(goal, [0.4, 0.9, 0.0]) == pytest.approx(0.0, abs=1e-15)
    assert error(goal, [0.4, 0.9, -0.5]) == pytest.approx(0.5)


@given(AXES, AXES, FRAMES, FRAMES)
def test_alignment_is_the_angle_between_the_axes(axis: Any, other: Any, own: Frame, reference: Frame) -> None:
    goal = alignment(axis=list(axis), other="link1", other_axis=list(other))
    a = matrix_of(own[3:]) @ axis / hypot(*axis)
    b = matrix_of(reference[3:]) @ other / hypot(*other)
    (found,) = goal.value([], frames_with(goal, end=own, link1=reference))
    assert 0.0 <= found <= pi
    assert cos(found) == pytest.approx(float(a @ b), abs=1e-14)
    assert goal.distance([found], [0.0]) == found


def test_a_small_misalignment_is_not_lost_in_rounding() -> None:
    goal = alignment(other_axis=[1.0, 0.0, 0.0])
    for angle in (1e-9, 1e-6):
        frames = frames_with(goal, end=at(0.0, 0.0, 0.0, (0.0, 1.0, 1.0), angle))
        assert goal.value([], frames)[0] == pytest.approx(angle, rel=1e-9)


# What inverse kinematics reads


@given(TURNS, TURNS)
def test_the_residual_of_an_orientation_is_the_turn_from_target_to_value(value: Any, target: Any) -> None:
    goal = orientation([1.0, 0.0, 0.0, 0.0])
    left = goal.residual(value, [2.0 * x for x in target])
    angle = hypot(*left)
    assert angle == pytest.approx(goal.distance(value, target), abs=1e-12)
    turned = multiply(from_axis_angle(left, angle), target) if angle else normalised(target)
    assert goal.distance(turned, value) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("kind", "rows"), [("position", slice(0, 3)), ("orientation", slice(3, 6))])
def test_residuals_at_the_target_change_by_the_jacobian(kind: str, rows: slice) -> None:
    """Residuals are in world axes, as the Jacobian's rows are."""
    robot = spatial_robot({**PANDA, "base_pose": TILTED})
    goal = sub_goal(robot, type=kind, link="panda_hand", target=[1.0, 0.0, 0.0, 0.0][: 3 if kind == "position" else 4])
    for _ in range(5):
        q = RANDOM.uniform(-1.0, 1.0, robot.dof)
        target = goal.value([], robot.frames(q.tolist()))
        step = 1e-6  # [rad]
        around = robot.frames_of(q + step * np.eye(robot.dof))
        moved = [goal.residual(goal.value([], frames), target) for frames in around]
        assert_allclose(np.array(moved).T / step, robot.jacobian(q, "panda_hand")[rows], atol=1e-5)


def test_residuals_of_other_goals_are_differences() -> None:
    assert position(target=[0.0, 0.0, 0.0]).residual([1.0, 2.0, 3.0], [0.5, 2.5, 3.0]) == [0.5, -0.5, 0.0]
    joint = sub_goal(type="joint", joints=["joint2"], target=[0.0])
    assert joint.residual([1.0], [3.5]) == [-2.5]
    assert alignment(other_axis=[1.0, 0.0, 0.0]).residual([0.3], [0.0]) == [0.3]


def test_targets_beyond_an_arms_reach() -> None:
    robot = spatial_robot({**ARM, "base_pose": {"position": [0.0, 0.0, 2.0], "orientation": [1.0, 0.0, 0.0, 0.0]}})
    assert robot.reach == pytest.approx(1.2)

    def beyond(target: list[float], robot: SpatialRobot = robot, **keys: Any) -> bool:
        return position(robot, **{"target": target, "tolerance": 0.05, **keys}).beyond_reach(target)

    assert beyond([0.0, 0.0, 0.7])  # 1.3 below the shoulder
    assert not beyond([0.0, 0.0, 0.8])
    assert not beyond([0.0, 0.0, 0.7], tolerance=0.15)
    assert not beyond([0.0, 0.0, 0.7], point=[0.3, 0.0, 0.0])
    assert beyond([0.0, 0.0, 0.3], point=[0.3, 0.3, 0.0])
    assert not beyond([5.0, 5.0], axes=[0, 1])
    assert not beyond([0.0, 0.0, 9.0], relative_to="base")
    assert not beyond([50.0, 0.0, 0.0], spatial_robot(POINT), link="body")


def test_a_point_at_the_edge_of_the_ball_is_within_reach() -> None:
    straight = [0.3, 0.0, 0.0]
    end = ARM_ROBOT.forward_kinematics(straight, "end")[:3, 3]
    assert sqrt(end @ end) == pytest.approx(ARM_ROBOT.reach)
    assert not position(target=end.tolist(), tolerance=1e-9).beyond_reach(end)
