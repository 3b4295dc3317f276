"""A planner that looks reacts to a scene that is moved; one that does not look, or remembers, does not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_lpb.fairness.canary import reactions
from pytest_lpb.planner.base import Observation, Planner, PlannerProblem
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import find_planners
from pytest_lpb.problem.preview import Preview
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.trial.holder import PlannerHolder
from tests.problem.entries import ARM, circle, make_problem, position_goal

SCENARIOS = Path(__file__).parents[2] / "scenarios"


class LooksAtBoth(Planner):
    def compute_action(self, observation: Observation) -> Any:
        return observation["goal_position"] + observation["obstacle_position"].sum(axis=0)


class LooksAtGoal(Planner):
    def compute_action(self, observation: Observation) -> Any:
        return np.sign(observation["goal_position"])  # at its limits: only the far side changes it


class LooksAtObstacles(Planner):
    def compute_action(self, observation: Observation) -> Any:
        return observation["obstacle_position"].sum(axis=0)


class LooksAhead(Planner):
    preview = Preview(steps=2, step_s=0.5)

    def compute_action(self, observation: Observation) -> Any:
        return observation["obstacle_position_preview"].sum(axis=(0, 1)) + observation["goal_reach_preview"].sum(axis=0)


class LooksNowhere(Planner):
    def compute_action(self, observation: Observation) -> Any:
        return np.ones(2)


class Remembers(Planner):
    seen: Observation | None = None

    def compute_action(self, observation: Observation) -> Any:
        self.seen = self.seen or dict(observation)
        return self.seen["goal_position"] + self.seen["obstacle_position"].sum(axis=0)


class RemembersAcross(Remembers):
    """As one that caches by what it was told, which is the same in each scene."""

    def setup(self, problem: PlannerProblem) -> None:
        self.seen = self.seen if getattr(self, "name_of_problem", None) == problem.name else None
        self.name_of_problem = problem.name


class Dice(Planner):
    def compute_action(self, observation: Observation) -> Any:
        return np.random.default_rng().uniform(size=2)


class FailsClose(Planner):
    def compute_action(self, observation: Observation) -> Any:
        if np.linalg.norm(observation["obstacle_position"] - observation["q"], axis=1).min() < 1.0:
            raise ValueError("too close")
        return np.zeros(2)


class Fails(Planner):
    def compute_action(self, observation: Observation) -> Any:
        raise SystemExit(1)


def reacted(planner: type[Planner] | PlannerConfiguration, problem: Problem) -> tuple[Any, Any]:
    """What a planner reacts to: the goal, obstacles."""
    if isinstance(planner, type):
        planner = PlannerConfiguration(name="tested", planner=f"{__name__}:{planner.__name__}")
    holder = PlannerHolder(planner)
    try:
        found = reactions(holder, planner, problem)
    finally:
        holder.close()
    return found["goal"], found["obstacles"]


@pytest.mark.parametrize(
    ("planner", "expected"),
    [
        (LooksAtBoth, (True, True)),
        (LooksAtGoal, (True, False)),
        (LooksAtObstacles, (False, True)),
        (LooksAhead, (True, True)),
        (LooksNowhere, (False, False)),
        (Remembers, (False, False)),
        (RemembersAcross, (False, False)),
        (Dice, (None, None)),
        (FailsClose, (False, True)),
        (Fails, (None, None)),
    ],
)
def test_reactions(planner: type[Planner], expected: tuple[Any, Any]) -> None:
    problem = make_problem(goal=[position_goal([4.0, 0.2], name="reach")], obstacles=[circle(2.0, 0.3, 0.1)])
    assert reacted(planner, problem) == expected


def test_nothing_to_move() -> None:
    assert reacted(LooksAtGoal, make_problem()) == (True, None)
    upright = {"name": "up", "type": "alignment", "link": "end", "axis": [1, 0], "other_axis": [0, 1], "tolerance": 0.1}
    problem = make_problem(ARM, goal=[upright])
    assert reacted(LooksNowhere, problem)[0] is None


@pytest.mark.parametrize("planner", ["fabrics", "mpc", "potential_field"])
@pytest.mark.parametrize("scenario", ["point/two_circles", "planar_arm/two_links", "panda/one_sphere"])
def test_shipped_planners_look(planner: str, scenario: str) -> None:
    loaded = load_scenario(SCENARIOS / f"{scenario}.yaml")
    (configuration,) = find_planners([planner], [])
    problem = draw_problem(loaded, 0, (), scenario)
    assert reacted(configuration, problem) == (True, True if problem.obstacles else None)
