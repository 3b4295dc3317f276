"""Problems 2 and 4 of localPlannerBench, solved by the shipped and by the published parameters."""

from __future__ import annotations

from pathlib import Path
from typing import Any

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
FIRST, LAST = ("panda_link0", "panda_link1", "panda_link2"), ("panda_link6", "panda_link7")

# The Panda as it was measured there: its link frames less one radius, and six pairs.
LINK_SPHERES: dict[str, Any] = {
    "collision": {"link_spheres": 0.15},
    "self_collision_pairs": [[one, other] for one in FIRST for other in LAST],
}
CONFIGURATIONS = {
    "shipped": find_planners(["fabrics"], [])[0],
    "published": PlannerConfiguration("published", "fabrics"),
    "reference": PlannerConfiguration("reference", "fabrics", {"curvature_term": "reference"}),
}


def run(scenario: str, configuration: str, robot: dict[str, Any] | None = None) -> Trajectory:
    """The trial, over its whole duration, the goal reached when it is first within its tolerance."""
    entry = copied(draw_problem(load_scenario(SCENARIOS / f"{scenario}.yaml"), 0).to_dict())
    entry["environment"]["end_at"] = []
    entry["success"] = {"hold_time": 0.0}
    entry["robot"].update(robot or {})
    return run_trial(TrialSpecification(entry, CONFIGURATIONS[configuration], scenario))


def path_length(trajectory: Trajectory, link: str) -> float:
    return float(np.linalg.norm(np.diff(trajectory.link(link), axis=0), axis=1).sum())


# Recorded: reached at 3.15 s, path 5.7712 m, clearance 0.388 m.
@pytest.mark.parametrize(("configuration", "reached"), [("shipped", 4.0), ("published", 6.0), ("reference", 7.0)])
def test_problem_2(configuration: str, reached: float) -> None:
    trajectory = run("point/one_circle", configuration)
    assert trajectory.outcome == "success"
    assert trajectory.goal_row is not None
    assert trajectory.t[trajectory.goal_row] < reached
    assert trajectory.clearance.min() > 0.05
    assert 4.0 < path_length(trajectory, "body") < 6.0


# Recorded: reached at 18.39 s, path 1.192 m, clearance 0.132 m.
@pytest.mark.parametrize("robot", [None, LINK_SPHERES], ids=["geometry", "link_spheres"])
@pytest.mark.parametrize(("configuration", "reached"), [("shipped", 3.0), ("published", 15.0)])
def test_problem_4(configuration: str, reached: float, robot: dict[str, Any] | None) -> None:
    trajectory = run("panda/one_sphere", configuration, robot)
    assert trajectory.outcome == "success"
    assert trajectory.goal_row is not None
    assert trajectory.t[trajectory.goal_row] < reached
    assert trajectory.clearance.min() > 0.05
    assert 0.9 < path_length(trajectory, "panda_link8") < 1.5
