"""When a planner is asked, when its actions act, and what is recorded of each call."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.trajectory import Trajectory

from .specifications import run

DT = 0.05


def clock(**timing: float) -> Trajectory:
    """A planner whose action is the time it was asked at, plus one."""
    return run("Clock", timing=timing)


def test_it_is_asked_at_every_row_by_default() -> None:
    trajectory = clock()
    assert_allclose(trajectory.action[:-1, 0], trajectory.t[:-1] + 1.0)
    assert np.isnan(trajectory.action[-1]).all()
    assert np.isnan(trajectory.applied[-1]).all()
    assert np.isfinite(trajectory.solver_wall_ms[:-1]).all()
    assert np.isnan(trajectory.solver_wall_ms[-1])


def test_between_calls_the_last_action_is_held() -> None:
    trajectory = clock(period=0.15)
    asked = np.arange(20) // 3 * 3 * DT
    assert_allclose(trajectory.action[:-1, 0], asked + 1.0)
    called = np.isfinite(trajectory.solver_wall_ms)
    assert_array_equal(np.flatnonzero(called), [0, 3, 6, 9, 12, 15, 18])
    assert_array_equal(np.isfinite(trajectory.solver_cpu_ms), called)
    assert trajectory.metadata["period_s"] == pytest.approx(0.15)


def test_a_delay_lets_actions_act_later() -> None:
    trajectory = clock(delay=0.1)
    assert_array_equal(trajectory.action[:2], np.zeros((2, 2)))
    assert_allclose(trajectory.action[2:-1, 0], trajectory.t[2:-1] - 0.1 + 1.0)
    assert trajectory.q[2, 0] == 0.0
    assert trajectory.q[3, 0] > 0.0
    assert np.isfinite(trajectory.solver_wall_ms[:-1]).all()  # it is asked at once


def test_period_and_delay_together() -> None:
    trajectory = clock(period=0.1, delay=0.05)
    expected = [0.0, *(1.0 + np.arange(19) // 2 * 2 * DT)]
    assert_allclose(trajectory.action[:-1, 0], expected)


def test_the_clock_of_calls_counts() -> None:
    trajectory = clock(period=0.1)
    assert_array_equal(trajectory.planner("calls")[:5], [1.0, np.nan, 2.0, np.nan, 3.0])
    assert_array_equal(trajectory.planner("odd")[:5], [1.0, np.nan, np.nan, np.nan, 3.0])
    assert (trajectory.solver_wall_ms[[0, 2, 4]] > 0.0).all()
    assert (trajectory.solver_cpu_ms[[0, 2, 4]] >= 0.0).all()
    assert trajectory.metadata["wall_s"] * 1e3 > np.nansum(trajectory.solver_wall_ms)
    assert trajectory.metadata["setup_ms"] > 0.0


@pytest.mark.parametrize("key", ["period", "delay"])
def test_no_multiple_of_the_step(key: str) -> None:
    with pytest.raises(ConfigurationError, match=rf"{key}: 0\.07 s is no multiple of this scenario's dt = 0\.05 s"):
        clock(**{key: 0.07})


def test_a_list_and_whole_numbers_are_actions() -> None:
    assert_array_equal(run("Constant").action[0], [1.0, 0.0])
    assert_array_equal(run("WholeNumbers").action[0], [2.0, -1.0])


def test_what_a_planner_does_to_its_dictionary_does_not_come_back() -> None:
    trajectory = run("Untidy")
    assert trajectory.outcome == "timeout"
    assert_allclose(trajectory.action[:-1, 0], 1.0 + trajectory.q[:-1, 0])


def test_a_preview_is_given_to_those_who_ask() -> None:
    assert run("Foreseeing").action[0, 0] == 2.0


def test_applied_actions_are_those_within_the_limits() -> None:
    robot = {
        "model": "point",
        "name": "p",
        "base": "fixed",
        "body_radius": 0.1,
        "limits": {"acceleration": [[-1, 1]] * 2},
    }
    trajectory = run("Constant", {"action": [3.0, 0.5]}, robot=robot)
    assert_array_equal(trajectory.action[0], [3.0, 0.5])
    assert_array_equal(trajectory.applied[0], [1.0, 0.5])
    assert_allclose(trajectory.u[-1], [1.0, 0.5])
