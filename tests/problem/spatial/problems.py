"""Concrete problems in space that need no scenario file, with defaults that tests change."""

from collections.abc import Sequence
from typing import Any

from pytest_lpb.problem.problem import Problem

from .robots import POINT, Entry, spatial_robot


def spatial_problem_entry(
    robot: Entry = POINT,
    *,
    goal: Sequence[Entry] = (),
    obstacles: Sequence[Entry] = (),
    q: Sequence[float] | None = None,
    success: Entry | None = None,
    **environment: Any,
) -> Entry:
    """A concrete dictionary; `environment` changes the settings, the default goal is the first joint far away."""
    made = spatial_robot(robot)
    far = {"name": "far", "type": "joint", "joints": [made.joint_names[0]], "target": [50.0], "tolerance": 0.1}
    return {
        "version": 1,
        "description": "",
        "tags": [],
        "robot": made.to_dict(),
        "environment": {
            "engine": "pybullet",
            "dt": 0.05,
            "duration": 10.0,
            "end_at": ["goal", "violation"],
            "safety_margin": 0.05,
            "dynamics": False,
            "gravity": [0.0, 0.0, -9.81],
            "prediction": "constant_velocity",
            **environment,
        },
        "start": {"q": list(q or [0.0] * made.dof), "u": [0.0] * made.n_actions},
        "goal": list(goal) or [far],
        "obstacles": list(obstacles),
        "seed": 0,
        "trials": 1,
        "success": {"hold_time": 0.5, **(success or {})},
    }


def spatial_problem(robot: Entry = POINT, **changes: Any) -> Problem:
    return Problem.from_dict(spatial_problem_entry(robot, **changes), "test")


def sphere(x: float, y: float, z: float, radius: float = 0.1, name: str = "ball", **changes: Any) -> Entry:
    return {"name": name, "shape": "sphere", "radius": radius, "position": [x, y, z], **changes}
