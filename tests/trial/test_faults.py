"""Whatever a planner does wrong is its trial's outcome; the rows so far are kept."""

import os
import re
import signal
from typing import Any

import numpy as np
import pytest

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.trial import failed_trial, run_trial
from tests.problem.entries import CART, circle

from .planners import FAULT_AT
from .specifications import run, specification

# Fault: what the message says of it.
PLANNER_ERRORS = {
    "raises": r"KeyError: 'no\\nsuch thing' \(.*planners\.py:\d+\)",
    "raises_nothing_said": r"RuntimeError \(.*planners\.py:\d+\)",
    "leaves": r"SystemExit: 3 \(.*planners\.py:\d+\)",
    "forgets": r"compute_action returned None, which is no array of real numbers",
    "too_long": r"compute_action returned an array of shape \(3,\); expected \(2,\)",
    "column": r"an array of shape \(2, 1\); expected \(2,\)",
    "number": r"an array of shape \(\); expected \(2,\)",
    "not_finite": r"compute_action returned \[nan, 0\.0\]; every entry must be finite",
    "text": r"compute_action returned 'left', which is no array of real numbers",
    "texts": r"compute_action returned \['1\.0', '2\.0'\], which is no array of real numbers",
    "complex_numbers": r"no array of real numbers: its elements are complex128",
    "booleans": r"\[True, False\], which is no array of real numbers: its elements are bool",
    "ragged": r"which is no array of real numbers: .*inhomogeneous",
    "writes": r"ValueError: assignment destination is read-only \(.*planners\.py:\d+\)",
    "diagnoses_text": r"self\.diagnostics is \{'state': 'fine'\}, which is no dict\[str, float\]",
    "diagnoses_a_list": r"self\.diagnostics is \[1\.0\], which is no dict\[str, float\]",
    "diagnoses_an_array": r"self\.diagnostics is .*, which is no dict\[str, float\]",
}


def faulty(fault: str, **problem: Any) -> Trajectory:
    return run("Faulty", {"fault": fault}, **problem)


def matches(trajectory: Trajectory, text: str) -> None:
    with pytest.raises(AssertionError, match=text):
        raise AssertionError(trajectory.metadata["message"])
    assert "\n" not in trajectory.metadata["message"]


@pytest.mark.parametrize("fault", PLANNER_ERRORS)
def test_faults_of_a_planner(fault: str) -> None:
    trajectory = faulty(fault)
    assert trajectory.outcome == "planner_error"
    assert trajectory.metadata["success"] is False
    matches(trajectory, rf"^planner error at t = 0\.3 s: .*{PLANNER_ERRORS[fault]}")
    assert len(trajectory) == round(FAULT_AT / 0.05) + 1
    assert np.isfinite(trajectory.q).all()
    assert np.isfinite(trajectory.action[:-1]).all()
    assert np.isnan(trajectory.action[-1]).all()
    assert np.isfinite(trajectory.solver_wall_ms).all()  # the call that failed took time too
    ours = re.search("compute_action returned|self.diagnostics is", trajectory.metadata["message"])
    assert ("Traceback" in trajectory.metadata["details"]) == (ours is None)
    assert trajectory.metadata["trajectory_hash"]


def test_infeasible() -> None:
    trajectory = faulty("infeasible")
    assert trajectory.outcome == "infeasible"
    matches(trajectory, r"^infeasible at t = 0\.3 s: no way around \(.*planners\.py:\d+\)$")
    assert len(trajectory) == 7


@pytest.mark.parametrize(
    ("planner", "outcome", "text"),
    [
        ("BadSetup", "planner_error", r"^planner error at t = 0 s: ValueError: no solver \(.*planners\.py:\d+\)$"),
        ("BadConstructor", "planner_error", r"^planner error at t = 0 s: OSError: library missing"),
        ("Leaving", "planner_error", r"^planner error at t = 0 s: SystemExit: bye"),
        ("Abstract", "planner_error", r"NotImplementedError: Abstract must define compute_action\(self, observation\)"),
        ("InfeasibleSetup", "infeasible", r"^infeasible at t = 0 s: boxed in"),
    ],
)
def test_faults_before_the_first_step(planner: str, outcome: str, text: str) -> None:
    trajectory = run(planner)
    assert trajectory.outcome == outcome
    matches(trajectory, text)
    assert len(trajectory) == 1
    assert trajectory.q.tolist() == [[0.0, 0.0]]
    assert np.isnan(trajectory.action).all()


def test_the_next_trial_is_not_touched() -> None:
    before = run("Constant").metadata["trajectory_hash"]
    faulty("raises")
    assert run("Constant").metadata["trajectory_hash"] == before


@pytest.mark.parametrize("method", ["setup", "compute_action"])
def test_ctrl_c_is_no_fault_of_the_planner(monkeypatch: pytest.MonkeyPatch, method: str) -> None:
    from .planners import Still

    def interrupted(self: Still, observation: Any) -> Any:
        os.kill(os.getpid(), signal.SIGINT)
        return np.zeros(2)

    usual = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        monkeypatch.setattr(Still, method, interrupted)
        with pytest.raises(KeyboardInterrupt):
            run("Still")
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, usual)


@pytest.mark.parametrize("method", ["setup", "compute_action", "__init__"])
def test_an_interrupt_of_the_planner_s_own_is_one(monkeypatch: pytest.MonkeyPatch, method: str) -> None:
    from .planners import Still

    def interrupted(self: Still, *arguments: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(Still, method, interrupted)
    trajectory = run("Still")
    assert trajectory.outcome == "planner_error"
    matches(trajectory, "KeyboardInterrupt")


def test_faults_of_the_simulator(monkeypatch: pytest.MonkeyPatch) -> None:
    advance = ScenarioEnvironment.advance

    def breaking(self: ScenarioEnvironment, action: Any) -> None:
        if self.row == 3:
            raise ArithmeticError("lost contact")
        advance(self, action)

    monkeypatch.setattr(ScenarioEnvironment, "advance", breaking)
    trajectory = run("Constant")
    assert trajectory.outcome == "environment_error"
    matches(trajectory, r"^environment error at t = 0\.15 s: ArithmeticError: lost contact \(.*test_faults\.py:\d+\)$")
    assert len(trajectory) == 4
    assert np.isnan(trajectory.action[-1]).all()


def test_a_diverging_planner_ends_its_trial_only() -> None:
    trajectory = run("Constant", {"action": [1e200, 1e300]}, robot=CART, obstacles=[circle(9.0, 9.0, 1.0)])
    assert trajectory.outcome == "planner_error"
    matches(trajectory, "the actions drove the robot's position beyond 1e\\+12")
    assert np.isfinite(trajectory.q).all()
    assert not trajectory.metadata["success"]


def test_a_trial_that_could_not_run() -> None:
    trajectory = failed_trial(specification("pd"), "worker_crash", "worker 'gw0' died")
    assert (len(trajectory), trajectory.outcome) == (0, "worker_crash")
    assert trajectory.metadata["message"] == "worker 'gw0' died"
    assert set(trajectory.columns) >= set(run_trial(specification("pd")).columns) - {"planner_calls"}
    assert trajectory.goal_row is None
