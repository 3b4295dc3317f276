"""A planner in a process of its own does to the last bit what it does in this one, and is told the same faults."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import POINT, circle, position_goal
from tests.trial.specifications import configuration, same_columns, specification

from .trials import isolated

OBSTACLES = [circle(2.0, 0.1, 0.3), {**circle(0.0, 1.0, 0.2), "trajectory": ["1 + 0.1*t", "1"]}]
FAULTS = ["raises", "raises_nothing_said", "infeasible", "leaves", "forgets", "too_long", "column", "number"]
FAULTS += ["not_finite", "text", "texts", "complex_numbers", "booleans", "ragged", "writes"]
FAULTS += ["diagnoses_text", "diagnoses_a_list", "diagnoses_an_array"]


def both(planner: str, parameters: dict[str, Any] | None = None, **problem: Any) -> list[Any]:
    """The same trial here and isolated."""
    told = specification(planner, parameters, **problem)
    apart = replace(told, planner=replace(told.planner, isolation=Isolation(isolate=True)))
    return [run_trial(told), run_trial(apart)]


@pytest.mark.parametrize("planner", ["pd", "potential_field", "Clock", "Untidy", "Foreseeing", "WholeNumbers"])
def test_the_same_trial_to_the_last_bit(planner: str) -> None:
    obstacles = [{key: value for key, value in entry.items() if key != "trajectory"} for entry in OBSTACLES]
    here, apart = both(planner, robot=POINT, goal=[position_goal([4.0, 0.2])], obstacles=obstacles)
    assert apart.metadata["parameters_hash"] == here.metadata["parameters_hash"]
    round_trip = apart.columns.pop("planner_round_trip_ms")
    assert (round_trip[:-1] > 0.0).all()
    assert same_columns(here, apart)
    assert here.metadata["message"] == apart.metadata["message"]


@pytest.fixture(scope="module")
def faulty() -> Any:
    """One process for all faults: none of them ends it."""
    from pytest_lpb.trial.holder import PlannerHolder

    holder = PlannerHolder(replace(configuration("Faulty"), isolation=Isolation(isolate=True)))
    yield holder
    holder.close()


@pytest.mark.parametrize("fault", FAULTS)
def test_the_same_message_for_every_fault(fault: str, faulty: Any) -> None:
    told = specification("Faulty", {"fault": fault})
    here = run_trial(told)
    apart = run_trial(replace(told, planner=replace(told.planner, isolation=Isolation(isolate=True))), faulty)
    assert apart.outcome == here.outcome
    assert apart.metadata["message"] == here.metadata["message"]
    assert bool(apart.metadata["details"]) is bool(here.metadata["details"])
    assert apart.metadata["trajectory_hash"] == here.metadata["trajectory_hash"]


def test_it_runs_elsewhere_with_one_thread_and_the_environment_asked_for(tmp_path: Path) -> None:
    (tmp_path / "one").write_text("")
    trajectory = isolated("tests.isolation.planners:Tells", environment={"MINE": "3"}, working_dir=str(tmp_path))
    assert trajectory.planner("pid")[0] != os.getpid()
    assert trajectory.planner("threads")[0] == 1.0
    assert trajectory.planner("mine")[0] == 3.0
    assert trajectory.planner("files")[0] == 1.0


def test_time_is_measured_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """A slow connection is no slow solver."""
    import time

    from pytest_lpb.isolation.far.stream import Stream

    received = Stream.receive

    def slowly(self: Stream, timeout_s: float | None = None) -> Any:
        time.sleep(0.02)
        return received(self, timeout_s)

    monkeypatch.setattr(Stream, "receive", slowly)
    trajectory = isolated("tests.isolation.planners:Tells")
    # The planner computes while this side sleeps.
    assert np.nanmin(trajectory.columns["planner_round_trip_ms"] + trajectory.solver_wall_ms) >= 20.0
    assert np.nanmedian(trajectory.columns["planner_round_trip_ms"]) >= 19.0
    assert np.nanmedian(trajectory.solver_wall_ms) < 20.0
