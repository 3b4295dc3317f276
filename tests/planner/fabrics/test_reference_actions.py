"""Actions that release 0.10.0 of the reference implementation printed, from the states it printed them for."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.planner import problems
from tests.problem.spatial.robots import PANDA

from .making import Array, Entry, act, goal, obstacle, planar, spatial

ROWS: dict[str, list[Entry]] = json.loads(
    Path(__file__).with_name("fabrics_0_10_0_actions.json").read_text(encoding="utf-8")
)
PANDA_LIMITS = [
    [-2.8973, 2.8973],
    [-1.7628, 1.7628],
    [-2.8973, 2.8973],
    [-3.0718, 0.0698],
    [-2.8973, 2.8973],
    [-0.0175, 3.7525],
    [-2.8973, 2.8973],
]


def point(row: Entry) -> Entry:
    return planar(problems.POINT, body_radius=row["radius_body_1"][0], limits={"position": [[-5.0, 5.0]] * 2})


def arm(row: Entry) -> Entry:
    # Spheres at the ends of links 2 and 3. The end of link 2 is where link 3 begins.
    spheres = {link: [[0.0, 0.0, row[f"radius_{name}"][0]]] for link, name in ARM_SPHERES.items()}
    limits = {"position": [[-3.14, 3.14]] * 3}
    return planar(problems.arm(1.0, 1.0, 1.0), collision={"spheres": spheres}, limits=limits)


def panda(row: Entry) -> Entry:
    spheres = {f"panda_link{i}": [[0.0, 0.0, 0.0, row[f"radius_body_panda_link{i}"][0]]] for i in range(3, 9)}
    return spatial(PANDA, collision={"spheres": spheres}, limits={"position": PANDA_LIMITS})


ARM_SPHERES = {"link3": "body_2", "end": "body_3"}
# How a row's robot is made, the link that is to reach the goal, the shape of its obstacles.
KINDS: dict[str, tuple[Callable[[Entry], Entry], str, str]] = {
    "point": (point, "body", "circle"),
    "planar_arm_3": (arm, "end", "circle"),
    "panda": (panda, "panda_link8", "sphere"),
}
CASES = [(kind, index) for kind, rows in ROWS.items() for index in range(len(rows))]


def action(kind: str, row: Entry, **parameters: Any) -> Array:
    made, link, shape = KINDS[kind]
    goals = [goal("position", row["x_goal_0"], link=link, weight=row["weight_goal_0"][0])]
    names = [key.removeprefix("x_") for key in row if key.startswith("x_obst_")]
    obstacles = [obstacle(shape, row[f"x_{name}"], radius=row[f"radius_{name}"][0], name=name) for name in names]
    return act(made(row), row["q"], row["qdot"], goals, obstacles, **parameters)


def test_the_table_has_twelve_states_of_each_robot() -> None:
    assert {kind: len(rows) for kind, rows in ROWS.items()} == dict.fromkeys(KINDS, 12)


@pytest.mark.parametrize(("kind", "index"), CASES)
def test_actions_are_those_of_the_reference_release(kind: str, index: int) -> None:
    row = ROWS[kind][index]
    assert action(kind, row, curvature_term="reference") == pytest.approx(row["action"], rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_with_the_sign_of_the_theory_actions_differ(kind: str) -> None:
    # Also those of a point: its place has no curvature, its distances from discs have.
    differences = [np.abs(action(kind, row, curvature_term="theory") - row["action"]).max() for row in ROWS[kind]]
    assert max(differences) > 0.1


@pytest.mark.parametrize(("velocity", "agree"), [([0.6, 0.0], True), ([0.0, 0.6], False)])
def test_signs_agree_where_a_point_moves_straight_at_a_disc(velocity: list[float], agree: bool) -> None:
    robot, goals = planar(problems.POINT), [goal("position", [2, 1], link="body")]
    disc = obstacle("circle", [1.0, 0.0], radius=0.3)
    theory, reference = (
        act(robot, [0, 0], velocity, goals, [disc], curvature_term=sign) for sign in ("theory", "reference")
    )
    assert np.allclose(theory, reference, rtol=0.0, atol=1e-12) is agree
