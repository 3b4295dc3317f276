"""What a planner sees."""

from collections.abc import Callable
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.timeline import BLOCK, Timeline
from pytest_lpb.motion import ExpressionMotion, FixedMotion
from pytest_lpb.problem.preview import Preview
from tests.problem.entries import ARM, CART, POINT, Entry, circle, make_problem, position_goal
from tests.problem.spatial import robots
from tests.problem.spatial.problems import spatial_problem, sphere

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


# In space

FLYER = {**robots.POINT, "control": "velocity"}
WINDMILL: Entry = {
    "name": "mill",
    "shape": "box",
    "size": [2.0, 0.1, 0.1],
    "position": [0.0, 0.0, 3.0],
    "orientation": {"axis": [0.0, 0.0, 1.0], "angle": "pi*t"},
}
TUMBLING: Entry = {
    "name": "can",
    "shape": "cylinder",
    "radius": 0.1,
    "length": 0.4,
    "trajectory": ["20 + t", "cos(t)", "3"],
    "orientation": [0.0, 2.0, 0.0, 0.0],
}


def in_space(robot: Entry = FLYER, preview: Preview | None = None, **changes: Any) -> ScenarioEnvironment:
    problem = spatial_problem(robot, **{"duration": 60.0, "dt": DT, **changes})
    return ScenarioEnvironment(problem=problem, preview=preview, reuse_observations=True)


def test_the_shapes_in_space() -> None:
    turn = {"name": "turn", "type": "orientation", "link": "end", "target": [0.0, 0.0, 0.0, 2.0], "tolerance": 0.1}
    reach = {"name": "reach", "type": "position", "link": "end", "target": [0.9, 0.0, 0.5], "tolerance": 0.1}
    world = in_space(robots.ARM, goal=[turn, reach], obstacles=[sphere(5.0, 5.0, 5.0), WINDMILL, TUMBLING])
    seen = world.observe()
    for name in ("position", "velocity", "acceleration"):
        assert seen[f"obstacle_{name}"].shape == (3, 3)
    assert seen["obstacle_orientation"].shape == (3, 4)
    assert not seen["obstacle_orientation"].flags.writeable
    assert_array_equal(seen["goal_turn"], [0.0, 0.0, 0.0, 1.0])
    assert_array_equal(seen["goal_position"], seen["goal_turn"])
    assert seen["goal_velocity"].shape == (4,)
    assert_array_equal(seen["goal_reach"], [0.9, 0.0, 0.5])
    world.close()


@pytest.mark.parametrize("row", [0, 1, 7, BLOCK + 3])
def test_orientations_in_space_are_exact(row: int) -> None:
    world = in_space(obstacles=[sphere(5.0, 5.0, 5.0), WINDMILL, TUMBLING])
    for _ in range(row):
        world.step([0.0, 0.0, 0.0])
    t, seen = row * DT, world.observe()
    half = 0.5 * pi * t
    upright, turned = [1.0, 0.0, 0.0, 0.0], [cos(half), 0.0, 0.0, sin(half)]
    assert_allclose(seen["obstacle_orientation"], [upright, turned, [0.0, 1.0, 0.0, 0.0]], atol=1e-14)
    assert_allclose(seen["obstacle_position"], [[5.0, 5.0, 5.0], [0.0, 0.0, 3.0], [20.0 + t, cos(t), 3.0]], rtol=1e-14)
    assert_allclose(seen["obstacle_velocity"][2], [1.0, -sin(t), 0.0], atol=1e-14)
    world.close()


def test_the_engine_turns_what_the_observation_turns() -> None:
    """The beam of 2 m points along x at 0 s and along y at 0.5 s, towards a ball of 0.2 m at y = 1.5."""
    world = in_space(obstacles=[WINDMILL], q=[0.0, 1.5, 3.0])
    assert world.monitor.clearance[0] == pytest.approx(1.5 - 0.05 - 0.2, abs=1e-6)
    assert world.monitor.clearance[1:] == ("body", "mill")
    for _ in range(round(0.5 / DT)):
        world.step([0.0, 0.0, 0.0])
    assert world.monitor.clearance[0] == pytest.approx(1.5 - 1.0 - 0.2, abs=1e-6)
    world.close()


