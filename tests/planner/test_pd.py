"""The PD law against numbers worked out by hand."""

import numpy as np
import pytest

from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.pd import PD

from .problems import CART, POINT, Array, arm, observed, problem_of, reach, ready

PLAIN = problem_of(POINT, [reach("body", 4.0, 0.2)], dt=0.05)


def pd(**parameters: float | str) -> Planner:
    return PD(PD.Parameters(**parameters))  # type: ignore[arg-type] # names are given as text


def test_difference_starts_from_no_error_as_local_planner_bench_does() -> None:
    planner = ready(pd(p=0.2, k=0.8, derivative="difference"), PLAIN)
    first = planner.compute_action(observed(PLAIN, [0.0, 0.0], targets={"reach": [4.0, 0.2]}))
    assert first == pytest.approx([64.8, 3.24], abs=1e-12)  # 0.2 e + 0.8 e / 0.05
    second = planner.compute_action(observed(PLAIN, [0.081, 0.00405], targets={"reach": [4.0, 0.2]}))
    assert second == pytest.approx([0.2 * 3.919 - 0.8 * 0.081 / 0.05, 0.2 * 0.19595 - 0.8 * 0.00405 / 0.05], abs=1e-12)


def test_difference_is_over_the_planner_s_period() -> None:
    problem = problem_of(POINT, [reach("body", 1.0, 0.0)], dt=0.05, period=0.2)
    planner = ready(pd(p=0.0, k=1.0, derivative="difference"), problem)
    assert planner.compute_action(observed(problem, [0.0, 0.0], targets={"reach": [1.0, 0.0]})) == pytest.approx(
        [5.0, 0.0]
    )


def test_velocity_damps_what_the_robot_does_now() -> None:
    planner = ready(pd(p=1.5, k=2.0), PLAIN)
    action = planner.compute_action(observed(PLAIN, [1.0, 1.0], [0.3, -0.4], targets={"reach": [4.0, 0.2]}))
    assert action == pytest.approx([1.5 * 3.0 - 0.6, 1.5 * -0.8 + 0.8], abs=1e-12)


def test_velocity_looks_the_same_at_the_first_call_and_later() -> None:
    planner = ready(pd(), PLAIN)
    observation = observed(PLAIN, [1.0, 1.0], [0.3, -0.4], targets={"reach": [4.0, 0.2]})
    assert np.array_equal(planner.compute_action(observation), planner.compute_action(observation))


def test_a_joint_goal_gives_the_law_in_joint_space() -> None:
    goal = {"name": "bend", "type": "joint", "joints": ["joint1", "joint2"], "target": [0.5, -0.2], "tolerance": 0.1}
    problem = problem_of(arm(0.6, 0.5), [goal])
    planner = ready(pd(p=2.0, k=0.5, damping=0.0), problem)
    action = planner.compute_action(observed(problem, [0.1, 0.3], [1.0, -1.0], targets={"bend": [0.5, -0.2]}))
    assert action == pytest.approx([2.0 * 0.4 - 0.5, 2.0 * -0.5 + 0.5], abs=1e-12)


def test_a_task_goal_moves_the_arm_straight_there() -> None:
    problem = problem_of(arm(0.6, 0.5), [reach("end", 0.5, 0.5)])
    q = np.array([0.4, 0.9])
    planner = ready(pd(p=1.0, k=0.0, damping=1e-6), problem)
    action = planner.compute_action(observed(problem, q, targets={"reach": [0.5, 0.5]}))
    error = np.array([0.5, 0.5]) - problem.robot.forward_kinematics(q, "end")[:2, 2]
    assert problem.robot.jacobian(q, "end")[:2] @ action == pytest.approx(error, abs=1e-9)


def test_damping_bounds_the_action_of_a_stretched_arm() -> None:
    problem = problem_of(arm(0.6, 0.5), [reach("end", 0.0, 0.0)])
    planner = ready(pd(p=1.0, k=0.0, damping=0.1), problem)
    action = planner.compute_action(observed(problem, [0.0, 1e-9], targets={"reach": [0.0, 0.0]}))
    assert np.linalg.norm(action) <= 1.1 / (2.0 * 0.1)  # |J^T (J J^T + d^2)^-1| <= 1/(2 d)


@pytest.mark.parametrize(
    ("target", "forward", "turn"), [([2, 0], 1, 0), ([-2, 0], -1, 0), ([0, 2], 0, 1), ([0, -2], 0, -1)]
)
def test_a_cart_drives_and_turns_towards_its_goal(target: list[float], forward: int, turn: int) -> None:
    problem = problem_of(CART, [reach("base", *target)])
    action = ready(pd(), problem).compute_action(observed(problem, [0, 0, 0], targets={"reach": target}))
    signs = np.sign(np.round(action, 12))
    assert signs.tolist() == [forward, turn]


@pytest.mark.parametrize("derivative", ["difference", "velocity"])
def test_setup_forgets_the_last_trial(derivative: str) -> None:
    problem = problem_of(arm(0.6, 0.5, 0.4), [reach("end", 0.5, 0.5)])
    planner = pd(derivative=derivative)
    states = np.random.default_rng(0).uniform(-1.0, 1.0, (5, 3))

    def run() -> list[Array]:
        planner.setup(problem)
        return [planner.compute_action(observed(problem, q, targets={"reach": [0.5, 0.5]})) for q in states]

    first = run()
    assert np.array_equal(first, run())
