"""What limits leave of an action, and how it is counted."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.limits import ActionLimits
from pytest_lpb.environment.spaces import action_space
from tests.problem.entries import ARM, CART, POINT, Entry, make_problem, make_robot
from tests.problem.spatial import robots
from tests.problem.spatial.problems import spatial_problem

DT = 0.05


def limits(control: str = "acceleration", **given: Any) -> ActionLimits:
    return ActionLimits(make_robot(POINT, control=control, limits=given), DT)


def environment(robot: Entry = POINT, **changes: Any) -> ScenarioEnvironment:
    return ScenarioEnvironment(problem=make_problem(robot, duration=10.0, **changes))


def test_without_limits_actions_pass() -> None:
    action = [1e9, -1e9]
    assert limits().apply(action, [0.0, 0.0]) is action


def test_accelerations_are_clipped() -> None:
    applied = limits(acceleration=[[-1.0, 2.0], None]).apply([5.0, -7.0], [0.0, 0.0])
    assert applied == [2.0, -7.0]
    assert limits(acceleration=[[-1.0, 2.0], None]).apply([-5.0, 7.0], [0.0, 0.0]) == [-1.0, 7.0]


def test_accelerations_are_reduced_to_keep_the_velocity() -> None:
    rule = limits(velocity=[[-1.0, 2.0], [-1.0, 1.0]])
    assert rule.apply([30.0, -30.0], [1.5, -0.5]) == [pytest.approx(0.5 / DT), pytest.approx(-0.5 / DT)]
    assert rule.apply([9.0, -9.0], [1.5, -0.5]) == [9.0, -9.0]  # both stay within for this step
    assert rule.apply([1.0, 0.0], [2.0, 0.0]) == [0.0, 0.0]


def test_braking_from_beyond_a_velocity_limit_keeps_the_acceleration_limit() -> None:
    rule = limits(velocity=[[-1.0, 1.0]] * 2, acceleration=[[-4.0, 4.0]] * 2)
    assert rule.apply([0.0, 0.0], [3.0, -3.0]) == [-4.0, 4.0]


def test_velocities_are_clipped() -> None:
    assert limits("velocity", velocity=[[-1.0, 2.0], None]).apply([5.0, 5.0], [0.0, 0.0]) == [2.0, 5.0]


def test_velocities_change_within_acceleration_limits() -> None:
    rule = limits("velocity", velocity=[[-1.0, 1.0]] * 2, acceleration=[[-2.0, 4.0]] * 2)
    assert rule.apply([9.0, -9.0], [0.0, 0.0]) == [pytest.approx(4.0 * DT), pytest.approx(-2.0 * DT)]
    assert rule.apply([9.0, 0.9], [0.9, 0.9]) == [1.0, 0.9]


def test_torques_are_clipped_to_the_efforts_alone() -> None:
    given = {
        "velocity": [[-0.1, 0.1]] * 3,
        "acceleration": [[-0.1, 0.1]] * 3,
        "effort": [[-5.0, 5.0], [-1.0, 2.0], None],
    }
    robot = robots.spatial_robot(robots.ARM, control="torque", limits=given)
    rule = ActionLimits(robot, DT)
    assert rule.apply([9.0, -9.0, -99.0], [0.0, 0.0, 0.0]) == [5.0, -1.0, -99.0]
    assert rule.apply([4.0, 1.0, 99.0], [3.0, -3.0, 3.0]) == [4.0, 1.0, 99.0]  # however fast it is
    unlimited = robots.spatial_robot(robots.ARM, control="torque", limits={**given, "effort": None})
    action = [1e9, -1e9, 0.0]
    assert ActionLimits(unlimited, DT).apply(action, [0.0, 0.0, 0.0]) is action


def test_torques_beyond_the_efforts_are_counted() -> None:
    limits = {"effort": [[-5.0, 5.0], [-1.0, 2.0], [-1.0, 1.0]], "velocity": [[-9.0, 9.0]] * 3}
    problem = spatial_problem({**robots.ARM, "control": "torque", "limits": limits}, dynamics=True, dt=0.01)
    space = action_space(problem, np.ones(3))
    assert (space.low.tolist(), space.high.tolist()) == ([-5.0, -1.0, -1.0], [5.0, 2.0, 1.0])
    world = ScenarioEnvironment(problem=problem)
    for action, applied, count in (
        ([5.0, 2.0, 1.0], [5.0, 2.0, 1.0], 0),
        ([5.1, -3.0, 0.0], [5.0, -1.0, 0.0], 1),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 1),
    ):
        world.step(action)
        assert (world.applied, world.saturated_steps) == (applied, count)
    world.close()


bounds = st.floats(0.01, 10.0)


@given(
    st.lists(st.tuples(st.floats(-100, 100), st.floats(-100, 100)), min_size=1, max_size=20),
    st.sampled_from(["acceleration", "velocity"]),
    bounds,
    bounds,
)
def test_limits_hold_whatever_is_asked(
    actions: list[tuple[float, float]], control: str, speed: float, acceleration: float
) -> None:
    robot = {**POINT, "control": control, "limits": {"velocity": [[-speed, speed]] * 2}}
    robot["limits"]["acceleration"] = [[-acceleration, acceleration]] * 2
    world = environment(robot)
    before = np.zeros(2)
    for action in actions:
        world.step(list(action))
        after = np.array(world.running_engine.u)
        assert (np.abs(after) <= speed * (1 + 1e-9)).all()
        assert (np.abs(after - before) <= acceleration * DT * (1 + 1e-9) + 1e-12).all()
        before = after


@given(st.floats(0.01, 10.0), st.floats(-0.999, 0.999), st.sampled_from([0.01, 0.05, 0.1, 1 / 30]))
def test_coasting_at_the_limit_is_not_limited(speed: float, share: float, dt: float) -> None:
    """Rounding takes the velocity a little beyond its limit: that is no fault of a planner that asks for nothing."""
    rule = ActionLimits(make_robot(POINT, limits={"velocity": [[-speed, speed]] * 2}), dt)
    v = share * speed
    reached = v + rule.apply([1e6, 0.0], [v, 0.0])[0] * dt
    assert reached == pytest.approx(speed)
    assert rule.apply([0.0, 0.0], [reached, -reached]) == [0.0, 0.0]


def test_saturated_steps_are_counted() -> None:
    world = environment({**POINT, "limits": {"velocity": [[-1.0, 1.0]] * 2, "acceleration": [[-8.0, 8.0]] * 2}})
    expected = [False, True, True, False, True, False, False]
    actions = [[8.0, 0.0], [9.0, 0.0], [8.0, 0.0], [0.0, 0.0], [8.0, 0.0], [-8.0, 8.0], [0.0, -8.0]]
    # u0 after: 0.4, 0.8, 1.0 (reduced to 4), 1.0, 1.0 (reduced to 0), 0.6, 0.6
    counts = []
    for action in actions:
        world.step(action)
        counts.append(world.saturated_steps)
    assert np.diff([0, *counts]).astype(bool).tolist() == expected
    assert world.running_engine.u == [pytest.approx(0.6), pytest.approx(0.0)]
    world.reset()
    assert world.saturated_steps == 0


def test_the_cart_is_limited_in_its_own_velocities() -> None:
    world = environment({**CART, "control": "velocity", "limits": {"velocity": [[-0.1, 0.5], [-1.0, 1.0]]}})
    world.step([-5.0, 5.0])
    assert world.applied == [-0.1, 1.0]
    assert world.running_engine.u == [-0.1, 1.0]


def test_position_limits_never_clamp() -> None:
    world = environment(
        {**ARM, "limits": {"position": [[-1.0, 1.0], None, None]}, "control": "velocity"}, q=[0.9, 0, 0]
    )
    world.step([2.0, 0.0, 0.0])
    assert not world.ended
    assert world.running_engine.q[0] == pytest.approx(1.0)
    world.step([2.0, 0.0, 0.0])
    assert world.running_engine.q[0] == pytest.approx(1.1)
    assert world.outcome == "joint_limit"
    assert world.monitor.violation is not None
    assert (world.monitor.violation.joint, world.monitor.violation.row) == (0, 2)


@pytest.mark.parametrize(("beyond", "outcome"), [(0.5e-9, None), (2e-9, "joint_limit")])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_position_limits_have_a_slack_for_rounding(beyond: float, outcome: str | None, side: float) -> None:
    robot = {**POINT, "limits": {"position": [None, [-1.0, 1.0]]}, "control": "velocity"}
    world = environment(robot, q=[0.0, side * 0.5])
    world.step([0.0, side * (0.5 + beyond) / DT])
    assert world.outcome == outcome
