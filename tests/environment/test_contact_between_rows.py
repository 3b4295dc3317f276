"""Contact between two rows: fast robots, thin obstacles, sweeping links, moving and turning obstacles."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.monitor import Violation
from pytest_lpb.problem.problem import Problem
from tests.environment.fast_motions import KINDS, verdicts
from tests.problem.entries import ARM, CART, POINT, circle, make_problem
from tests.problem.spatial import robots
from tests.problem.spatial.problems import spatial_problem

Entry = dict[str, Any]
DT = 0.1
DISC: Entry = {**POINT, "body_radius": 0.05, "control": "velocity"}
BALL: Entry = {**robots.POINT, "body_radius": 0.05, "control": "velocity"}


def wall(x: float, **changes: Any) -> Entry:
    return {"name": "wall", "shape": "rectangle", "size": [0.05, 20.0], "position": [x, 0.0], **changes}


def slab(x: float, **changes: Any) -> Entry:
    return {"name": "wall", "shape": "box", "size": [0.05, 20.0, 20.0], "position": [x, 0.0, 0.0], **changes}


def moving(entry: Entry, *trajectory: str, **changes: Any) -> Entry:
    return {
        **{key: value for key, value in entry.items() if key != "position"},
        "trajectory": list(trajectory),
        **changes,
    }


def planar(robot: Entry, obstacles: list[Entry], q: list[float] | None = None, u: Any = None) -> Problem:
    return make_problem(robot, obstacles=obstacles, q=q, u=u, dt=DT, duration=2.0)


def spatial(robot: Entry, obstacles: list[Entry], q: list[float] | None = None, **settings: Any) -> Problem:
    return spatial_problem(robot, obstacles=obstacles, q=q, dt=DT, duration=2.0, **settings)


def first_violation(problem: Problem, action: list[float]) -> Violation | None:
    """The first violation of a trial under a constant action."""
    world = ScenarioEnvironment(problem=problem)
    try:
        while not world.ended:
            world.step(action)
        return world.monitor.violation
    finally:
        world.close()


# Problem, action, outcome, names of both bodies, and the time of contact by hand [s]. At all rows bodies are apart.
AIMED = [
    # 5 m/s through walls whose faces are at 5.175 m.
    ("point", lambda: planar(DISC, [wall(5.2)]), [5.0, 0.0], "collision", ("body", "wall"), 5.125 / 5.0),
    ("point in space", lambda: spatial(BALL, [slab(5.2)]), [5.0, 0.0, 0.0], "collision", None, 5.125 / 5.0),
    # It comes to a stop beyond the wall and is back at the next row: v = 10, a = -200, face reached at x = 0.12.
    (
        "there and back",
        lambda: planar({**DISC, "control": "acceleration"}, [wall(0.195)], u=[10.0, 0.0]),
        [-200.0, 0.0],
        "collision",
        ("body", "wall"),
        0.05 - np.sqrt(0.0025 - 0.0012),
    ),
    # A wall of 9 m/s past a robot that stands: its face is 0.05 m away at x = -0.075.
    (
        "moving wall",
        lambda: planar(DISC, [moving(wall(0.0), "-1.0 + 9.0*t", "0")]),
        [0.0, 0.0],
        "collision",
        ("body", "wall"),
        0.925 / 9.0,
    ),
    (
        "moving wall in space",
        lambda: spatial(BALL, [moving(slab(0.0), "-1.0 + 9.0*t", "0", "0")]),
        [0.0, 0.0, 0.0],
        "collision",
        None,
        0.925 / 9.0,
    ),
    # A bar that turns by 20 rad/s about its middle, over a disc 1 m away: it lies over the disc at a quarter turn.
    (
        "turning bar",
        lambda: planar(
            {**DISC, "body_radius": 0.01},
            [{"name": "bar", "shape": "rectangle", "size": [2.4, 0.02], "position": [0.0, 0.0], "orientation": "20*t"}],
            q=[0.0, 1.0],
        ),
        [0.0, 0.0],
        "collision",
        ("body", "bar"),
        (0.5 * pi - np.arcsin(0.02)) / 20.0,
    ),
    (
        "turning bar in space",
        lambda: spatial(
            {**BALL, "body_radius": 0.01},
            [
                {
                    "name": "bar",
                    "shape": "box",
                    "size": [2.4, 0.02, 0.02],
                    "position": [0.0, 0.0, 0.0],
                    "orientation": {"axis": [0.0, 0.0, 1.0], "angle": "20*t"},
                }
            ],
            q=[0.0, 1.0, 0.0],
        ),
        [0.0, 0.0, 0.0],
        "collision",
        None,
        (0.5 * pi - np.arcsin(0.02)) / 20.0,
    ),
    # A link of 1 m that turns by 15 rad/s over a post at a quarter turn.
    (
        "sweeping link",
        lambda: planar(
            {**ARM, "links": [1.0], "body_radius": 0.01, "control": "velocity"}, [circle(0.0, 0.5, 0.01, "post")]
        ),
        [15.0],
        "collision",
        ("link1", "post"),
        (0.5 * pi - np.arcsin(0.04)) / 15.0,
    ),
    (
        "cart on an arc",
        lambda: planar({**CART, "body_radius": 0.02, "control": "velocity"}, [circle(1.0, 1.0, 0.02, "post")]),
        [20.0, 20.0],
        "collision",
        ("base", "post"),
        (0.5 * pi - 2.0 * np.arcsin(0.02)) / 20.0,
    ),
]


@pytest.mark.parametrize(
    ("problem", "action", "outcome", "names", "time"), [c[1:] for c in AIMED], ids=[c[0] for c in AIMED]
)
def test_contact_between_rows_is_found_when_it_happens(
    problem: Any, action: list[float], outcome: str, names: tuple[str, str] | None, time: float
) -> None:
    made = problem()
    violation = first_violation(made, action)
    assert violation is not None
    assert violation.outcome == outcome
    assert violation.time == pytest.approx(time, abs=1e-3 * DT)
    assert violation.clearance[0] > 0.0, "it was to be free again at the next row"
    assert violation.row == int(np.ceil(time / DT))
    if names is not None:
        assert violation.clearance[1:] == names


@pytest.mark.parametrize("dimension", [2, 3])
def test_links_that_pass_through_each_other_have_collided(dimension: int) -> None:
    """The third of three links swings through the first and past its end within one step."""
    changes: Entry = {"links": [1.0, 0.5, 1.0], "body_radius": 0.01, "control": "velocity"}
    changes["self_collision_pairs"] = [["link1", "link3"]]
    q = [0.0, 0.5 * pi, 0.5 * pi]
    problem = planar({**ARM, **changes}, [], q=q) if dimension == 2 else spatial({**robots.ARM, **changes}, [], q=q)
    violation = first_violation(problem, [0.0, 0.0, 18.0])
    assert violation is not None
    assert violation.outcome == "self_collision"
    assert violation.clearance[1:] == ("link1", "link3")
    assert violation.clearance[0] > 0.0
    if dimension == 2:
        assert violation.time == pytest.approx(np.arcsin(0.48) / 18.0, abs=1e-3 * DT)


@pytest.mark.parametrize("kind", KINDS)
def test_fast_motions_past_thin_obstacles(kind: str) -> None:
    """None of many random motions passes through unseen, and none is called a contact that is none.

    `python -m tests.environment.fast_motions 1000000` judges a million.
    """
    found = verdicts(kind, 100, seed=1)
    assert found["hit between rows"] > 5
    assert found["free"] > 5
