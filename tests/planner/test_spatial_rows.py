"""Tasks in space: errors and Jacobians against finite differences, and what bases make of them."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pytest_lpb.planner.actuation import actuation_of
from pytest_lpb.planner.base import GoalInfo
from pytest_lpb.planner.spatial_rows import SPATIAL_ROWS, angular_velocity
from pytest_lpb.problem.goal import goal_from
from pytest_lpb.problem.spatial.rotations import from_axis_angle, multiply
from tests.problem.spatial.robots import CAR, PANDA, spatial_robot

Array = NDArray[np.float64]

GOALS: dict[str, dict[str, Any]] = {
    "position": {"type": "position", "link": "panda_hand", "target": [0.4, 0.1, 0.5]},
    "point of a link": {"type": "position", "link": "panda_hand", "point": [0.1, -0.2, 0.3], "target": [0.4, 0.1, 0.5]},
    "two axes": {"type": "position", "link": "panda_hand", "axes": [0, 2], "target": [0.4, 0.5]},
    "relative": {"type": "position", "link": "panda_hand", "relative_to": "panda_link4", "target": [0.1, 0.0, 0.3]},
    "orientation": {"type": "orientation", "link": "panda_hand", "target": [0.0, 0.924, 0.383, 0.0]},
    "joint": {"type": "joint", "joints": ["panda_joint2", "panda_joint4"], "target": [0.1, -1.0]},
    "alignment": {
        "type": "alignment",
        "link": "panda_hand",
        "axis": [0, 0, 1],
        "other": "world",
        "other_axis": [0, 1, -1],
    },
    "two links": {
        "type": "alignment",
        "link": "panda_hand",
        "axis": [0, 1, 0],
        "other": "panda_link3",
        "other_axis": [1, 0, 0],
    },
}
LIMITS = [[-2.9, 2.9], [-1.8, 1.8], [-2.9, 2.9], [-3.0, -0.1], [-2.9, 2.9], [0.0, 3.7], [-2.9, 2.9]]  # [rad]
ROBOT = spatial_robot(PANDA, limits={"position": LIMITS})
CONFIGURATIONS = st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7)


def told(entry: dict[str, Any]) -> GoalInfo:
    """A sub-goal as planners see it."""
    size = len(entry.get("target", [0.0]))
    return GoalInfo("g", entry["type"], entry.get("link"), size, 0.1, 1.0, True, False, entry)


def configuration(shares: list[float]) -> Array:
    limits = ROBOT.limits.position
    middle, half = limits.mean(axis=1), 0.45 * (limits[:, 1] - limits[:, 0])
    return np.asarray(middle + np.array(shares) * half)


@pytest.mark.parametrize(
    "name", [name for name in GOALS if "orient" not in name and "align" not in name and name != "two links"]
)
@given(CONFIGURATIONS)
@settings(max_examples=25, deadline=None)
def test_jacobians_are_the_slopes_of_the_errors(name: str, shares: list[float]) -> None:
    entry, q = GOALS[name], configuration(shares)
    target, goal, row = np.array(entry["target"], dtype=float), told(entry), SPATIAL_ROWS[entry["type"]]
    _, jacobian = row(target, ROBOT, goal, q)
    for joint in range(7):
        step = np.zeros(7)
        step[joint] = 1e-6
        slope = (row(target, ROBOT, goal, q + step)[0] - row(target, ROBOT, goal, q - step)[0]) / 2e-6
        assert -slope == pytest.approx(jacobian[:, joint], abs=1e-6)


@pytest.mark.parametrize("name", ["orientation", "alignment", "two links"])
@given(CONFIGURATIONS)
@settings(max_examples=25, deadline=None)
def test_a_step_along_the_error_turns_the_link_nearer(name: str, shares: list[float]) -> None:
    entry, q = GOALS[name], configuration(shares)
    sub_goal = goal_from([{"name": "g", "tolerance": 0.1, "weight": 1.0, "primary": True, **entry}], ROBOT)[0]
    target = np.array(entry.get("target", [0.0]), dtype=float)

    def distance(at: Array) -> float:
        return sub_goal.distance(sub_goal.value(at.tolist(), ROBOT.frames(at.tolist())), target.tolist())

    error, jacobian = SPATIAL_ROWS[entry["type"]](target, ROBOT, told(entry), q)
    before = distance(q)
    assert np.linalg.norm(error) == pytest.approx(before, abs=1e-7)
    if before < 0.05 or before > pi - 0.05 or np.linalg.svd(jacobian, compute_uv=False)[1] < 0.05:
        return
    # A small share of the error, by the pseudo-inverse: the distance shrinks by that share.
    share = 1e-4
    after = distance(q + share * np.linalg.lstsq(jacobian, error, rcond=1e-6)[0])
    assert after < before
    if name == "orientation" and np.linalg.svd(jacobian, compute_uv=False)[2] > 0.05:
        assert before - after == pytest.approx(share * before, rel=0.02)


def test_errors_at_opposed_axes_are_half_a_turn_about_some_axis_across() -> None:
    q = configuration([0.0] * 7)
    axis = ROBOT.forward_kinematics(q, "panda_hand")[:3, :3] @ [0.0, 0.0, 1.0]
    goal = told({"type": "alignment", "link": "panda_hand", "axis": [0, 0, 1], "other": "world", "other_axis": -axis})
    error, _ = SPATIAL_ROWS["alignment"](np.zeros(1), ROBOT, goal, q)
    assert np.linalg.norm(error) == pytest.approx(pi)
    assert error @ axis == pytest.approx(0.0, abs=1e-9)


def test_angular_velocity_of_a_turning_target() -> None:
    rate = 0.7
    q = np.array(from_axis_angle((0.0, 0.0, 1.0), 0.3))
    slope = rate * 0.5 * np.array(multiply((0.0, 0.0, 0.0, 1.0), q.tolist()))
    assert angular_velocity(q, slope) == pytest.approx([0.0, 0.0, rate])


def observed(q: list[float], u: list[float]) -> dict[str, Array]:
    return {"q": np.array(q), "u": np.array(u)}


def test_a_car_is_given_the_steering_that_turns_it_as_asked() -> None:
    car = spatial_robot(CAR, control="velocity")
    actuation = actuation_of(car, "velocity", 0.05, 0.3)
    v, rate = actuation.command(np.array([1.0, 0.4]), observed([0, 0, 0, np.arctan(0.4 * 0.5 / 1.0)], [1.0, 0.0]))
    assert v == 1.0
    assert rate == pytest.approx(0.0, abs=1e-12)
    v, rate = actuation.command(np.array([0.0, 1.0]), observed([0, 0, 0, 0], [0.0, 0.0]))
    assert v > 0.1  # it turns only while it moves
    assert rate > 0.0
    assert actuation.inputs(observed([0, 0, 0, 0.2], [2.0, 0.0])) == pytest.approx([2.0, 2.0 * np.tan(0.2) / 0.5])


def test_inputs_of_a_car_have_no_part_in_its_steering_angle() -> None:
    car = spatial_robot(CAR)
    columns = actuation_of(car, "acceleration", 0.05, 0.3).input_map(np.array([0.0, 0.0, 0.5, 0.1]))
    assert columns is not None
    assert columns == pytest.approx(np.array([[np.cos(0.5), 0], [np.sin(0.5), 0], [0, 1], [0, 0]]))
