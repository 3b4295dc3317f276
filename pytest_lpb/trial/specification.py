"""Everything that decides a trial, in one picklable object."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pytest_lpb.planner.configuration import PlannerConfiguration


def usable_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class TrialSpecification:
    """A trial to run, in whatever process.

    The trial's key is (scenario, planner name, seed); its result depends on `problem` and `planner` alone.
    """

    problem: Mapping[str, Any]  # the concrete dictionary
    planner: PlannerConfiguration
    scenario: str = "problem"
    node_id: str = ""
    command: str = ""  # repeats the trial
    attempt: int = 1
    workers: int = 1  # processes that run trials at the same time

    @property
    def seed(self) -> int:
        """The problem's seed."""
        seed: int = self.problem["seed"]
        return seed

    def with_problem(self, problem: Mapping[str, Any]) -> TrialSpecification:
        """The same trial with another concrete problem."""
        return replace(self, problem=problem)
