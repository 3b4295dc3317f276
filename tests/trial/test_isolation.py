"""Neither planners nor KPIs can change what is recorded, and filters of warnings decide nothing."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import numpy as np
import pytest

from pytest_lpb.kpis.registry import default_registry, kpi, load_builtin
from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.holder import PlannerHolder
from tests.problem.entries import POINT, circle, position_goal

from .specifications import run, specification


class Meddler(Planner):
    """Writes into the problem it was told of."""

    def setup(self, problem: PlannerProblem) -> None:
        problem.robot.entry["limits"] = {"position": None}
        problem.goal[0].entry["weight"] = 7.0  # type: ignore[index] # that it is a mapping to read is the point
        problem.to_dict()["robot"]["name"] = "other"

    def compute_action(self, observation: Observation) -> FloatArray:
        return np.zeros(2)


class Warner(Planner):
    """Divides by zero on the way to a sound action, and says something once."""

    def compute_action(self, observation: Observation) -> FloatArray:
        if observation["t"] == 0.0:
            self.diagnostics["first"] = 1.0
        return np.nan_to_num(np.zeros(2) / np.zeros(2))


def test_a_planner_cannot_change_the_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.trial.planners.Meddler", Meddler, raising=False)
    told = specification("Meddler", robot={**POINT, "limits": {"position": [[-5.0, 5.0], [-5.0, 5.0]]}})
    still = run("Still", robot={**POINT, "limits": {"position": [[-5.0, 5.0], [-5.0, 5.0]]}})
    meddled = run("Meddler", robot={**POINT, "limits": {"position": [[-5.0, 5.0], [-5.0, 5.0]]}})
    assert meddled.metadata["problem_hash"] == still.metadata["problem_hash"]
    assert meddled.problem.to_dict() == still.problem.to_dict()
    assert told.problem["robot"]["limits"] == {"position": [[-5.0, 5.0], [-5.0, 5.0]]}


def test_warnings_do_not_decide_how_a_planner_fares(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.trial.planners.Warner", Warner, raising=False)
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("error")
        strict = run("Warner")
    assert strict.outcome in ("timeout", "stalled")


def test_diagnostics_are_of_the_call_that_made_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.trial.planners.Warner", Warner, raising=False)
    with warnings.catch_warnings(record=True):
        trajectory = run("Warner")
    first = trajectory.planner("first")
    assert first[0] == 1.0
    assert np.isnan(first[1:]).all()


def test_a_kpi_cannot_change_raw_data() -> None:
    load_builtin()
    with default_registry.preserved():

        @kpi(name="vandal", unit="1", direction="none", over="all")
        def vandal(trajectory: Trajectory) -> Any:
            trajectory.q[:] = 9.0
            return 1.0

        trajectory = run("pd", goal=[position_goal([0.0, 0.0])], success={"hold_time": 0.0, "vandal": ">= 0"})
    assert not trajectory.metadata["success"]
    assert trajectory.metadata["failed_criteria"] == ["vandal >= 0 (nan)"]
    assert (trajectory.q[0] == 0.0).all()
    with pytest.raises(ValueError, match="read-only"):
        trajectory.clearance[:] = 1.0


def test_the_end_is_that_of_the_scenario() -> None:
    """A goal to be held to the end is not reached by a trial that a collision cuts short at the goal."""
    trajectory = run(
        "Constant",
        goal=[position_goal([0.5, 0.0], tolerance=0.6)],
        obstacles=[circle(0.6, 0.0, 0.2)],
        success={"hold_time": "end"},
    )
    assert trajectory.outcome == "collision"
    assert trajectory.goal_row is None


class Unbuildable(Planner):
    """Cannot be built, and has added to the search path by then."""

    def __init__(self, parameters: Any) -> None:
        sys.path.insert(0, "/nowhere")
        raise OSError("no licence")


def test_a_constructor_that_raises_leaves_nothing_in_the_search_path() -> None:
    before = list(sys.path)
    with pytest.raises(OSError, match="no licence"):
        PlannerHolder(PlannerConfiguration("it", f"{__name__}:Unbuildable")).get()
    assert sys.path == before
