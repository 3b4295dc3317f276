"""What a trial says of itself in one sentence, and the criteria of success."""

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import pytest

from pytest_lpb.errors import KpiError
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.message import outcome_message
from pytest_lpb.trial.outcome import OUTCOMES, SOFTWARE_FAULTS
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import ARM, POINT, circle, position_goal

from .specifications import run, specification

MOVER = {**POINT, "control": "velocity"}


def message(planner: str = "Constant", parameters: Any = None, **problem: Any) -> str:
    trajectory = run(planner, parameters, **{"robot": MOVER, **problem})
    assert trajectory.outcome in OUTCOMES
    text: str = trajectory.metadata["message"]
    return text


def test_success() -> None:
    goal = [position_goal([0.5, 0.0], tolerance=0.12)]
    assert message(goal=goal, success={"hold_time": 0.1}) == "reached the goal after 0.4 s"
    near = message(goal=goal, success={"hold_time": 0.1}, obstacles=[circle(0.0, 1.5, 0.4)])
    assert near == "reached the goal after 0.4 s; closest obstacle 'disc' at 0.90 m"


def test_timeout() -> None:
    text = message(goal=[position_goal([5.0, 0.0])], obstacles=[circle(0.0, 1.0, 0.3)])
    assert text == "reached 4.00 m from the goal (tolerance 0.10 m) after 1.0 s; closest obstacle 'disc' at 0.50 m"


def test_stalled() -> None:
    text = message("Still", goal=[position_goal([5.0, 0.0])], duration=6.0)
    assert text == (
        "came to a standstill 5.00 m from the goal (tolerance 0.10 m) after 6.0 s, "
        "no nearer since t = 0 s: a local minimum or a cycle"
    )


def test_timeout_at_a_joint_limit() -> None:
    limited = {**MOVER, "limits": {"position": [[-0.5, 1.01], None]}}
    assert "after 1.0 s, 'x' at the limit" in message(goal=[position_goal([5.0, 0.0])], robot=limited)


def test_collision() -> None:
    text = message(goal=[position_goal([5.0, 0.0])], obstacles=[circle(1.02, 0.0, 0.5)])
    assert text.startswith("'body' hit obstacle 'disc' at t = 0.32 s (0.03 m deep), ")
    assert text.endswith("4.65 m from the goal (tolerance 0.10 m)")


def test_self_collision() -> None:
    arm = {**ARM, "links": [1.0, 1.0, 1.0]}
    text = message("Still", robot=arm, q=[0.0, 0.95 * pi, 0.95 * pi])
    assert text.startswith("'link1' hit 'link3' at t = 0 s (")


def test_joint_limit() -> None:
    text = message(robot={**MOVER, "limits": {"position": [[-1.0, 0.42], None]}}, goal=[position_goal([5.0, 0.0])])
    assert text.startswith("joint 'x' at 0.45 left its limits [-1, 0.42] at t = 0.45 s, 4.55 m from the goal")


def test_other_sub_goals_are_named_when_missed() -> None:
    goal = [position_goal([1.0, 0.0]), position_goal([1.0, 3.0], name="other"), position_goal([1.0, 0.0], name="fine")]
    text = message(goal=goal, duration=1.0)
    assert "0.00 m from the goal (tolerance 0.10 m) and 3.00 m from 'other' (tolerance 0.10 m) after" in text
    assert "fine" not in text


def test_criteria_that_are_met() -> None:
    trajectory = run(
        "Constant",
        robot=MOVER,
        goal=[position_goal([0.5, 0.0], tolerance=0.12)],
        obstacles=[circle(0.0, 1.5, 0.4)],
        success={"hold_time": 0.1, "clearance_min_m": ">= 0.89", "time_to_goal_s": "< 0.41"},
    )
    assert trajectory.metadata["success"] is True
    assert trajectory.metadata["failed_criteria"] == []


