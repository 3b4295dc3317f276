"""Problem 1 of local_planner_bench.md: what localPlannerBench v1.0.0 recorded for PD on the planar point."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.trial import run_trial

from .specifications import recorded_problem


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return run_trial(recorded_problem())


def test_it_runs_to_the_end(trajectory: Trajectory) -> None:
    assert len(trajectory) == 2001
    assert trajectory.outcome == "success"
    assert trajectory.t[-1] == pytest.approx(100.0)


def test_the_first_action(trajectory: Trajectory) -> None:
    assert_allclose(trajectory.action[0], [64.8, 3.24], rtol=1e-12)


@pytest.mark.parametrize(
    ("t", "q", "qd"),
    [(0.05, (0.081, 0.00405), None), (1.0, (2.47383, 0.12369), (1.84336, 0.09217)), (7.0, (4.4281, 0.2214), None)],
)
def test_states(trajectory: Trajectory, t: float, q: tuple[float, float], qd: tuple[float, float] | None) -> None:
    row = round(t / 0.05)
    assert trajectory.t[row] == pytest.approx(t)
    assert_allclose(trajectory.q[row], q, atol=1e-4)
    if qd is not None:
        assert_allclose(trajectory.qd[row], qd, atol=1e-4)


def test_time_to_goal(trajectory: Trajectory) -> None:
    assert trajectory.goal_row is not None
    assert trajectory.t[trajectory.goal_row] == pytest.approx(2.15)
    assert trajectory.metadata["message"].startswith("reached the goal after 2.15 s")


def test_path_length(trajectory: Trajectory) -> None:
    length = np.linalg.norm(np.diff(trajectory.link("body"), axis=0), axis=1).sum()
    assert length == pytest.approx(5.2900, abs=1e-3)


def test_clearance_at_the_start(trajectory: Trajectory) -> None:
    assert trajectory.clearance[0] == pytest.approx(np.hypot(2.0, 0.2) - 1.0 - 0.01)
    assert trajectory.clearance.min() == trajectory.clearance[0]
    assert set(trajectory.column("clearance_obstacle")) == {"disc"}
