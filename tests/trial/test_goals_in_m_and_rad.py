"""Joint goals over prismatic and revolute joints: errors, tolerances, KPIs and words of each unit by itself."""

import math
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.errors import ScenarioError
from pytest_lpb.kpis.registry import evaluate_kpis, load_builtin
from pytest_lpb.planner.base import PlannerProblem
from pytest_lpb.planner.files import find_planners
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.files import read_trial, write_trial
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from pytest_lpb.trial.units import unit_of

from .specifications import configuration

URDF = """<robot name="mixed"><link name="base"/>
<link name="carriage"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="tip"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="base"/><child link="carriage"/>
  <axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="1" velocity="2"/></joint>
<joint name="turn" type="revolute"><parent link="carriage"/><child link="tip"/>
  <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit lower="-3.1" upper="3.1" effort="1" velocity="2"/></joint></robot>
"""
SCENARIO = """version: 1
robot: {{urdf: mixed.urdf, limits: {{acceleration: [[-5, 5], [-5, 5]]}}}}
environment: {{engine: pybullet, dt: 0.05, duration: {duration}}}
start: {{q: {start}}}
goal:
  - {{name: posture, type: joint, joints: [turn, slide], target: [0.0, 0.0], tolerance: {tolerance}}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mixed")
    (folder / "mixed.urdf").write_text(URDF)
    return folder


def problem(folder: Path, start: str, tolerance: str = "0.05", duration: float = 1.0) -> Problem:
    path = folder / "x.yaml"
    path.write_text(SCENARIO.format(start=start, tolerance=tolerance, duration=duration))
    return draw_problem(load_scenario(path), 0)


def run(folder: Path, *parts: Any, planner: Any = None) -> Trajectory:
    made = problem(folder, *parts)
    return run_trial(TrialSpecification(made.to_dict(), planner or configuration("Still")))


def kpis(trajectory: Trajectory, *names: str) -> list[float]:
    values, faults = evaluate_kpis(trajectory, load_builtin().select(list(names)))
    assert not faults
    return [values[name] for name in names]


GOAL_KPIS = ("final_goal_distance_m", "min_goal_distance_m", "final_goal_error_rad", "min_goal_error_rad")


@pytest.mark.parametrize(
    ("start", "words", "errors"),
    [
        ("[1.0, 0.0]", "1.00 m and 0.00 rad from the goal", [1.0, 1.0, 0.0, 0.0]),
        ("[0.0, -2.0]", "0.00 m and 2.00 rad from the goal", [0.0, 0.0, 2.0, 2.0]),
    ],
)
def test_each_error_has_its_unit(folder: Path, start: str, words: str, errors: list[float]) -> None:
    trajectory = run(folder, start)
    assert trajectory.outcome == "timeout"
    assert f"{words} (tolerance 0.05 m and 0.05 rad)" in trajectory.metadata["message"]
    assert kpis(trajectory, *GOAL_KPIS) == errors


@pytest.mark.parametrize(
    ("start", "tolerance", "outcome"),
    [
        ("[0.02, 0.02]", "0.05", "success"),
        ("[0.02, 0.02]", "{m: 0.05, rad: 0.05}", "success"),
        ("[0.02, 0.2]", "{m: 0.05, rad: 0.3}", "success"),
        ("[0.2, 0.02]", "{m: 0.05, rad: 0.3}", "timeout"),
        ("[0.02, 0.4]", "{m: 0.05, rad: 0.3}", "timeout"),
    ],
)
def test_success_needs_both(folder: Path, start: str, tolerance: str, outcome: str) -> None:
    trajectory = run(folder, start, tolerance)
    assert trajectory.outcome == outcome
    assert (trajectory.goal_row is None) == (outcome == "timeout")


def test_one_number_is_the_same_tolerance_in_both_units(folder: Path) -> None:
    number, apart = problem(folder, "[0, 0]", "0.05"), problem(folder, "[0, 0]", "{rad: 0.05, m: 0.05}")
    assert number.problem_hash == apart.problem_hash
    assert number.problem_hash != problem(folder, "[0, 0]", "{rad: 0.05, m: 0.04}").problem_hash


def test_planners_see_the_smaller_tolerance_and_both_in_the_entry(folder: Path) -> None:
    (goal,) = PlannerProblem.of(problem(folder, "[0, 0]", "{m: 0.01, rad: 0.05}"), 0.05).goal
    assert goal.tolerance == 0.01
    assert goal.entry["tolerance"] == {"m": 0.01, "rad": 0.05}


def test_a_file_has_a_column_per_unit_and_files_without_them_are_read(folder: Path, tmp_path: Path) -> None:
    trajectory = run(folder, "[0.7, -1.2]", "{m: 0.01, rad: 0.05}")
    back = read_trial(write_trial(tmp_path, trajectory))
    columns = [name for name in back.columns if name.startswith("goal_")]
    error = "goal_posture_error"
    assert columns == ["goal_posture_0", "goal_posture_1", error, f"{error}_m", f"{error}_rad"]
    assert [unit_of(name, back.problem) for name in columns] == ["rad", "m", "m or rad", "m", "rad"]
    assert_array_equal(back.column(f"{error}_m"), np.full(len(back), 0.7))
    assert_array_equal(back.column(f"{error}_rad"), np.full(len(back), 1.2))
    assert_array_equal(back.goal_error("posture"), np.full(len(back), 1.2))
    before = {name: values for name, values in back.columns.items() if name not in columns[3:]}
    earlier = Trajectory(before, back.metadata, back.problem)
    assert kpis(earlier, *GOAL_KPIS) == kpis(back, *GOAL_KPIS) == [0.7, 0.7, 1.2, 1.2]


def test_the_reward_counts_each_unit_in_its_tolerance(folder: Path) -> None:
    made = problem(folder, "[0.5, -1.0]", "{m: 0.1, rad: 0.5}")
    environment: gymnasium.Env[Any, Any] = ScenarioEnvironment(problem=made)
    _, info = environment.reset()
    assert info["goal_error_m"] == 0.5
    assert info["goal_error_rad"] == 1.0
    assert info["goal_distance"] == pytest.approx(0.5 / 0.1)  # the larger one of 5 and 2 tolerances
    assert info["goal_tolerance"] == 1.0
    total = sum(float(environment.step(np.array([-5.0, 5.0]))[1]) for _ in range(4))
    _, _, _, _, after = environment.step(np.zeros(2))
    assert after["goal_error_m"] < 0.5
    assert total > 0.0
    environment.close()


@pytest.mark.parametrize("name", ["pd", "potential_field", "fabrics", "mpc"])
def test_planners_reach_goals_in_both_units(folder: Path, name: str) -> None:
    trajectory = run(folder, "[0.8, -1.0]", "{m: 0.02, rad: 0.05}", 12.0, planner=find_planners([name], [])[0])
    assert trajectory.outcome == "success", trajectory.metadata["message"]
    assert kpis(trajectory, "final_goal_distance_m")[0] <= 0.02


def test_a_goal_over_one_unit_keeps_its_own(folder: Path) -> None:
    (folder / "x.yaml").write_text(
        SCENARIO.format(start="[1, 2]", tolerance="{m: 0.05}", duration=1.0)
        .replace("[turn, slide]", "[slide]")
        .replace("[0.0, 0.0]", "[0.0]")
    )
    made = draw_problem(load_scenario(folder / "x.yaml"), 0)
    assert made.primary.tolerance == 0.05
    trajectory = run_trial(TrialSpecification(made.to_dict(), configuration("Still")))
    assert [value for value in kpis(trajectory, *GOAL_KPIS) if not math.isnan(value)] == [1.0, 1.0]
    assert "goal_posture_error_m" not in trajectory.columns


@pytest.mark.parametrize(
    ("tolerance", "message"),
    [
        ("{m: 0.01}", "found m; the error of this goal is in m and rad: one number, or {m: 0.01, rad: 0.05}"),
        ("{}", "found no unit; the error of this goal is in m and rad: one number, or {m: 0.01, rad: 0.05}"),
        ("{m: 0.01, rad: -1}", "goal[0].tolerance.rad: found -1; allowed: greater than 0"),
        ("{m: 0.01, deg: 3}", "goal[0].tolerance.deg: unknown key; allowed: m, rad"),
        ("[0.01, 0.05]", "goal[0].tolerance: found a list of 2; a number is required"),
    ],
)
def test_tolerances_of_other_units_are_errors(folder: Path, tolerance: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        problem(folder, "[0, 0]", tolerance)
    assert message in str(caught.value)
