"""Specifications of trials, and what of a trial is not a time."""

from typing import Any

import numpy as np

from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import Entry, circle, position_goal, problem_entry

POINT_01: Entry = {"model": "point", "name": "point", "base": "fixed", "body_radius": 0.01}
PD: Entry = {"p": 0.2, "k": 0.8, "derivative": "difference"}
TIMES = ("solver_wall_ms", "solver_cpu_ms")


def configuration(planner: str, parameters: Entry | None = None, **keywords: Any) -> PlannerConfiguration:
    reference = planner if planner in ("pd", "potential_field") else f"tests.trial.planners:{planner}"
    return PlannerConfiguration(name=planner, planner=reference, parameters=parameters or {}, **keywords)


def specification(
    planner: str = "pd", parameters: Entry | None = None, *, timing: Entry | None = None, **problem: Any
) -> TrialSpecification:
    return TrialSpecification(
        problem=problem_entry(**problem), planner=configuration(planner, parameters, **timing or {}), scenario="family"
    )


def run(planner: str = "pd", parameters: Entry | None = None, **keywords: Any) -> Trajectory:
    return run_trial(specification(planner, parameters, **keywords))


def recorded_problem() -> TrialSpecification:
    """Problem 1 of the reference: PD on the planar point."""
    return specification(
        "pd",
        PD,
        robot={**POINT_01, "limits": {"position": [[-5.0, 5.0], [-5.0, 5.0]]}},
        goal=[position_goal([4.0, 0.2])],
        obstacles=[circle(-2.0, 0.2, 1.0)],
        duration=100.0,
        end_at=[],
        success={"hold_time": 0.0},
    )


def same_columns(first: Trajectory, second: Trajectory) -> bool:
    """Whether two trials are equal to the last bit, but for times measured."""
    if list(first.columns) != list(second.columns):
        return False
    return all(
        np.array_equal(first.columns[name], second.columns[name], equal_nan=first.columns[name].dtype == np.float64)
        for name in first.columns
        if name not in TIMES
    )
