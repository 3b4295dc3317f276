"""The motion over a step against the environment's own, its Jacobians against finite differences."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pytest_lpb.planner.mpc.model import Model, lead_of
from pytest_lpb.problem.robot import Robot, robot_from
from tests.planner import problems
from tests.planner.scene.making import Array, Entry, planar, random_states, spatial
from tests.problem.spatial.robots import ENTRIES

STEP = 0.1  # [s]
STEPS = 3
SMALL = 1e-6

ROBOTS: dict[str, Entry] = {
    "point in the plane": planar(problems.POINT),
    "arm in the plane": planar(problems.arm(0.6, 0.5, 0.4)),
    "cart in the plane": planar(problems.CART),
    **{name: spatial(entry) for name, entry in ENTRIES.items()},
}
# How far Runge and Kutta's method may be off over the steps.
WITHIN = {"fixed": 1e-12, "holonomic": 1e-12, "differential_drive": 1e-5, "bicycle": 1e-4}


@cache
def robot_of(name: str) -> Robot:
    return robot_from(ROBOTS[name])


@cache
def model_of(name: str) -> Model:
    return Model(robot_of(name), STEP)


def states_of(name: str, seed: int = 1) -> list[tuple[Array, Array]]:
    """States (q, u) and inputs (n, steps) that take the steering angle nowhere near a right angle."""
    robot = robot_of(name)
    rates = np.random.default_rng(seed + 100).uniform(-1.0, 1.0, (3, robot.n_actions, STEPS))
    states = []
    for (q, u), rate in zip(random_states(robot, seed, len(rates)), rates, strict=True):
        if robot.base == "bicycle":
            q[3] = np.clip(q[3], -0.4, 0.4)
        states.append((np.concatenate([q, u]), rate))
    return states


@pytest.mark.parametrize("name", ROBOTS)
def test_states_after_steps_are_those_of_the_environment(name: str) -> None:
    robot, rollout = robot_of(name), model_of(name).rollout(STEPS)
    for state, rates in states_of(name):
        path = np.array(rollout(state, rates)).T
        q, u = state[: robot.dof].tolist(), state[robot.dof :].tolist()
        for rate, found in zip(rates.T, path, strict=True):
            q, u = robot.integrate(q, u, rate.tolist(), STEP)
            np.testing.assert_allclose(found, [*q, *u], rtol=0.0, atol=WITHIN[robot.base])


@pytest.mark.parametrize("name", ROBOTS)
def test_jacobians_are_those_of_finite_differences(name: str) -> None:
    model = model_of(name)
    for state, rates in states_of(name):
        by_state, by_input = (np.array(part) for part in model._slopes(state, rates[:, 0]))
        both = np.concatenate([state, rates[:, 0]])

        def after(numbers: Array, model: Model = model) -> Array:
            moved: Array = np.array(model.move(numbers[: model.states], numbers[model.states :]))[:, 0]
            return moved

        differences = [after(both + SMALL * unit) - after(both - SMALL * unit) for unit in np.eye(len(both))]
        expected = np.array(differences).T / (2.0 * SMALL)
        np.testing.assert_allclose(np.hstack([by_state, by_input]), expected, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("name", ROBOTS)
def test_jacobians_of_all_steps_lie_side_by_side(name: str) -> None:
    model = model_of(name)
    states = np.array([state for state, _ in states_of(name)]).T
    rates = np.array([rate[:, 0] for _, rate in states_of(name)]).T
    found = [np.array(part) for part in model.slopes(states.shape[1])(states, rates)]
    apart = [model._slopes(state, rate) for state, rate in zip(states.T, rates.T, strict=True)]
    for part, beside in enumerate(found):
        np.testing.assert_array_equal(beside, np.hstack([np.array(pair[part]) for pair in apart]))


def test_a_point_is_linear_as_computed_by_hand() -> None:
    model = model_of("point in the plane")
    assert model.linear
    assert model.by_state == pytest.approx(np.block([[np.eye(2), 0.1 * np.eye(2)], [np.zeros((2, 2)), np.eye(2)]]))
    assert model.by_input == pytest.approx(np.vstack([0.005 * np.eye(2), 0.1 * np.eye(2)]))


def test_only_robots_that_cannot_move_sideways_are_not_linear() -> None:
    for name in ROBOTS:
        assert model_of(name).linear == (robot_of(name).base in ("fixed", "holonomic"))


@pytest.mark.parametrize("periods", [1, 2, 5])
def test_under_velocity_control_a_step_is_that_of_the_environment(periods: int) -> None:
    robot = robot_from({**ROBOTS["point in the plane"], "control": "velocity"})
    period = STEP / periods
    model = Model(robot, STEP, lead_of(robot, 0.01, period))
    q, u, rates = [0.3, -0.2], np.array([0.5, 0.1]), np.array([2.0, -1.0])
    found = np.array(model.move([*q, *u], rates))[:, 0]
    for _ in range(periods):
        u = u + period * rates
        q, _ = robot.integrate(q, u.tolist(), u.tolist(), period)
    assert found == pytest.approx([*q, *u], abs=1e-12)


def test_entries_of_q_that_an_input_moves_directly() -> None:
    assert model_of("point in the plane").follows == [(0, 0), (1, 1)]
    assert model_of("cart in the plane").follows == [(2, 1)]