def test_what_stands_leaning_is_placed_leaning() -> None:
    leaning = {**WINDMILL, "orientation": [cos(pi / 4), 0.0, sin(pi / 4), 0.0]}  # about y: the beam points down
    world = in_space(obstacles=[leaning], q=[0.0, 0.0, 1.5])
    assert world.monitor.clearance[0] == pytest.approx(1.5 - 1.0 - 0.2, abs=1e-6)
    world.close()


def test_absent_obstacles_have_rows_of_zeros(write: Callable[[Entry], Path]) -> None:
    drawn = {
        "count": [0, 3],
        "shape": "box",
        "size": [[0.1, 0.2]] * 3,
        "position": [[-9.0, 9.0], [-9.0, 9.0], [2.0, 9.0]],
    }
    world = ScenarioEnvironment(
        write(
            {
                "robot": {"model": "point_3d"},
                "environment": {"engine": "pybullet", "dt": 0.1, "duration": 1.0},
                "goal": [{"type": "position", "link": "body", "target": [1.0, 0.0, 0.0], "tolerance": 0.1}],
                "obstacles": [{"shape": "sphere", "radius": 0.1, "position": [4.0, 0.0, 0.0]}],
                "randomize": {"draw": ["obstacles"], "obstacles": drawn},
            }
        )
    )
    counts = set()
    for seed in range(8):
        seen, _ = world.reset(seed=seed)
        count = len(world.problem.obstacles)
        counts.add(count)
        assert world.observation_space.contains(seen)
        assert seen["obstacle_orientation"].shape == (4, 4)
        assert_allclose(np.linalg.norm(seen["obstacle_orientation"][:count], axis=1), 1.0)
        assert not seen["obstacle_orientation"][count:].any()
        assert not seen["obstacle_position"][count:].any()
        assert_array_equal(seen["obstacle_present"], [1.0] * count + [0.0] * (4 - count))
    assert len(counts) > 1
    world.close()


def test_previews_in_space() -> None:
    preview = Preview(steps=4, step_s=0.1)
    goal = {"name": "far", "type": "position", "link": "body", "trajectory": ["9", "t", "-2*t"], "tolerance": 0.1}
    world = in_space(preview=preview, goal=[goal], obstacles=[TUMBLING, WINDMILL])
    world.step([0.0, 0.0, 0.0])
    seen, ahead = world.observe(), 0.1 * np.arange(1, 5)
    assert seen["obstacle_position_preview"].shape == (2, 4, 3)
    constant = np.column_stack([20.0 + DT + ahead, cos(DT) - sin(DT) * ahead, np.full(4, 3.0)])
    assert_allclose(seen["obstacle_position_preview"][0], constant)
    assert_array_equal(seen["obstacle_position_preview"][1], [[0.0, 0.0, 3.0]] * 4)
    assert_allclose(seen["goal_far_preview"], np.column_stack([np.full(4, 9.0), DT + ahead, -2.0 * (DT + ahead)]))
    world.close()


def test_the_state_of_bases_in_space() -> None:
    world = in_space({**robots.CART, "control": "velocity"})
    world.step([1.0, 0.5])
    seen = world.observe()
    assert_allclose(seen["u"], [1.0, 0.5])
    assert_allclose(seen["qd"], [cos(0.025), sin(0.025), 0.5])
    world.close()
    flying = in_space()
    flying.step([1.0, 2.0, 3.0])
    assert_array_equal(flying.observe()["u"], [1.0, 2.0, 3.0])
    assert_array_equal(flying.observe()["qd"], flying.observe()["u"])
    flying.close()
