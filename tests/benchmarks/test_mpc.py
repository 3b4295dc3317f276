"""Speed of the MPC planner in closed loop. Run `pytest tests/benchmarks -n 0`; no time is ever asserted.

Medians and percentiles of the planner's calls but the first are in extra_info. Warm-started ipopt on the same problem
in the same run is the yardstick.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.problem.hashing import copied
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.spatial.entries import panda_entry, problem_of

SCENARIOS = Path(__file__).parents[2] / "scenarios"
SPHERES = [[0.7, 0.3, 0.6], [-0.5, 0.3, 0.2], [0.2, 0.8, 0.5], [0.5, -0.5, 0.8], [0.0, 0.5, 1.2]]
LINKS = {f"panda_link{index}": [[0.0, 0.0, 0.0, 0.08]] for index in range(3, 9)}


def point(folder: Path) -> Problem:
    """The point among five circles, with limits."""
    entry = copied(draw_problem(load_scenario(SCENARIOS / "point/two_circles_random.yaml"), 3).to_dict())
    entry["robot"]["limits"] |= {"velocity": [[-2.0, 2.0]] * 2, "acceleration": [[-4.0, 4.0]] * 2}
    entry["environment"] |= {"end_at": [], "duration": 10.0}
    return Problem.from_dict(entry, "point")


def panda(folder: Path) -> Problem:
    """The Panda with six links as spheres among five spheres."""
    obstacles = [
        {"name": f"o{index}", "shape": "sphere", "radius": 0.1, "position": place}
        for index, place in enumerate(SPHERES)
    ]
    made = panda_entry(obstacles, environment={"duration": 5.0, "end_at": []})
    made["robot"] = made["robot"] | {"collision": {"spheres": LINKS}, "self_collision_pairs": []}
    return problem_of(folder, made)


CASES = {"point": (point, 20), "panda": (panda, 30)}


@pytest.mark.parametrize("solver", ["sqp", "ipopt"])
@pytest.mark.parametrize("case", CASES)
def test_calls_in_closed_loop(benchmark: BenchmarkFixture, case: str, solver: str, tmp_path: Path) -> None:
    make, horizon = CASES[case]
    parameters: dict[str, Any] = {"horizon": horizon, "solver": solver}
    if solver == "ipopt":
        parameters |= {"nearest": 0, "own_nearest": 0}
    configuration = PlannerConfiguration("mpc", "mpc", parameters, period=0.1)
    specification = TrialSpecification(make(tmp_path).to_dict(), configuration, case)
    calls: list[np.ndarray[Any, Any]] = []

    def trial() -> None:
        trajectory = run_trial(specification)
        assert trajectory.outcome in ("success", "timeout", "stalled"), trajectory.metadata["message"]
        calls.append(trajectory.solver_wall_ms[np.isfinite(trajectory.solver_wall_ms)][1:])

    benchmark.pedantic(trial, rounds=3, warmup_rounds=1)  # type: ignore[no-untyped-call]
    times = np.concatenate(calls[1:]) if len(calls) > 1 else calls[0]
    for name, share in (("median", 50.0), ("p95", 95.0), ("p99", 99.0)):
        benchmark.extra_info[f"{name}_ms_per_call"] = round(float(np.percentile(times, share)), 3)
    assert len(times) > 0
