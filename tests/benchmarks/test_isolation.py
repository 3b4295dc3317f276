"""Cost of a process of its own: the same calls in process and isolated. Run `pytest tests/benchmarks -n 0`."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from pytest_lpb.environment.observation import Observation
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.planner.base import Planner, PlannerProblem
from pytest_lpb.planner.configuration import PlannerConfiguration
from tests.problem.entries import circle, make_problem, position_goal

PLACES = {
    "in_process": None,
    "isolated": Isolation(isolate=True),
    "deadline": Isolation(isolate=True, deadline_s=1.0),
    "python": Isolation(isolate=True, python=sys.executable),
}


@pytest.fixture(params=list(PLACES))
def planner(request: pytest.FixtureRequest) -> Iterator[Planner]:
    """The planner pd, set up for the point."""
    planner = PlannerConfiguration("pd", "pd", isolation=PLACES[request.param]).build()
    yield planner
    planner.close()


def test_call_of_pd_on_the_point(benchmark: BenchmarkFixture, planner: Planner) -> None:
    """Extra information of isolated ones: the part of the call that is no computation."""
    problem = make_problem(goal=[position_goal([4.0, 0.2])], obstacles=[circle(2.0, 1.5, 1.0)])
    planner.setup(PlannerProblem.of(problem, 0.05))
    observation = dict(Observation(problem, None, 1).views)
    trips: list[float] = []

    def call() -> None:
        planner.compute_action(observation)
        trips.append(getattr(planner, "round_trip_ms", 0.0))

    benchmark.pedantic(call, rounds=3000, warmup_rounds=200, iterations=1)  # type: ignore[no-untyped-call]
    benchmark.extra_info["round_trip_median_us"] = round(1e3 * float(np.median(trips)), 1)


@pytest.mark.parametrize("place", ["isolated", "python"])
def test_start_of_a_process(benchmark: BenchmarkFixture, place: str) -> None:
    """Interpreter, NumPy, our package, setup, and its end."""
    configuration = PlannerConfiguration("pd", "pd", isolation=PLACES[place])
    problem = PlannerProblem.of(make_problem(goal=[position_goal([4.0, 0.2])]), 0.05)
    configuration.check()

    def start() -> None:
        planner = configuration.build()
        planner.setup(problem)
        planner.close()

    benchmark.pedantic(start, rounds=5, iterations=1)  # type: ignore[no-untyped-call]
