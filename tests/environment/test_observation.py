"""What a planner sees."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.timeline import BLOCK, Timeline
from pytest_lpb.motion import ExpressionMotion, FixedMotion
from pytest_lpb.problem.preview import Preview
from tests.problem.entries import ARM, CART, POINT, Entry, circle, make_problem, position_goal

DT = 0.05
MOVER = {**POINT, "control": "velocity"}
SWINGING: Entry = {"name": "swing", "shape": "circle", "radius": 0.1, "trajectory": ["3 + sin(2*t)", "0.5*t**2 + 4"]}
CHASED: Entry = {
    "name": "chased",
    "type": "position",
    "link": "body",
    "trajectory": ["20 + t**2", "cos(t)"],
    "tolerance": 0.1,
}


def environment(robot: Entry = MOVER, preview: Preview | None = None, **changes: Any) -> ScenarioEnvironment:
    problem = make_problem(robot, **{"duration": 60.0, **changes})
    return ScenarioEnvironment(problem=problem, preview=preview, reuse_observations=True)


def test_views_cannot_be_written() -> None:
    world = environment(CART, Preview(3, 0.1), obstacles=[circle(9.0, 9.0, 1.0)])
    for name, array in world.observe().items():
        assert not array.flags.writeable, name
        assert array.dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 1.0


def test_views_are_filled_again() -> None:
    world = environment()
    first = world.observe()
    world.step([1.0, 2.0])
    assert world.observe()["q"] is first["q"]
    assert_allclose(first["q"], [0.05, 0.1])
    assert first["t"] == DT
    assert first["t"].shape == ()


def test_the_state_of_each_robot() -> None:
    cart = environment({**CART, "control": "velocity"})
    cart.step([1.0, 0.5])
    seen = cart.observe()
    assert_allclose(seen["u"], [1.0, 0.5])
    assert_allclose(seen["qd"], [np.cos(0.025), np.sin(0.025), 0.5])
    assert seen["q"].shape == (3,)
    arm = environment({**ARM, "control": "acceleration"})
    arm.step([1.0, 2.0, 3.0])
    assert_array_equal(arm.observe()["u"], arm.observe()["qd"])
    assert_allclose(arm.observe()["qd"], [0.05, 0.1, 0.15])


def test_the_shapes_of_goals() -> None:
    joint = {"name": "elbow", "type": "joint", "joints": ["joint3", "joint1"], "target": [0.1, 0.2]}
    turn = {"name": "turn", "type": "orientation", "link": "end", "target": [0.5], "tolerance": 0.1, "primary": True}
    world = environment(ARM, goal=[position_goal([1.0, 1.0], "end"), joint, turn])
    seen = world.observe()
    assert_array_equal(seen["goal_reach"], [1.0, 1.0])
    assert_array_equal(seen["goal_elbow"], [0.1, 0.2])
    assert_array_equal(seen["goal_position"], [0.5])
    assert {f"goal_{name}{suffix}" for name in ("reach", "elbow", "turn") for suffix in ("", "_velocity")} <= set(seen)
    assert not seen["goal_velocity"].any()


@pytest.mark.parametrize("row", [0, 1, 7, BLOCK - 1, BLOCK, BLOCK + 3])
def test_moving_things_are_exact(row: int) -> None:
    world = environment(goal=[CHASED], obstacles=[circle(9.0, 9.0, 0.1, "still"), SWINGING])
    for _ in range(row):
        world.step([0.0, 0.0])
    t, seen = row * DT, world.observe()
    assert seen["t"] == t
    assert_allclose(seen["obstacle_position"], [[9.0, 9.0], [3.0 + np.sin(2 * t), 0.5 * t**2 + 4.0]], rtol=1e-14)
    assert_allclose(seen["obstacle_velocity"], [[0.0, 0.0], [2.0 * np.cos(2 * t), t]], rtol=1e-13, atol=1e-14)
    assert_allclose(seen["obstacle_acceleration"], [[0.0, 0.0], [-4.0 * np.sin(2 * t), 1.0]], rtol=1e-13, atol=1e-13)
    assert_allclose(seen["goal_chased"], [20.0 + t**2, np.cos(t)], rtol=1e-14)
    assert_allclose(seen["goal_position"], seen["goal_chased"])
    assert_allclose(seen["goal_velocity"], [2.0 * t, -np.sin(t)], atol=1e-14)
    assert_allclose(seen["goal_chased_acceleration"], [2.0, -np.cos(t)], atol=1e-14)


def test_orientations() -> None:
    bar: Entry = {"name": "bar", "shape": "rectangle", "size": [1.0, 0.1], "position": [9.0, 9.0]}
    world = environment(obstacles=[{**bar, "orientation": 0.3}, {**bar, "name": "b", "orientation": "2*t"}])
    world.step([0.0, 0.0])
    assert_allclose(world.observe()["obstacle_orientation"], [0.3, 0.1])


@pytest.mark.parametrize("prediction", ["none", "constant_velocity", "exact"])
def test_previews(prediction: str) -> None:
    world = environment(
        preview=Preview(steps=4, step_s=0.1),
        goal=[CHASED],
        obstacles=[SWINGING, circle(9.0, 9.0, 0.1)],
        prediction=prediction,
    )
    for _ in range(10):
        world.step([0.0, 0.0])
    seen, t = world.observe(), 0.5
    ahead = 0.1 * np.arange(1, 5)
    later = t + ahead
    truth = {
        "none": (np.full(4, 3 + np.sin(1.0)), np.full(4, 20 + t**2)),
        "constant_velocity": (3 + np.sin(1.0) + 2 * np.cos(1.0) * ahead, 20 + t**2 + 2 * t * ahead),
        "exact": (3 + np.sin(2 * later), 20 + later**2),
    }[prediction]
    assert seen["obstacle_position_preview"].shape == (2, 4, 2)
    assert_allclose(seen["obstacle_position_preview"][0, :, 0], truth[0])
    assert_allclose(seen["obstacle_position_preview"][1], [[9.0, 9.0]] * 4)
    assert seen["goal_chased_preview"].shape == (4, 2)
    assert_allclose(seen["goal_chased_preview"][:, 0], truth[1])


def test_previews_only_on_request() -> None:
    assert not [key for key in environment(goal=[CHASED]).observe() if "preview" in key]


def test_the_future_of_the_start() -> None:
    """Row 0 has a preview too."""
    seen = environment(preview=Preview(1, 1.0), obstacles=[SWINGING], prediction="exact").observe()
    assert_allclose(seen["obstacle_position_preview"][0, 0], [3.0 + np.sin(2.0), 4.5])


def test_a_timeline_can_be_read_backwards() -> None:
    timeline = Timeline([ExpressionMotion(["t", "1"]), FixedMotion([2.0, 3.0])], 2, 0.1)
    for row in (BLOCK + 5, 3, 2 * BLOCK, 0):
        assert_allclose(timeline.at(row)[0], [[0.1 * row, 1.0], [2.0, 3.0]])
    assert timeline.positions(np.array([0.5, 1.5])).shape == (2, 2, 2)
    nothing = Timeline([], 2, 0.1)
    assert nothing.at(9)[0].shape == (0, 2)
    assert not nothing.moving
