"""What release 0.10.0 of the reference implementation did, and problems of the states it did it in."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path

from pytest_lpb.planner.base import Observation, PlannerProblem
from tests.planner import problems
from tests.planner.scene.making import Entry, goal, observed, obstacle, planar, problem_of, spatial
from tests.problem.spatial.robots import PANDA

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
    spheres = {link: [[0.0, 0.0, row[key][0]]] for link, key in (("link3", "radius_body_2"), ("end", "radius_body_3"))}
    limits = {"position": [[-3.14, 3.14]] * 3}
    return planar(problems.arm(1.0, 1.0, 1.0), collision={"spheres": spheres}, limits=limits)


def panda(row: Entry) -> Entry:
    spheres = {f"panda_link{i}": [[0.0, 0.0, 0.0, row[f"radius_body_panda_link{i}"][0]]] for i in range(3, 9)}
    return spatial(PANDA, collision={"spheres": spheres}, limits={"position": PANDA_LIMITS})


# How a row's robot is made, and the link that is to reach the goal.
KINDS: dict[str, tuple[Callable[[Entry], Entry], str]] = {
    "point": (point, "body"),
    "planar_arm_3": (arm, "end"),
    "panda": (panda, "panda_link8"),
}


@cache
def _table() -> dict[str, list[Entry]]:
    path = Path(__file__).with_name("fabrics_0_10_0_actions.json")
    table: dict[str, list[Entry]] = json.loads(path.read_text(encoding="utf-8"))
    return table


def rows_of(kind: str) -> list[Entry]:
    """All states of a robot of `KINDS`, not to be changed; `action` is what the reference implementation did."""
    return _table()[kind]


def _scene(row: Entry, link: str) -> tuple[list[Entry], list[Entry]]:
    """Goal and obstacles of a row."""
    names = [key.removeprefix("x_") for key in row if key.startswith("x_obst_")]
    shape = {2: "circle", 3: "sphere"}[len(row["x_goal_0"])]
    obstacles = [obstacle(shape, row[f"x_{name}"], radius=row[f"radius_{name}"][0], name=name) for name in names]
    return [goal("position", row["x_goal_0"], link=link, weight=row["weight_goal_0"][0])], obstacles


def problem_of_row(kind: str, row: Entry) -> PlannerProblem:
    """The problem that a robot of `KINDS` has in a row."""
    made, link = KINDS[kind]
    return problem_of(made(row), *_scene(row, link))


def observation_of(row: Entry) -> Observation:
    """What a planner sees in a row."""
    return observed(row["q"], row["qdot"], *_scene(row, ""))
