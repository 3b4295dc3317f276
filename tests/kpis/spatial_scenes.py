"""Smooth motions in space that can be sampled at any step and placed anywhere."""

from dataclasses import dataclass
from math import sin
from typing import Any

import numpy as np

from pytest_lpb.problem.spatial.rotations import Quaternion, from_axis_angle, matrix_of, multiply
from pytest_lpb.trajectory import Trajectory

from .scenes import Scene, timing
from .trials import ARM_3D, CART_3D, POINT_3D, REACH, Array, make_problem, make_trial

STILL: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SpatialPlacement:
    """Where a scene lies: first turned about the origin, then shifted."""

    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    angle: float = 0.0  # [rad]
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m]

    @property
    def turn(self) -> Quaternion:
        return from_axis_angle(self.axis, self.angle) if self.angle else STILL

    @property
    def base_pose(self) -> dict[str, list[float]]:
        return {"position": list(self.shift), "orientation": list(self.turn)}

    def of(self, points: Any) -> Array:
        shifted: Array = self.turned(points) + np.array(self.shift)
        return shifted

    def turned(self, vectors: Any) -> Array:
        turned: Array = np.asarray(vectors) @ matrix_of(self.turn).T
        return turned

    def of_expressions(self, *texts: str) -> list[str]:
        rows = matrix_of(self.turn).tolist()
        sums = [" + ".join(f"({x!r})*({text})" for x, text in zip(row, texts, strict=True)) for row in rows]
        return [f"{total} + ({x!r})" for total, x in zip(sums, self.shift, strict=True)]


HERE = SpatialPlacement()


def balls(place: SpatialPlacement) -> list[dict[str, Any]]:
    """One that stays, one that comes by, and a box that is in nobody's way."""
    return [
        {"name": "pillar", "shape": "sphere", "radius": 0.5, "position": place.of([1.5, -0.07, 0.4]).tolist()},
        {
            "name": "drone",
            "shape": "sphere",
            "radius": 0.3,
            "trajectory": place.of_expressions("6 - 0.7*t", "0.3", "0.2*t"),
        },
        {"name": "wall", "shape": "box", "size": [0.1, 0.1, 0.1], "position": place.of([9.0, 9.0, 9.0]).tolist()},
    ]


def flight(dt: float) -> tuple[Array, Array, Array]:
    """Positions, velocities and actions of a bent path in space, at rest at both ends."""
    t = np.arange(round(5.0 / dt) + 1) * dt
    share = np.clip(t / 4.0, 0.0, 1.0)
    progress = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    speed = 30.0 * share**2 * (1.0 - share) ** 2 / 4.0
    path = np.column_stack([3.0 * progress, np.sin(2.0 * progress), 0.8 * progress**2])
    slope = np.column_stack([np.full(len(t), 3.0), 2.0 * np.cos(2.0 * progress), 1.6 * progress])
    action = np.column_stack([np.sin(1.5 * t), 1.0 + 0.5 * np.cos(t), np.cos(2.0 * t)])
    return path, slope * speed[:, None], action


def _flying(dt: float, place: SpatialPlacement, robot: dict[str, Any], moved: SpatialPlacement) -> Trajectory:
    path, velocity, action = flight(dt)
    problem = make_problem(
        robot,
        dt=dt,
        goal=[{**REACH, "target": place.of([3.0, sin(2.0), 0.8]).tolist(), "tolerance": 0.1}],
        obstacles=balls(place),
        hold_time=0.4,
        safety_margin=0.4,
        limits=[[-1.0, 5.0], [-1.0, 2.0], [-0.5, 3.0]] if moved is HERE else None,
    )
    problem.certified_path_length_m = 3.4
    columns = {**timing(len(path)), "self_clearance_m": 0.3 + 0.1 * np.cos(np.arange(len(path)) * dt)}
    q, qd, actions = moved.of(path), moved.turned(velocity), moved.turned(action)
    return make_trial(problem, q, qd=qd, action=actions, columns=columns, period_s=0.1)


