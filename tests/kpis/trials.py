"""Trials made by hand: columns as the recorder writes them, from motions given as arrays."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import robot_from
from pytest_lpb.trajectory import AXES, Trajectory
from tests.problem.spatial import robots

Array = NDArray[np.float64]

POINT: dict[str, Any] = {
    "model": "point",
    "name": "point",
    "control": "acceleration",
    "base": "fixed",
    "body_radius": 0.2,
}
ARM: dict[str, Any] = {
    "model": "planar_arm",
    "name": "planar_arm_2",
    "links": [1.0, 1.0],
    "control": "acceleration",
    "base": "fixed",
    "body_radius": 0.1,
}
CART: dict[str, Any] = {
    "model": "differential_drive",
    "name": "differential_drive",
    "control": "velocity",
    "base": "differential_drive",
    "wheel_base": 0.5,
    "body_radius": 0.2,
}
POINT_3D: dict[str, Any] = robots.robot_entry(robots.POINT)
ARM_3D: dict[str, Any] = robots.robot_entry(robots.ARM)
CART_3D: dict[str, Any] = robots.robot_entry(robots.CART)
REACH: dict[str, Any] = {
    "name": "reach",
    "type": "position",
    "link": "body",
    "target": [2.0, 0.0],
    "tolerance": 0.15,
}


def make_problem(
    robot: dict[str, Any] | None = None,
    *,
    dt: float = 0.1,
    duration: float = 10.0,
    goal: Sequence[dict[str, Any]] = (REACH,),
    obstacles: Sequence[dict[str, Any]] = (),
    hold_time: float | str = 0.1,
    safety_margin: float = 0.05,
    limits: Sequence[Sequence[float] | None] | None = None,
) -> Problem:
    robot = {**(robot or POINT), "limits": {"position": limits}}
    made = robot_from(robot)
    return Problem.from_dict(
        {
            "robot": robot,
            "environment": {
                "engine": {2: "planar", 3: "pybullet"}[made.dimension],
                "dt": dt,
                "duration": duration,
                "end_at": ["goal", "violation"],
                "safety_margin": safety_margin,
                "dynamics": False,
                "gravity": [0.0, 0.0, -9.81],
                "prediction": "constant_velocity",
            },
            "start": {"q": [0.0] * made.dof, "u": [0.0] * made.n_actions},
            "goal": list(goal),
            "obstacles": list(obstacles),
            "success": {"hold_time": hold_time},
            "seed": 0,
        }
    )


def make_trial(
    problem: Problem,
    q: Array,
    *,
    qd: Array | None = None,
    action: Array | None = None,
    columns: dict[str, Array] | None = None,
    **metadata: Any,
) -> Trajectory:
    """A trial with joint positions q (N + 1, dof); links, goals, errors and distances follow from them.

    Args:
        columns: replace or add to the columns computed here.
        metadata: replaces the defaults.
    """
    rows = len(q)
    t = np.arange(rows, dtype=np.float64) * problem.dt
    qd = np.zeros_like(q) if qd is None else qd
    action = np.zeros((rows, problem.robot.n_actions)) if action is None else action.copy()
    if rows:
        action[-1] = np.nan
    data: dict[str, Array] = {"t": t}
    for name, values in (("q", q), ("qd", qd), ("u", qd[:, : action.shape[1]])):
        data |= {f"{name}{i}": values[:, i] for i in range(values.shape[1])}
    for name in ("action", "applied"):
        data |= {f"{name}{i}": action[:, i] for i in range(action.shape[1])}
    links = problem.robot.link_positions(q)
    for index, link in enumerate(problem.robot.link_names):
        data |= {f"link_{link}_{AXES[axis]}": links[:, index, axis] for axis in range(links.shape[2])}
    data |= _goal_columns(problem, t, q) | _distance_columns(problem, t, q)
    data |= {name: np.full(rows, np.nan) for name in ("solver_wall_ms", "solver_cpu_ms")}
    data |= columns or {}
    defaults = {
        "node_id": "scenarios/x.yaml::mine::seed0",
        "outcome": "success",
        "wall_s": 0.5,
        "setup_ms": 7.0,
        "period_s": problem.dt,
    }
    return Trajectory(data, {**defaults, **metadata}, problem)


def _goal_columns(problem: Problem, t: Array, q: Array) -> dict[str, Array]:
    data: dict[str, Array] = {}
    frames = problem.robot.frames_of(q) if len(q) else []
    for goal in problem.goal:
        targets = goal.motion.evaluate(t)[0]
        data |= {f"goal_{goal.name}_{i}": targets[:, i] for i in range(targets.shape[1])}
        data[f"goal_{goal.name}_error"] = np.array(
            [
                goal.distance(goal.value(row, frame), target)
                for row, frame, target in zip(q.tolist(), frames, targets.tolist(), strict=True)
            ]
        )
    return data


def _distance_columns(problem: Problem, t: Array, q: Array) -> dict[str, Array]:
    """Clearance of the last link's disc or ball to round obstacles; no distance of the robot to itself."""
    tip = problem.robot.link_positions(q)[:, -1]
    data = {"clearance_m": np.full(len(t), np.nan), "self_clearance_m": np.full(len(t), np.nan)}
    for obstacle in problem.obstacles:
        position = obstacle.motion.evaluate(t)[0]
        data |= {f"obstacle_{obstacle.name}_{AXES[axis]}": position[:, axis] for axis in range(position.shape[1])}
        if obstacle.radius is not None:
            distance = np.linalg.norm(position - tip, axis=1) - obstacle.radius - problem.robot.body_radius
            data["clearance_m"] = np.fmin(data["clearance_m"], distance)
    return data
