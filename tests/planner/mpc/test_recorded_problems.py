"""Problems 3 and 4 of localPlannerBench, which recorded an MPC of its own on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import find_planners
from pytest_lpb.problem.hashing import copied
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial

SCENARIOS = Path(__file__).parents[3] / "scenarios"
SHIPPED = find_planners(["mpc"], [])[0]
RECORDED = {"horizon": 30, "goal": 1.0, "goal_end": 1.0, "velocity": 1.0, "velocity_end": 0.0, "input": 1.0}


def run(scenario: str, configuration: PlannerConfiguration) -> Trajectory:
    """The trial, over its whole duration, the goal reached when it is first within its tolerance."""
    entry = copied(draw_problem(load_scenario(SCENARIOS / f"{scenario}.yaml"), 0).to_dict())
    entry["environment"]["end_at"] = []
    entry["success"] = {"hold_time": 0.0}
    return run_trial(TrialSpecification(entry, configuration, scenario))


def test_problem_3_with_the_recorded_weights_is_as_recorded() -> None:
    trajectory = run("point/one_circle", PlannerConfiguration("mpc", "mpc", RECORDED, period=0.1))
    assert trajectory.outcome == "success"
    assert trajectory.goal_row is not None
    assert trajectory.t[trajectory.goal_row] == pytest.approx(5.20, abs=0.1)
    path = np.linalg.norm(np.diff(trajectory.link("body"), axis=0), axis=1).sum()
    assert path == pytest.approx(4.5635, abs=0.02)
    assert trajectory.clearance.min() > 0.0  # recorded: it grazed the circle by a millimetre


@pytest.mark.parametrize("scenario", ["point/one_circle", "panda/one_sphere"])
def test_problems_3_and_4_as_shipped(scenario: str) -> None:
    trajectory = run(scenario, SHIPPED)
    assert trajectory.outcome == "success"
    assert trajectory.clearance.min() > 0.0
    assert trajectory.planner("solved")[0] == 1.0