def flying(dt: float, place: SpatialPlacement = HERE) -> Trajectory:
    """A ball on a bent path past two others; its coordinates are the world's."""
    return _flying(dt, place, POINT_3D, place)


def carried(dt: float, place: SpatialPlacement = HERE) -> Trajectory:
    """The same, but the frame of its coordinates is placed: q, its limits and the actions stay what they are."""
    return _flying(dt, place, {**POINT_3D, "base_pose": place.base_pose}, HERE)


def chasing(dt: float, place: SpatialPlacement = HERE) -> Trajectory:
    """A ball that catches up with a moving goal."""
    t = np.arange(round(4.0 / dt) + 1) * dt
    goal = np.column_stack([0.5 * t, np.sin(t), 0.1 * t**2])
    gap = np.column_stack([-0.6 * np.exp(-t), 0.1 * np.cos(3.0 * t) - 0.4 * np.exp(-t), 0.05 * np.sin(t)])
    moving = {"target": None, "trajectory": place.of_expressions("0.5*t", "sin(t)", "0.1*t**2")}
    entry: dict[str, Any] = {**REACH, **moving, "tolerance": 0.25}
    return make_trial(make_problem(POINT_3D, dt=dt, goal=[entry], hold_time="end"), place.of(goal + gap))


def _arm(dt: float, place: SpatialPlacement, goal: dict[str, Any]) -> Trajectory:
    t = np.arange(round(3.0 / dt) + 1) * dt
    q = np.column_stack([0.5 * np.sin(t), 1.0 - np.exp(-2.0 * t), 0.3 * t])
    problem = make_problem(
        {**ARM_3D, "base_pose": place.base_pose},
        dt=dt,
        goal=[goal],
        obstacles=balls(place),
        limits=[[-1.0, 1.0], [-2.0, 2.0], [-2.0, 2.0]],
    )
    return make_trial(problem, q)


def bending(dt: float, place: SpatialPlacement = HERE) -> Trajectory:
    """An arm whose third joint should come to 0.6 rad."""
    return _arm(
        dt, place, {"name": "wrist", "type": "joint", "joints": ["joint3"], "target": [0.6], "tolerance": 0.107}
    )


def pointing(dt: float, place: SpatialPlacement = HERE) -> Trajectory:
    """An arm that turns its end towards an orientation."""
    target = list(multiply(place.turn, from_axis_angle((0.1, 1.0, 0.2), 1.5)))
    return _arm(dt, place, {"name": "turn", "type": "orientation", "link": "end", "target": target, "tolerance": 0.307})


def rolling(dt: float, place: SpatialPlacement = HERE) -> Trajectory:
    """A cart on a circle on the ground, past a ball that lies on it; placed on the ground only."""
    t = np.arange(round(3.0 / dt) + 1) * dt
    radius, rate = 1.0, 0.5
    still = np.zeros(len(t))
    centre = place.of([0.0, 1.0, 0.0])
    outward = place.turned(np.column_stack([np.sin(rate * t), -np.cos(rate * t), still]))
    along = place.turned(np.column_stack([np.cos(rate * t), np.sin(rate * t), still]))
    target = list(from_axis_angle((0.0, 0.0, 1.0), place.angle + 1.2))
    goal = {"name": "turn", "type": "orientation", "link": "base", "target": target, "tolerance": 0.107}
    post = place.of([2.0, 1.1, 0.4]).tolist()
    obstacles = [{"name": "post", "shape": "sphere", "radius": 0.4, "position": post}]
    problem = make_problem(CART_3D, dt=dt, goal=[goal], obstacles=obstacles, safety_margin=0.6)
    q = np.column_stack([(centre + radius * outward)[:, :2], rate * t + place.angle])
    qd = np.column_stack([radius * rate * along[:, :2], np.full(len(t), rate)])
    return make_trial(problem, q, qd=qd, action=np.tile([radius * rate, rate], (len(t), 1)))


ANYWHERE: tuple[Scene, ...] = (flying, carried, chasing, bending, pointing)
SPATIAL: tuple[Scene, ...] = (*ANYWHERE, rolling)
