"""Concrete problems, as `Problem.from_dict` reads them, with defaults that tests change."""

from collections.abc import Sequence
from typing import Any

from pytest_lpb.problem.planar.robot import PlanarRobot
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import robot_from

Entry = dict[str, Any]

POINT: Entry = {"model": "point", "name": "point", "base": "fixed", "body_radius": 0.2}
ARM: Entry = {"model": "planar_arm", "name": "arm", "links": [1.0, 0.5, 0.8], "base": "fixed", "body_radius": 0.05}
CART: Entry = {
    "model": "differential_drive",
    "name": "differential_drive",
    "base": "differential_drive",
    "wheel_base": 0.5,
    "body_radius": 0.2,
}
SIZES = {"point": 2, "differential_drive": 3}


def robot_entry(robot: Entry, **changes: Any) -> Entry:
    return {"control": "acceleration", "limits": {}, "self_collision_pairs": None, **robot, **changes}


def make_robot(robot: Entry, **changes: Any) -> PlanarRobot:
    made = robot_from(robot_entry(robot, **changes))
    assert isinstance(made, PlanarRobot)
    return made


def problem_entry(
    robot: Entry = POINT,
    *,
    goal: Sequence[Entry] = (),
    obstacles: Sequence[Entry] = (),
    q: Sequence[float] | None = None,
    u: Sequence[float] | None = None,
    success: Entry | None = None,
    seed: int = 0,
    **environment: Any,
) -> Entry:
    """A concrete dictionary; `environment` changes the settings, the default goal is far away."""
    robot = robot_entry(robot)
    dof = SIZES.get(robot["model"]) or len(robot["links"])
    actions = 2 if robot["model"] == "differential_drive" else dof
    link = {"point": "body", "planar_arm": "end", "differential_drive": "base"}[robot["model"]]
    far = {"name": "far", "type": "position", "link": link, "target": [50.0, 0.0], "tolerance": 0.1}
    return {
        "version": 1,
        "description": "",
        "tags": [],
        "robot": robot,
        "environment": {
            "engine": "planar",
            "dt": 0.05,
            "duration": 1.0,
            "end_at": ["goal", "violation"],
            "safety_margin": 0.05,
            "dynamics": False,
            "gravity": [0.0, 0.0, -9.81],
            "prediction": "constant_velocity",
            **environment,
        },
        "start": {"q": list(q or [0.0] * dof), ("u" if actions < dof else "qd"): list(u or [0.0] * actions)},
        "goal": [dict(entry) for entry in goal or [far]],
        "obstacles": [{"orientation": 0.0, **entry} for entry in obstacles],
        "seed": seed,
        "trials": 1,
        "success": {"hold_time": 0.5, **(success or {})},
    }


def make_problem(robot: Entry = POINT, **changes: Any) -> Problem:
    return Problem.from_dict(problem_entry(robot, **changes), "test")


def position_goal(target: Sequence[float], link: str = "body", **changes: Any) -> Entry:
    entry = {"name": "reach", "type": "position", "link": link, "target": list(target), "tolerance": 0.1}
    return {**entry, **changes}


def circle(x: float, y: float, radius: float, name: str = "disc", **changes: Any) -> Entry:
    return {"name": name, "shape": "circle", "radius": radius, "position": [x, y], **changes}
