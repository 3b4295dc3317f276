"""Recorded observations made again: deterministic planners compute the recorded actions to the last bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_lpb.errors import PlannerError
from pytest_lpb.planner.base import FloatArray, Observation, Planner
from pytest_lpb.planner.class_here import ClassHere
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import find_planners
from pytest_lpb.problem.hashing import copied
from pytest_lpb.problem.preview import Preview
from pytest_lpb.retime.passes import Pass, checked
from pytest_lpb.retime.replay import Replay
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.files import read_trial, write_trial
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import circle, problem_entry
from tests.trial.specifications import configuration

SCENARIOS = Path(__file__).parents[2] / "scenarios"
SHIPPED = {planner.name: planner for planner in find_planners(["pd", "potential_field", "fabrics", "mpc"], [])}


def recorded(entry: dict[str, Any], planner: PlannerConfiguration, folder: Path) -> Trajectory:
    """A trial as it is read from its file."""
    return read_trial(write_trial(folder, run_trial(TrialSpecification(entry, planner, "family"))))


def replayed(trajectory: Trajectory, planner: PlannerConfiguration) -> Replay:
    """The trial's replay; fails unless the actions are those recorded."""
    replay = Replay(trajectory, planner)
    check = checked(planner.build(), [replay], "it")
    assert check.warnings == []
    assert check.kept == [replay]
    assert len(check.first_calls_ms) == 1
    return replay


@pytest.mark.parametrize(
    "scenario", ["point/crossing_traffic", "differential_drive/crossing_traffic", "panda/tracking"]
)
@pytest.mark.parametrize("name", ["pd", "potential_field", "fabrics", "mpc"])
def test_actions_are_those_recorded(name: str, scenario: str, tmp_path: Path) -> None:
    planner = SHIPPED[name]
    entry = copied(draw_problem(load_scenario(SCENARIOS / f"{scenario}.yaml"), 0).to_dict())
    entry["environment"] |= {"duration": 2.0, "end_at": []}
    trajectory = recorded(entry, planner, tmp_path)
    replay = replayed(trajectory, planner)
    every = planner.steps_per_call(trajectory.problem.dt)
    assert replay.rows == list(range(0, len(trajectory) - 1, every))
    assert all(replay.recorded_action(row) is not None for row in replay.rows)


class Mirror(Planner):
    """Remembers copies of all it saw; its actions depend on the whole of it, and on what it saw before."""

    preview = Preview(steps=3, step_s=0.2)

    def setup(self, problem: Any) -> None:
        self.seen: list[dict[str, FloatArray]] = []

    def compute_action(self, observation: Observation) -> FloatArray:
        self.seen.append({key: np.array(value) for key, value in observation.items()})
        self.diagnostics["calls"] = float(len(self.seen))
        total = sum(float(np.sum(value)) for seen in self.seen for value in seen.values())
        return np.array([np.sin(total), np.cos(total)])


MIRROR = "tests.retime.test_replay:Mirror"
MOVING: dict[str, Any] = {
    "goal": [
        {"name": "follow", "type": "position", "link": "body", "trajectory": ["3 + sin(t)", "cos(t)"], "tolerance": 0.1}
    ],
    "obstacles": [
        {"name": "cart", "shape": "circle", "radius": 0.2, "trajectory": ["5 + 0.3*t", "0.5*sin(t)"]},
        circle(-9.0, 0.0, 0.5),
    ],
    "duration": 40.0,  # past the first block of rows of moving things
    "dt": 0.05,
    "end_at": [],
}


@pytest.mark.parametrize("prediction", ["none", "constant_velocity", "exact"])
def test_observations_are_equal_to_the_last_bit(prediction: str, tmp_path: Path) -> None:
    planner = PlannerConfiguration("mirror", MIRROR)
    seen: list[dict[str, FloatArray]] = []

    class Kept(Mirror):
        def compute_action(self, observation: Observation) -> FloatArray:
            action = super().compute_action(observation)
            seen.append(self.seen[-1])
            self.seen = self.seen[-1:]
            return action

    definition = ClassHere(planner.planner)
    definition.cls = Kept
    planner.__dict__["definition"] = definition
    trajectory = recorded(problem_entry(**MOVING, prediction=prediction), planner, tmp_path)
    replay = Replay(trajectory, planner)
    again = [{key: value.copy() for key, value in observation.items()} for observation in replay.observations()]
    assert len(again) == len(seen) == 800
    for then, now in zip(seen, again, strict=True):
        assert list(then) == list(now)
        assert all(then[key].tobytes() == now[key].tobytes() for key in then)


