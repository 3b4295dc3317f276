"""How deep is a collision: touching within the accuracy of the distances is none."""

from collections.abc import Callable
from math import pi

import pytest

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.problem.problem import Problem
from tests.problem.entries import POINT, circle, make_problem
from tests.problem.spatial import robots
from tests.problem.spatial.problems import spatial_problem, sphere


def in_the_plane(depth: float) -> Problem:
    """A disc of 0.2 m that goes `depth` [m] deep into another."""
    return make_problem({**POINT, "control": "velocity"}, obstacles=[circle(1.0, 0.0, 0.3)], q=[0.5 + depth, 0.0])


def in_space(depth: float) -> Problem:
    return spatial_problem(
        {**robots.POINT, "control": "velocity"}, obstacles=[sphere(1.0, 0.0, 0.0, 0.3)], q=[0.5 + depth, 0.0, 0.0]
    )


def arm_on_itself(depth: float) -> Problem:
    """An arm of capsules of 0.05 m, bent twice by 90°: its last link is back beside the first, 0.1 m - depth away."""
    arm = {
        **robots.ARM,
        "links": [0.5, 0.1 - depth, 0.4],
        "control": "velocity",
        "self_collision_pairs": [["link1", "link3"]],
    }
    return spatial_problem(arm, q=[0.0, -0.5 * pi, -0.5 * pi])


CASES = [
    (in_the_plane, 1e-9, "collision"),
    (in_space, 1e-6, "collision"),
    (arm_on_itself, 1e-6, "self_collision"),
]


@pytest.mark.parametrize(("problem", "slack", "outcome"), CASES)
def test_contact_within_the_slack_is_no_collision(
    problem: Callable[[float], Problem], slack: float, outcome: str
) -> None:
    for share in (-1.0, 0.5):
        world = ScenarioEnvironment(problem=problem(share * slack))
        assert world.monitor.violation is None
        world.close()
    world = ScenarioEnvironment(problem=problem(2.0 * slack))
    assert world.monitor.violation is not None
    assert world.monitor.violation.outcome == outcome
    assert world.running_engine.contact_slack_m == slack
    world.close()
