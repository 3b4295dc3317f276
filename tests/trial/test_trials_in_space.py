"""What is recorded of a trial in space: columns, their units, and the problem that repeats it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.problem.spatial.rotations import from_axis_angle
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.files import read_trial, write_trial
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import failed_trial, run_trial
from pytest_lpb.trial.units import unit_of
from tests.problem.spatial import robots
from tests.problem.spatial.problems import spatial_problem, spatial_problem_entry, sphere

from .specifications import configuration, same_columns

GOAL: list[robots.Entry] = [
    {"name": "reach", "type": "position", "link": "base", "target": [2.0, 0.0, 0.0], "tolerance": 0.1},
    {"name": "aim", "type": "position", "link": "base", "target": [0.5], "axes": [2]},
    {"name": "turn", "type": "orientation", "link": "base", "target": [1.0, 0.0, 0.0, 1.0], "tolerance": 0.1},
]
FAN: robots.Entry = {
    "name": "fan.1",
    "shape": "box",
    "size": [0.1, 0.2, 0.3],
    "trajectory": ["3 - t", "1.5", "t"],
    "orientation": {"axis": [0.0, 1.0, 0.0], "angle": "2*t"},
}


def specification() -> TrialSpecification:
    """A cart that is asked for (t + 1, -1) at each step, its speeds limited."""
    cart = {**robots.CART, "limits": {"velocity": [[-1.0, 1.0], [-2.0, 2.0]]}}
    problem = spatial_problem_entry(cart, goal=GOAL, obstacles=[sphere(0.1, 5.0, 1.0), FAN], duration=1.0)
    return TrialSpecification(problem=problem, planner=configuration("Clock"), scenario="family")


@dataclass(frozen=True)
class Written:
    """A trial and its file."""

    trajectory: Trajectory
    path: Path


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Written:
    trajectory = run_trial(specification())
    return Written(trajectory, write_trial(tmp_path_factory.mktemp("run"), trajectory))


def test_the_columns_of_the_contract(written: Written) -> None:
    expected = ["t", "q0", "q1", "q2", "qd0", "qd1", "qd2", "u0", "u1", "action0", "action1", "applied0", "applied1"]
    expected += ["link_base_x", "link_base_y", "link_base_z"]
    expected += ["goal_reach_0", "goal_reach_1", "goal_reach_2", "goal_reach_error", "goal_aim_0", "goal_aim_error"]
    expected += [*(f"goal_turn_{index}" for index in range(4)), "goal_turn_error"]
    parts = ("x", "y", "z", "qw", "qx", "qy", "qz")
    expected += [f"obstacle_{name}_{part}" for name in ("ball", "fan.1") for part in parts]
    expected += ["clearance_m", "clearance_body", "clearance_obstacle", "self_clearance_m"]
    expected += ["clearance_step_min_m", "self_clearance_step_min_m"]
    expected += ["solver_wall_ms", "solver_cpu_ms", "planner_calls", "planner_odd"]
    assert pq.read_table(written.path).column_names == expected


def test_obstacles_are_where_they_were(written: Written) -> None:
    trial = written.trajectory
    assert len(trial) == 21
    turns = np.column_stack([trial.column(f"obstacle_fan.1_q{letter}") for letter in "wxyz"])
    assert_allclose(turns, [from_axis_angle([0.0, 1.0, 0.0], 2.0 * t) for t in trial.t], atol=1e-15)
    assert_allclose(trial.obstacle("fan.1"), np.column_stack([3.0 - trial.t, np.full(21, 1.5), trial.t]))
    still = np.column_stack([trial.column(f"obstacle_ball_q{letter}") for letter in "wxyz"])
    assert_array_equal(still, [[1.0, 0.0, 0.0, 0.0]] * 21)
    assert_array_equal(trial.obstacle("ball"), [[0.1, 5.0, 1.0]] * 21)


def test_links_and_goals_follow_the_joints(written: Written) -> None:
    trial = written.trajectory
    assert_allclose(trial.link("base")[:, :2], trial.q[:, :2], atol=1e-15)
    assert not trial.link("base")[:, 2].any()
    assert_allclose(trial.goal_error("reach"), np.linalg.norm(trial.link("base") - [2.0, 0.0, 0.0], axis=1))
    assert_array_equal(trial.goal_error("aim"), np.full(21, 0.5))
    assert trial.q[-1, 0] > 0.1


UNITS = {
    "t": "s",
    "q0": "m",
    "q2": "rad",
    "qd1": "m/s",
    "qd2": "rad/s",
    "u0": "m/s",
    "u1": "rad/s",
    "action0": "m/s^2",
    "applied1": "rad/s^2",
    "link_base_z": "m",
    "goal_reach_2": "m",
    "goal_reach_error": "m",
    **{f"goal_turn_{index}": "" for index in range(4)},
    "goal_turn_error": "rad",
    "obstacle_fan.1_z": "m",
    **{f"obstacle_fan.1_q{letter}": "" for letter in "wxyz"},
    "clearance_m": "m",
    "clearance_body": "",
    "solver_wall_ms": "ms",
    "planner_calls": "",
}


def test_units_are_in_the_file(written: Written) -> None:
    schema = pq.read_schema(written.path)
    found = {name: schema.field(name).metadata[b"unit"].decode() for name in UNITS}
    assert found == UNITS


@pytest.mark.parametrize(
    ("robot", "control", "units"),
    [
        (robots.POINT, "velocity", ["m/s", "m/s", "m/s"]),
        (robots.ARM, "velocity", ["rad/s"] * 3),
        (robots.ARM, "acceleration", ["rad/s^2"] * 3),
        (robots.ARM, "torque", ["N m"] * 3),
        (robots.POINT, "torque", ["N"] * 3),
        (robots.CAR, "acceleration", ["m/s^2", "rad/s^2"]),
        ({**robots.MOUNTED, "base": "holonomic"}, "torque", ["N", "N", "N m", *["N m"] * 7]),
        ({**robots.MOUNTED, "base": "differential_drive", "wheel_base": 0.5}, "velocity", ["m/s", *["rad/s"] * 8]),
        ({**robots.PANDA, "joints": ["panda_joint1", "panda_finger_joint1"]}, "torque", ["N m", "N"]),
    ],
)
def test_units_of_actions_follow_robot_and_control(robot: robots.Entry, control: str, units: list[str]) -> None:
    problem = spatial_problem({**robot, "control": control})
    for column in ("action", "applied"):
        assert [unit_of(f"{column}{index}", problem) for index in range(len(units))] == units
    rates = [unit_of(f"u{index}", problem) for index in range(problem.robot.n_actions)]
    assert set(rates) <= {"m/s", "rad/s"}
    assert len(rates) == len(units)


def test_round_trip_and_repeat(written: Written) -> None:
    again = read_trial(written.path)
    assert same_columns(again, written.trajectory)
    assert again.problem.problem_hash == written.trajectory.problem.problem_hash
    assert same_columns(run_trial(specification()), written.trajectory)


def test_a_trial_without_rows_has_the_same_columns(written: Written) -> None:
    lost = failed_trial(specification(), "worker_crash", "died")
    assert len(lost) == 0
    recorded = [name for name in written.trajectory.columns if not name.startswith("planner_")]
    assert list(lost.columns) == recorded
