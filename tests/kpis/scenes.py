"""Smooth motions that can be sampled at any step and placed anywhere in the plane."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, inf, sin
from typing import Any

import numpy as np

from pytest_lpb.trajectory import Trajectory

from .trials import ARM, CART, REACH, Array, make_problem, make_trial


@dataclass(frozen=True)
class Placement:
    """Where a scene lies: first turned about the origin, then shifted."""

    angle: float = 0.0  # [rad]
    x: float = 0.0  # [m]
    y: float = 0.0  # [m]

    def of(self, points: Array) -> Array:
        shifted: Array = self.turned(points) + np.array([self.x, self.y])
        return shifted

    def turned(self, vectors: Array) -> Array:
        c, s = cos(self.angle), sin(self.angle)
        turned: Array = vectors @ np.array([[c, s], [-s, c]])
        return turned

    def of_expressions(self, x: str, y: str) -> list[str]:
        c, s = cos(self.angle), sin(self.angle)
        first, second = f"({c!r})*({x}) - ({s!r})*({y})", f"({s!r})*({x}) + ({c!r})*({y})"
        return [f"{first} + ({self.x!r})", f"{second} + ({self.y!r})"]


ORIGIN = Placement()
Scene = Callable[..., Trajectory]  # of the step [s] and a placement; without it, at the origin


def timing(rows: int) -> dict[str, Array]:
    wall = np.append(np.linspace(3.0, 9.0, rows - 1), np.nan)
    solved = np.append(np.ones(rows - 1), np.nan)
    return {"solver_wall_ms": wall, "solver_cpu_ms": 0.8 * wall, "planner_solved": solved}


def reaching(dt: float, place: Placement = ORIGIN) -> Trajectory:
    """A point on a bent path to a goal, by a fixed and a moving obstacle; within limits if not turned."""
    t = np.arange(round(5.0 / dt) + 1) * dt
    share = np.clip(t / 4.0, 0.0, 1.0)
    progress = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    speed = 30.0 * share**2 * (1.0 - share) ** 2 / 4.0
    path = np.column_stack([3.0 * progress, np.sin(2.0 * progress)])
    velocity = np.column_stack([3.0 * speed, 2.0 * np.cos(2.0 * progress) * speed])
    action = place.turned(np.column_stack([np.sin(1.5 * t), 1.0 + 0.5 * np.cos(t)]))
    target = place.of(np.array([[3.0, sin(2.0)]]))[0].tolist()
    pillar = place.of(np.array([[1.5, -0.07]]))[0].tolist()
    problem = make_problem(
        dt=dt,
        goal=[{**REACH, "target": target, "tolerance": 0.1}],
        obstacles=[
            {"name": "pillar", "shape": "circle", "radius": 0.5, "position": pillar},
            {
                "name": "cart",
                "shape": "circle",
                "radius": 0.3,
                "trajectory": place.of_expressions("6 - 0.7*t", "0.3"),
            },
            {"name": "wall", "shape": "rectangle", "size": [0.1, 0.1], "position": [90.0, 90.0]},
        ],
        hold_time=0.4,
        safety_margin=0.4,
        limits=None if place.angle else [[place.x - 1.0, place.x + 5.0], [place.y - inf, place.y + 2.0]],
    )
    problem.certified_path_length_m = 3.3
    columns = {**timing(len(t)), "self_clearance_m": 0.3 + 0.1 * np.cos(t)}
    return make_trial(problem, place.of(path), qd=place.turned(velocity), action=action, columns=columns, period_s=0.1)


def following(dt: float, place: Placement = ORIGIN) -> Trajectory:
    """A point that catches up with a moving goal."""
    t = np.arange(round(4.0 / dt) + 1) * dt
    goal = np.column_stack([0.5 * t, np.sin(t)])
    gap = np.column_stack([-0.6 * np.exp(-t), 0.1 * np.cos(3.0 * t) - 0.4 * np.exp(-t)])
    moving = {"target": None, "trajectory": place.of_expressions("0.5*t", "sin(t)")}
    entry: dict[str, Any] = {**REACH, **moving, "tolerance": 0.25}
    return make_trial(make_problem(dt=dt, goal=[entry], hold_time="end"), place.of(goal + gap))


def folding(dt: float, place: Placement = ORIGIN) -> Trajectory:
    """An arm whose second joint should come to 1 rad; its base is the origin, so it is never placed."""
    assert place == ORIGIN
    t = np.arange(round(3.0 / dt) + 1) * dt
    goal = {"name": "elbow", "type": "joint", "joints": ["joint2"], "target": [1.0], "tolerance": 0.1}
    problem = make_problem(ARM, dt=dt, goal=[goal], limits=[[-1.0, 1.0], [-2.0, 2.0]])
    return make_trial(problem, np.column_stack([0.5 * np.sin(t), 1.0 - np.exp(-2.0 * t)]))


def driving(dt: float, place: Placement = ORIGIN) -> Trajectory:
    """A cart on a circle, past an obstacle."""
    t = np.arange(round(3.0 / dt) + 1) * dt
    centre, radius, rate = place.of(np.array([[0.0, 1.0]])), 1.0, 0.5
    outward = place.turned(np.column_stack([np.sin(rate * t), -np.cos(rate * t)]))
    along = place.turned(np.column_stack([np.cos(rate * t), np.sin(rate * t)]))
    heading = rate * t + place.angle
    target = [place.angle + 1.2]
    goal = {"name": "turn", "type": "orientation", "link": "base", "target": target, "tolerance": 0.107}
    post = place.of(np.array([[2.0, 1.1]]))[0].tolist()
    obstacles = [{"name": "post", "shape": "circle", "radius": 0.4, "position": post}]
    problem = make_problem(CART, dt=dt, goal=[goal], obstacles=obstacles, safety_margin=0.6)
    q = np.column_stack([centre + radius * outward, heading])
    qd = np.column_stack([radius * rate * along, np.full(len(t), rate)])
    return make_trial(problem, q, qd=qd, action=np.tile([radius * rate, rate], (len(t), 1)))


PLACEABLE: tuple[Scene, ...] = (reaching, following, driving)
SCENES: tuple[Scene, ...] = (*PLACEABLE, folding)
