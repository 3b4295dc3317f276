"""Problems for planners, and observations of them, made by hand."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.planner.base import Planner, PlannerProblem
from pytest_lpb.problem.problem import Problem

Array = NDArray[np.float64]
Entry = dict[str, Any]

POINT: Entry = {"model": "point", "name": "point", "base": "fixed", "body_radius": 0.2}
CART: Entry = {
    "model": "differential_drive",
    "name": "differential_drive",
    "base": "differential_drive",
    "body_radius": 0.2,
    "wheel_base": 0.4,
}


def arm(*links: float) -> Entry:
    """A planar arm with links of these lengths [m]."""
    name = f"planar_arm_{len(links)}"
    return {"model": "planar_arm", "name": name, "base": "fixed", "body_radius": 0.05, "links": list(links)}


def reach(link: str, *target: float, **others: Any) -> Entry:
    """A position sub-goal called reach."""
    return {"name": "reach", "type": "position", "link": link, "target": list(target), "tolerance": 0.1, **others}


def circle(x: float, y: float, radius: float) -> Entry:
    """A disc at rest."""
    return {"name": f"disc{x:g}_{y:g}", "shape": "circle", "radius": radius, "position": [x, y], "orientation": 0.0}


def rectangle(x: float, y: float, width: float, height: float, angle: float) -> Entry:
    """A rectangle at rest, turned by an angle [rad]."""
    return {
        "name": "box",
        "shape": "rectangle",
        "size": [width, height],
        "position": [x, y],
        "orientation": angle,
    }


def problem_of(
    robot: Entry,
    goal: Sequence[Entry],
    obstacles: Sequence[Entry] = (),
    *,
    control: str = "acceleration",
    limits: Mapping[str, Any] | None = None,
    dt: float = 0.05,
    period: float | None = None,
) -> PlannerProblem:
    """What a planner is told."""
    velocity_key, size = ("u", 3) if robot is CART else ("qd", len(robot.get("links", (0, 0))))
    settings = {
        "engine": "planar",
        "dt": dt,
        "duration": 10.0,
        "end_at": ["goal", "violation"],
        "safety_margin": 0.05,
        "prediction": "constant_velocity",
    }
    entry = {
        "seed": 0,
        "robot": {"control": control, "limits": dict(limits or {}), **robot},
        "environment": settings,
        "start": {"q": [0.0] * size, velocity_key: [0.0] * (2 if robot is CART else size)},
        "goal": [{"weight": 1.0, "primary": index == 0, **item} for index, item in enumerate(goal)],
        "obstacles": list(obstacles),
        "success": {"hold_time": 0.5},
    }
    return PlannerProblem.of(Problem.from_dict(entry, "made"), dt if period is None else period)


def observed(
    problem: PlannerProblem,
    q: Sequence[float] | Array,
    u: Sequence[float] | Array | None = None,
    *,
    targets: Mapping[str, Any] | None = None,
    velocities: Mapping[str, Any] | None = None,
    obstacles: Sequence[Entry] = (),
) -> dict[str, Array]:
    """An observation; targets are zero unless given by the sub-goal's name."""
    q = np.array(q, dtype=float)
    u = np.zeros(problem.robot.n_actions) if u is None else np.array(u, dtype=float)
    observation = {"t": np.array(0.0), "q": q, "qd": problem.robot.action_map(q) @ u, "u": u}
    for goal in problem.goal:
        observation[f"goal_{goal.name}"] = np.array((targets or {}).get(goal.name, [0.0] * goal.size), dtype=float)
        velocity = (velocities or {}).get(goal.name, [0.0] * goal.size)
        observation[f"goal_{goal.name}_velocity"] = np.array(velocity, dtype=float)
        if goal.primary:
            observation["goal_position"] = observation[f"goal_{goal.name}"]
    observation["obstacle_position"] = np.array([o["position"] for o in obstacles], dtype=float).reshape(-1, 2)
    observation["obstacle_orientation"] = np.array([o["orientation"] for o in obstacles], dtype=float)
    return observation


def ready(planner: Planner, problem: PlannerProblem) -> Planner:
    """The planner, set up."""
    planner.setup(problem)
    return planner
