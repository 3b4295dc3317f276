"""Speed of trials and of their files. Run `pytest tests/benchmarks -n 0`; no time is ever asserted."""

from math import sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.kpis.registry import default_registry, evaluate_kpis, load_builtin
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.files import read_trial, trial_path, write_trial
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import circle, make_problem, position_goal, problem_entry

STEPS = 500
POINT = {"model": "point", "name": "point", "base": "fixed", "body_radius": 0.2}
ARM = {"model": "planar_arm", "name": "arm_7", "links": [0.5] * 7, "base": "fixed", "body_radius": 0.05}
OBSTACLES = [circle(2.0, 1.5, 1.0, "left"), circle(2.4, -1.8, 1.0, "right")]


def specification() -> TrialSpecification:
    """PD on the point for 500 steps past two circles."""
    entry = problem_entry(
        POINT, goal=[position_goal([4.0, 0.2])], obstacles=OBSTACLES, dt=0.05, duration=0.05 * STEPS, end_at=[]
    )
    return TrialSpecification(entry, PlannerConfiguration("pd", "pd"), "point/benchmark")


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return run_trial(specification())


def test_pd_trials_on_the_point(benchmark: BenchmarkFixture) -> None:
    """Environment, collision, planner and recording."""
    made = specification()
    result = benchmark(run_trial, made)
    assert len(result) == STEPS + 1
    if benchmark.stats:  # not with --benchmark-disable
        benchmark.extra_info["steps_per_s"] = round(STEPS / benchmark.stats["median"])


@pytest.mark.parametrize("moving", [False, True], ids=["static", "moving"])
def test_step_of_an_arm_of_seven_links_among_ten_obstacles(benchmark: BenchmarkFixture, moving: bool) -> None:
    obstacles: list[dict[str, Any]] = []
    for index in range(10):
        x, y = 5.0 * sin(index), 5.0 * sin(index + 1.6)
        obstacles.append(circle(x, y, 0.3, f"o{index}"))
        if moving:
            del obstacles[-1]["position"]
            obstacles[-1]["trajectory"] = [f"{x!r} + 0.1*sin(t)", f"{y!r}"]
    problem = make_problem(ARM, obstacles=obstacles, duration=10_000.0, end_at=[])
    environment = ScenarioEnvironment(problem=problem, reuse_observations=True)
    action = [0.0] * 7
    benchmark(environment.step, action)
    assert environment.row > 0


def test_reset_to_another_problem(benchmark: BenchmarkFixture) -> None:
    environment = ScenarioEnvironment(problem=make_problem(ARM, obstacles=[circle(9.0, 9.0, 1.0)]))
    benchmark(environment.reset)
    assert environment.row == 0


def test_write_trial(benchmark: BenchmarkFixture, trajectory: Trajectory, tmp_path: Path) -> None:
    path = trial_path(tmp_path, "point/benchmark", "pd", 0)
    arguments = {"args": (tmp_path, trajectory), "setup": lambda: path.unlink(missing_ok=True), "rounds": 50}
    benchmark.pedantic(write_trial, **arguments, warmup_rounds=3)  # type: ignore[no-untyped-call]
    benchmark.extra_info["bytes"] = path.stat().st_size
    assert path.is_file()


def test_read_trial_and_all_kpis(benchmark: BenchmarkFixture, trajectory: Trajectory, tmp_path: Path) -> None:
    load_builtin()
    path, kpis = write_trial(tmp_path, trajectory), list(default_registry)

    def evaluate() -> tuple[dict[str, float], list[str]]:
        return evaluate_kpis(read_trial(path), kpis)

    values, faults = benchmark(evaluate)
    assert not faults
    assert np.isfinite(values["path_length_m"])
