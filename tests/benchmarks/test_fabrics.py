"""Speed of the fabrics planner. Run `pytest tests/benchmarks -n 0`; no time is ever asserted.

The Panda is that of the reference release's table: six links as spheres, five obstacles, position limits.
"""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from pytest_lpb.planner.base import Observation, PlannerProblem
from pytest_lpb.planner.fabrics import planner as module
from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.fabrics.planner import Fabrics
from pytest_lpb.planner.files import find_planners
from tests.planner.fabrics.reference import observation_of, problem_of_row, rows_of

COMPILER = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
WAYS = ["interpreted", pytest.param("compiled", marks=COMPILER)]


def shipped(robot: str) -> FabricsParameters:
    """The parameters of planners/fabrics.yaml for a robot under acceleration control."""
    parameters = find_planners(["fabrics"], [])[0].parameters_for(robot, "acceleration")
    assert isinstance(parameters, FabricsParameters)
    return parameters


def panda() -> tuple[PlannerProblem, Observation]:
    row = rows_of("panda")[0]
    return problem_of_row("panda", row), observation_of(row)


def point_among_five_circles() -> tuple[PlannerProblem, Observation]:
    row = dict(rows_of("point")[0])
    for index, (x, y) in enumerate([(2.0, 1.0), (-2.0, 2.0), (1.0, -3.0), (-3.0, -1.0), (0.5, 1.0)]):
        row[f"x_obst_{index}"], row[f"radius_obst_{index}"] = [x, y], [0.5]
    return problem_of_row("point", row), observation_of(row)


def prepared(way: str, parameters: FabricsParameters, problem: PlannerProblem) -> Fabrics:
    planner = Fabrics(replace(parameters, compile=way == "compiled"))
    planner.setup(problem)
    return planner


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("parameters", ["published", "shipped"])
def test_compute_action_of_the_panda(
    benchmark: BenchmarkFixture, way: str, parameters: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTEST_LPB_CACHE", str(tmp_path))
    problem, observation = panda()
    planner = prepared(way, FabricsParameters() if parameters == "published" else shipped("panda"), problem)
    action = benchmark(planner.compute_action, observation)
    assert np.isfinite(action).all()


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("parameters", ["published", "shipped"])
def test_compute_action_of_the_point_among_five_circles(
    benchmark: BenchmarkFixture, way: str, parameters: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTEST_LPB_CACHE", str(tmp_path))
    problem, observation = point_among_five_circles()
    planner = prepared(way, FabricsParameters() if parameters == "published" else shipped("point"), problem)
    action = benchmark(planner.compute_action, observation)
    assert np.isfinite(action).all()


def test_setup_of_a_new_problem_of_the_same_structure(benchmark: BenchmarkFixture) -> None:
    rows = rows_of("panda")
    planner = Fabrics(FabricsParameters())
    problems = [problem_of_row("panda", row) for row in rows]
    planner.setup(problems[0])
    composed = module._composed.cache_info().misses

    def setup() -> None:
        planner.setup(problems[1])

    benchmark(setup)
    assert module._composed.cache_info().misses == composed


def test_first_composition_of_the_panda(benchmark: BenchmarkFixture) -> None:
    problem, _ = panda()
    planner = Fabrics(FabricsParameters())

    def first() -> None:
        module._composed.cache_clear()
        planner.setup(problem)

    benchmark(first)
    assert module._composed.cache_info().currsize == 1
