"""Robots, scenes and observations for tests of fabrics, made by hand: goals and obstacles may move and turn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pytest_lpb.planner.base import OBSTACLE_KEYS, GoalInfo, ObstacleInfo, PlannerProblem
from pytest_lpb.planner.fabrics.geometries import Geometries
from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.fabrics.planner import Fabrics
from pytest_lpb.planner.scene.maps import State
from pytest_lpb.problem.planar.differential_drive import drive
from pytest_lpb.problem.planar.robot import integrate_holonomic
from pytest_lpb.problem.robot import Robot
from tests.problem.spatial.robots import robot_entry

Array = NDArray[np.float64]
Entry = dict[str, Any]

TIMES = ("", "_velocity", "_acceleration")  # endings of keys
UPRIGHT = {2: 0.0, 3: [1.0, 0.0, 0.0, 0.0]}  # orientations of obstacles that are not turned, by dimension


def planar(entry: Entry, **changes: Any) -> Entry:
    """A concrete entry of a robot in the plane, without limits and own collisions unless these are given."""
    return {"control": "acceleration", "limits": {}, "self_collision_pairs": [], "collision": "geometry"} | (
        entry | changes
    )


def spatial(entry: Entry, **changes: Any) -> Entry:
    """A concrete entry of a robot in space, without limits and own collisions unless these are given."""
    return robot_entry(entry, **{"self_collision_pairs": [], **changes})


def goal(kind: str, target: ArrayLike, **entry: Any) -> Entry:
    """A sub-goal with the value, and where it moves the velocity and acceleration, of its target.

    Keys other than name, tolerance, weight, velocity and acceleration are the sub-goal's own: link, axes, ...
    """
    value = np.atleast_1d(np.array(target, dtype=float))
    known = {"name": "reach", "tolerance": 0.1, "weight": 1.0, "velocity": None, "acceleration": None}
    own = {key: entry.pop(key) for key in list(entry) if key not in known}
    return known | entry | {"type": kind, "target": value, "entry": {"type": kind, **own}}


def obstacle(shape: str, position: Sequence[float] | Array, **entry: Any) -> Entry:
    """An obstacle: its sizes, and where it moves its velocity and acceleration; `orientation` as observations say."""
    found: Entry = {"name": "thing", "shape": shape, "radius": None, "size": None, "length": None, "file": None}
    found |= {
        "scale": 1.0,
        "concave": False,
        "parameters": {},
        "moving": "velocity" in entry or "acceleration" in entry,
    }
    still = np.zeros(len(position))
    found |= {"velocity": still, "acceleration": still, "orientation": UPRIGHT[len(position)]}
    return found | {"position": position} | entry


def obstacle_info(obstacle: Entry) -> ObstacleInfo:
    """An obstacle as planners see it."""
    size = obstacle["size"]
    told = {key: obstacle[key] for key in OBSTACLE_KEYS}
    return ObstacleInfo(**(told | {"size": None if size is None else tuple(size)}))


def goal_info(goal: Entry) -> GoalInfo:
    """A sub-goal as planners see it."""
    return GoalInfo(**_told(goal))


def _told(goal: Entry) -> Entry:
    own = {key: goal[key] for key in ("name", "type", "tolerance", "weight", "entry")}
    moving = goal["velocity"] is not None or goal["acceleration"] is not None
    return own | {"link": goal["entry"].get("link"), "size": goal["target"].size, "primary": True, "moving": moving}


def problem_of(
    robot: Entry, goals: Sequence[Entry], obstacles: Sequence[Entry] = (), *, period: float = 0.05
) -> PlannerProblem:
    """What a planner is told."""
    settings = {"name": "made", "seed": 0, "dt": 0.05, "duration": 10.0, "period": period}
    told = [{key: item[key] for key in OBSTACLE_KEYS} for item in obstacles]
    return PlannerProblem({**settings, "robot": robot, "goal": [_told(item) for item in goals], "obstacles": told})


def observed(q: ArrayLike, u: ArrayLike, goals: Sequence[Entry], obstacles: Sequence[Entry] = ()) -> dict[str, Array]:
    """What a planner sees."""
    seen = {"q": np.array(q, dtype=float), "u": np.array(u, dtype=float)}
    for item in goals:
        still = np.zeros(item["target"].size)
        for key, ending in zip(("target", "velocity", "acceleration"), TIMES, strict=True):
            value = still if item[key] is None else item[key]
            seen[f"goal_{item['name']}{ending}"] = np.array(value, dtype=float).reshape(still.shape)
    for key in ("position", "velocity", "acceleration", "orientation"):
        seen[f"obstacle_{key}"] = np.array([item[key] for item in obstacles], dtype=float)
    return seen


def ready(
    robot: Entry, goals: Sequence[Entry], obstacles: Sequence[Entry] = (), *, period: float = 0.05, **parameters: Any
) -> Fabrics:
    """A new planner, set up."""
    planner = Fabrics(FabricsParameters(**parameters))
    planner.setup(problem_of(robot, goals, obstacles, period=period))
    return planner


def act(
    robot: Entry,
    q: ArrayLike,
    u: ArrayLike,
    goals: Sequence[Entry],
    obstacles: Sequence[Entry] = (),
    *,
    period: float = 0.05,
    **parameters: Any,
) -> Array:
    """The action of a new planner."""
    planner = ready(robot, goals, obstacles, period=period, **parameters)
    return planner.compute_action(observed(q, u, goals, obstacles))


def moved(robot: Robot, q: Array, w: Array, rates: Array, t: float) -> tuple[Array, Array]:
    """Exact q and inputs w after t [s], which may be negative, under constant rates of the inputs.

    The inputs of a car are (v, turn rate): it moves like a cart, and its steering angle stays.
    """
    states = (q.tolist(), w.tolist(), rates.tolist())
    if not robot.non_holonomic:
        ends = integrate_holonomic("acceleration", *states, t)
        return np.array(ends[0]), np.array(ends[1])
    arm = robot.n_actions - 2
    joints = robot.dof - arm
    base = drive("acceleration", states[0], states[1][:2], states[2][:2], t)
    rest = integrate_holonomic("acceleration", states[0][joints:], states[1][2:], states[2][2:], t)
    return np.array([*base[0], *states[0][3:joints], *rest[0]]), np.array([*base[1], *rest[1]])


def random_states(robot: Robot, seed: int, count: int) -> Iterator[tuple[Array, Array]]:
    """Configurations within the limits, and inputs of up to 0.8 rad/s or m/s, the same each time."""
    generator = np.random.default_rng(seed)
    limits = np.clip(robot.limits.position, -1.5, 1.5)
    for _ in range(count):
        yield generator.uniform(limits[:, 0], limits[:, 1]), generator.uniform(-0.8, 0.8, robot.n_actions)


def geometries_of(state: State, **parameters: Any) -> Geometries:
    """The geometries of a robot."""
    return Geometries(state, FabricsParameters(**parameters))
