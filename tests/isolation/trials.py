"""Trials of planners in processes of their own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.holder import PlannerHolder
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import problem_entry

HOSTILE = "tests.isolation.planners:Hostile"


def specification(planner: str, parameters: dict[str, Any], keys: dict[str, Any], **problem: Any) -> TrialSpecification:
    """A trial; with `keys` its planner is isolated."""
    isolation = Isolation(**{"isolate": True, **keys}) if keys is not None else None
    configuration = PlannerConfiguration(name="it", planner=planner, parameters=parameters, isolation=isolation)
    return TrialSpecification(problem=problem_entry(**problem), planner=configuration, scenario="family")


def isolated(planner: str, parameters: dict[str, Any] | None = None, **keys: Any) -> Trajectory:
    """A trial of a planner in its own process."""
    return run_trial(specification(planner, parameters or {}, keys))


def here(planner: str, parameters: dict[str, Any] | None = None, **problem: Any) -> Trajectory:
    """The same trial in this process."""
    told = specification(planner, parameters or {}, {}, **problem)
    return run_trial(replace(told, planner=replace(told.planner, isolation=None)))


def pair(faulty: dict[str, Any], sound: dict[str, Any], **keys: Any) -> tuple[Trajectory, Trajectory]:
    """A trial that goes wrong, and the next of the same planner."""
    first = specification(HOSTILE, faulty, keys)
    second = specification(HOSTILE, sound, keys)
    holder = PlannerHolder(first.planner)
    try:
        return run_trial(first, holder), run_trial(second, holder)
    finally:
        holder.close()