def test_criteria_that_are_not_met() -> None:
    trajectory = run(
        "Constant",
        robot=MOVER,
        goal=[position_goal([0.5, 0.0], tolerance=0.12)],
        success={"hold_time": 0.1, "clearance_min_m": ">= 0.02", "time_to_goal_s": "<= 0.3", "path_length_m": "> 0"},
    )
    assert trajectory.outcome == "success"
    assert trajectory.metadata["success"] is False
    # Without obstacles there is no clearance: what does not apply is not asked.
    assert trajectory.metadata["failed_criteria"] == [
        "time_to_goal_s <= 0.3 (0.4)",
    ]
    assert trajectory.metadata["message"].endswith("; but not time_to_goal_s <= 0.3 (0.4)")


def test_criteria_do_not_speak_of_failures() -> None:
    trajectory = run("Still", success={"clearance_min_m": ">= 9"})
    assert trajectory.metadata["failed_criteria"] == []
    assert trajectory.metadata["success"] is False


def test_an_unknown_criterion() -> None:
    with pytest.raises(KpiError, match="clearance_mini_m"):
        run(
            "Constant",
            robot=MOVER,
            goal=[position_goal([0.5, 0.0])],
            success={"hold_time": 0, "clearance_mini_m": "> 1"},
        )


def test_software_faults_are_outcomes() -> None:
    assert set(SOFTWARE_FAULTS) < set(OUTCOMES)


@pytest.mark.parametrize("contended", [True, False])
def test_timing_criteria_count_only_when_timing_can_be_trusted(
    contended: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Trajectory, "timing_contended", contended)
    success = {"hold_time": 0.1, "solver_time_max_ms": "< 0", "path_length_m": "> 0"}
    metadata = run("Constant", robot=MOVER, goal=[position_goal([0.5, 0.0])], success=success).metadata
    assert metadata["success"] is contended
    assert len(metadata["failed_criteria"]) == (0 if contended else 1)


def test_more_workers_than_cores_contend() -> None:
    made = specification("Constant", robot=MOVER)
    assert run_trial(replace(made, workers=100_000)).timing_contended


def test_distances_of_a_robot_that_diverged_are_short() -> None:
    goal = [position_goal([5.0, 0.0])]
    made = run("Still", goal=goal, obstacles=[circle(0.0, 1.0, 0.3)])
    far = {"goal_reach_error": np.full(len(made), 1.25e300), "clearance_m": np.full(len(made), 3e200)}
    text = outcome_message(Trajectory({**made.columns, **far}, made.metadata, made.problem), None, "")
    assert "1.25e+300 m from the goal (tolerance 0.10 m)" in text
    assert "at 3e+200 m" in text


@pytest.mark.parametrize(
    ("duration", "hold_time", "words"),
    [
        # 1 m/s to a target at 0.55 m: within its 0.12 m from 0.45 to 0.65 s.
        (
            0.6,
            0.5,
            "0.05 m from the goal (tolerance 0.12 m) after 0.6 s, in the goal for the last 0.15 s; hold_time is 0.5 s",
        ),
        (1.0, 0.5, "after 1.0 s, in the goal for 0.2 s from t = 0.45 s; hold_time is 0.5 s"),
        (1.0, "end", "in the goal for 0.2 s from t = 0.45 s; hold_time is end"),
    ],
)
def test_a_goal_that_was_not_held_names_the_hold_time(duration: float, hold_time: float | str, words: str) -> None:
    goal = [position_goal([0.55, 0.0], tolerance=0.12)]
    assert words in message(goal=goal, duration=duration, success={"hold_time": hold_time})


def test_a_goal_that_was_left_again_and_again() -> None:
    made = run("Still", goal=[position_goal([5.0, 0.0])])
    error = np.where(np.isin(np.arange(len(made)), [3, 4, 8, 9, 10, 15]), 0.05, 1.0)
    passing = Trajectory({**made.columns, "goal_reach_error": error}, made.metadata, made.problem)
    words = "in the goal for at most 0.1 s from t = 0.4 s; hold_time is 0.5 s"
    assert words in outcome_message(passing, None, "")
    error = np.where(np.arange(len(made)) == 4, 0.05, 1.0)
    once = Trajectory({**made.columns, "goal_reach_error": error}, made.metadata, made.problem)
    assert "in the goal at t = 0.2 s and out of it a step later; hold_time is 0.5 s" in outcome_message(once, None, "")
