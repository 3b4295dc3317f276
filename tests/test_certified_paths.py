"""Every scenario in space comes with a path that solves it; each is checked anew."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_lpb.errors import MissingRobotsError
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario
from tests.certificates.paths import faults_of_path, path_length, read_path

ROOT = Path(__file__).parents[1]
SPATIAL = sorted(
    path for path in (ROOT / "scenarios").rglob("*.yaml") if "engine: pybullet" in path.read_text(encoding="utf-8")
)
LEAST_SCENARIOS = 20


def problem_of(path: Path) -> Problem:
    """The problem that a scenario's path solves; skips the test where the robot's package is not installed."""
    try:
        scenario = load_scenario(path)
    except MissingRobotsError as error:
        pytest.skip(str(error))
    certified = scenario.concrete["certified"]
    return draw_problem(scenario, certified["seed"])


def test_there_are_enough_of_them() -> None:
    assert len(SPATIAL) >= LEAST_SCENARIOS


@pytest.mark.parametrize("path", SPATIAL, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_the_certified_path_solves_the_problem(path: Path) -> None:
    problem = problem_of(path)
    t, q = read_path(Path(problem.to_dict()["certified"]["path"]))
    assert faults_of_path(problem, t, q) == []
    assert problem.certified_path_length_m == pytest.approx(path_length(problem, q), rel=1e-3)


def test_a_path_into_an_obstacle_is_found_out() -> None:
    problem = problem_of(ROOT / "scenarios" / "point_3d" / "wall_with_window.yaml")
    t, q = read_path(Path(problem.to_dict()["certified"]["path"]))
    straight = [0, len(t) - 1]
    faults = faults_of_path(problem, t[straight], q[straight])
    assert any("inside" in fault for fault in faults)


def test_a_path_that_slips_jumps_or_misses_is_found_out() -> None:
    problem = problem_of(ROOT / "scenarios" / "cart" / "moving_crowd.yaml")
    t, q = read_path(Path(problem.to_dict()["certified"]["path"]))
    sideways = q.copy()
    sideways[:, 2] += 1.0
    assert "its base slips sideways" in faults_of_path(problem, t, sideways)
    assert "it does not begin at the start" in faults_of_path(problem, t[3:] - t[3], q[3:])
    assert "it does not end within the goal's tolerances" in faults_of_path(problem, t[:-5], q[:-5])