@pytest.mark.parametrize(("period", "delay"), [(None, 0.0), (0.1, 0.0), (0.15, 0.05), (None, 0.2)])
def test_only_calls_that_were_made(period: float | None, delay: float, tmp_path: Path) -> None:
    planner = PlannerConfiguration("mirror", MIRROR, period=period, delay=delay)
    entry = problem_entry(**{**MOVING, "duration": 2.0})
    trajectory = recorded(entry, planner, tmp_path)
    replay = replayed(trajectory, planner)
    step = planner.steps_per_call(0.05)
    assert replay.rows == list(range(0, 40, step))
    assert replay.period_ms == pytest.approx(50.0 * step)
    # The last calls of a trial with delay never act.
    acted = [row for row in replay.rows if replay.recorded_action(row) is not None]
    assert acted == [row for row in replay.rows if row + round(delay / 0.05) < 40]


def test_other_actions_are_told(tmp_path: Path) -> None:
    trajectory = recorded(problem_entry(), SHIPPED["pd"], tmp_path)
    other = PlannerConfiguration("pd", "pd", {"p": 1.0 + 1e-15, "k": 2.0})
    check = checked(other.build(), [Replay(trajectory, other)], "pd in s")
    assert check.different == 1
    assert "actions differ from the recorded ones in" in check.warnings[0]
    assert len(check.kept) == 1  # its calls can be timed all the same


def test_a_call_that_raised_is_none(tmp_path: Path) -> None:
    infeasible = configuration("Faulty", {"fault": "infeasible"})
    trajectory = recorded(problem_entry(), infeasible, tmp_path)
    assert trajectory.outcome == "infeasible"
    replay = replayed(trajectory, infeasible)
    called = np.flatnonzero(~np.isnan(trajectory.solver_wall_ms)).tolist()
    assert replay.rows == called[:-1]


def test_a_planner_that_raises_now_is_left_out(tmp_path: Path) -> None:
    trajectory = recorded(problem_entry(), configuration("Still"), tmp_path)
    broken = configuration("Faulty", {"fault": "infeasible"})
    check = checked(broken.build(), [Replay(trajectory, broken)], "it")
    assert check.kept == []
    assert check.warnings[0].startswith("it, seed 0 is left out: the planner raised ")


def test_no_action_is_an_error_of_the_planner(tmp_path: Path) -> None:
    replay = Replay(recorded(problem_entry(), configuration("Still"), tmp_path), configuration("Still"))
    assert replay.is_recorded(0, np.zeros(2))
    assert not replay.is_recorded(0, np.array([0.0, 1e-300]))
    with pytest.raises(PlannerError):
        replay.is_recorded(0, np.zeros(3))


def test_a_pass_sets_up_before_each_trial_and_keeps_the_first_call_apart(tmp_path: Path) -> None:
    planner = PlannerConfiguration("mirror", MIRROR, period=0.1)
    entry = problem_entry(**{**MOVING, "duration": 0.5})
    replays = [Replay(recorded(entry | {"seed": seed}, planner, tmp_path), planner) for seed in (0, 1)]
    mirror = planner.build()
    assert isinstance(mirror, Mirror)
    made = Pass(mirror, replays)
    assert made.rounds == 8  # two trials of five calls, but for the first ones
    times = []
    for _ in range(made.rounds):
        (seen,), keywords = made.next_observation()
        assert keywords == {}
        assert mirror.diagnostics == {}
        times.append(float(seen["t"]))
        mirror.compute_action(seen)
    assert times == pytest.approx([0.1, 0.2, 0.3, 0.4] * 2)
    assert len(made.first_calls_ms) == 2
    assert len(mirror.seen) == 5  # set up again before the second trial
