import math

import numpy as np
import pytest

from pytest_lpb.kpis.goal import (
    success_weighted_path_length,
    time_to_goal,
    tracking_error_mean,
)
from pytest_lpb.kpis.path import path_length_ratio, path_length_to_goal

from .trials import ARM, CART, REACH, make_problem, make_trial

LINE = np.column_stack([np.arange(21) * 0.1, np.zeros(21)])


def test_touching_the_goal_is_not_holding_it() -> None:
    through = np.column_stack([np.arange(41) * 0.1, np.zeros(41)])
    assert math.isnan(time_to_goal(make_trial(make_problem(hold_time=0.5), through)))
    assert time_to_goal(make_trial(make_problem(hold_time=0.2), through)) == pytest.approx(1.9)


def test_no_path_to_a_goal_that_is_not_reached() -> None:
    trial = make_trial(make_problem(hold_time=3.0), LINE)
    assert math.isnan(path_length_to_goal(trial))
    assert math.isnan(path_length_ratio(trial))


@pytest.mark.parametrize("change", [{"moving": False}, {"tolerance": None}, {"tolerance": 0.01}])
def test_tracking_needs_a_moving_goal_that_was_entered(change: dict[str, object]) -> None:
    moving = change.pop("moving", True)
    goal = {**REACH, **change} | ({"target": None, "trajectory": ["2 + 0*t + sin(t)", "3"]} if moving else {})
    assert math.isnan(tracking_error_mean(make_trial(make_problem(goal=[goal]), LINE)))


def test_spl_counts_a_failure_as_zero() -> None:
    problem = make_problem()
    problem.certified_path_length_m = 1.5
    assert success_weighted_path_length(make_trial(problem, LINE, outcome="collision")) == 0.0
    assert success_weighted_path_length(make_trial(problem, LINE)) == pytest.approx(1.5 / 1.9)
    problem.certified_path_length_m = 4.0  # the certified path need not be the shortest
    assert success_weighted_path_length(make_trial(problem, LINE)) == 1.0


def test_spl_of_a_start_at_the_goal() -> None:
    problem = make_problem(goal=[{**REACH, "target": [0.0, 0.0]}])
    problem.certified_path_length_m = 0.0
    assert success_weighted_path_length(make_trial(problem, LINE)) == 1.0


@pytest.mark.parametrize(
    "change",
    [
        {"axes": [0], "target": [2.0]},
        {"point": [0.3, 0.0], "target": [2.3, 0.0]},
        {"target": [0.0, 0.1], "tolerance": 3.0},
    ],
    ids=["one axis", "a point beside the frame", "at the goal from the start"],
)
def test_ratio_needs_a_straight_distance(change: dict[str, object]) -> None:
    trial = make_trial(make_problem(goal=[{**REACH, **change}]), LINE)
    assert trial.goal_row is not None
    assert math.isnan(path_length_ratio(trial))


def test_ratio_does_not_apply_to_a_goal_relative_to_another_link() -> None:
    goal = {**REACH, "link": "end", "relative_to": "link2", "target": [1.0, 0.0]}
    trial = make_trial(make_problem(ARM, goal=[goal]), LINE)
    assert trial.goal_row == 0
    assert math.isnan(path_length_ratio(trial))


def test_ratio_of_a_moving_goal_ends_where_it_is_reached() -> None:
    goal = {**REACH, "target": None, "trajectory": ["3 - 0.5*t", "0"]}
    trial = make_trial(make_problem(goal=[goal], hold_time=0.0), LINE)
    assert trial.goal_row == 19  # point at 1.9, goal at 2.05
    assert path_length_ratio(trial) == 1.0


def test_ratio_of_a_detour_is_over_the_line_between_its_ends() -> None:
    corner = np.vstack([LINE[:21], np.column_stack([np.full(21, 2.0), np.arange(21) * 0.1])])
    trial = make_trial(make_problem(goal=[{**REACH, "target": [2.0, 2.0]}]), corner)
    end = np.array([2.0, 1.9])  # within 0.15 m of the target
    assert path_length_ratio(trial) == pytest.approx(3.9 / np.linalg.norm(end))


def test_ratio_does_not_apply_to_a_goal_that_comes_to_the_robot() -> None:
    goal = {**REACH, "target": None, "trajectory": ["3 - t", "0"]}
    trial = make_trial(make_problem(goal=[goal], hold_time=0.0, dt=0.2), np.zeros((21, 2)))
    assert trial.goal_row == 15
    assert math.isnan(path_length_ratio(trial))


def test_joints_of_a_base_are_told_apart() -> None:
    from pytest_lpb.kpis.path import joint_path_length_m, joint_path_length_rad

    q = np.column_stack([np.linspace(0.0, 3.0, 11), np.linspace(0.0, 4.0, 11), np.linspace(0.0, 0.7, 11)])
    trial = make_trial(make_problem(CART, goal=[{**REACH, "link": "base"}]), q)
    assert joint_path_length_m(trial) == pytest.approx(5.0)
    assert joint_path_length_rad(trial) == pytest.approx(0.7)


def test_spl_of_a_trial_that_misses_its_criteria_is_zero() -> None:
    problem = make_problem()
    problem.certified_path_length_m = 1.5
    assert success_weighted_path_length(make_trial(problem, LINE, success=False)) == 0.0
    assert success_weighted_path_length(make_trial(problem, LINE, success=True)) == pytest.approx(1.5 / 1.9)
