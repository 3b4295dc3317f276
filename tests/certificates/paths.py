"""Certified paths: rows of time and configuration that prove a problem solvable, and how they are checked."""

from __future__ import annotations

from contextlib import closing
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.environment.bullet import BulletEngine
from pytest_lpb.problem.continuous_collision import first_touch
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.spatial.swept_bodies import SpatialStep, SpatialSweptBodies, polyline

Array = NDArray[np.float64]

STEP_RAD = 0.02  # [rad or m] between configurations that are checked
HOLD_STEP_S = 0.02  # [s] between checks while the goal is held
SPEED_SHARE = 1.02  # of the velocity limits: straight lines between rows may ask for a little more
SLIP = 0.06  # sideways motion of a non-holonomic base per motion between two rows; a chord of an arc has some
SLIP_M = 2e-3  # [m] that are no motion


def write_path(path: Path, how: str, t: Array, q: Array) -> None:
    """Write rows of time [s] and configuration [rad or m]."""
    header = f"# {how}\n" + ",".join(["t", *(f"q{index}" for index in range(q.shape[1]))])
    rows = [",".join(f"{value:.6g}" for value in row) for row in np.column_stack([t, q])]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")


def read_path(path: Path) -> tuple[Array, Array]:
    """Times (n,) [s] and configurations (n, dof) of a file."""
    rows = np.loadtxt(path, delimiter=",", skiprows=2, ndmin=2)
    return rows[:, 0], rows[:, 1:]


def path_length(problem: Problem, q: Array) -> float:
    """Length [m] that the primary goal's link (for a joint goal the last one) goes, in straight lines between rows."""
    robot = problem.robot
    row = robot.link_index(problem.primary.link) if problem.primary.link else len(robot.link_names) - 1
    positions = robot.link_positions(q)[:, row]
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())


def refined(t: Array, q: Array) -> tuple[Array, Array]:
    """Rows in between, no farther apart than `STEP_RAD`."""
    times, rows = [t[:1]], [q[:1]]
    for index in range(len(t) - 1):
        count = max(1, ceil(float(np.abs(q[index + 1] - q[index]).max()) / STEP_RAD))
        shares = np.arange(1, count + 1) / count
        times.append(t[index] + shares * (t[index + 1] - t[index]))
        rows.append(q[index] + shares[:, None] * (q[index + 1] - q[index]))
    return np.concatenate(times), np.vstack(rows)


def held(problem: Problem, t: Array, q: Array) -> tuple[Array, Array]:
    """The path with its last row held as long as the goal asks for."""
    last = problem.duration if problem.hold_time == "end" else float(t[-1]) + float(problem.hold_time)
    more = np.arange(float(t[-1]) + HOLD_STEP_S, last + HOLD_STEP_S, HOLD_STEP_S)
    return np.concatenate([t, more]), np.vstack([q, np.repeat(q[-1:], len(more), axis=0)])


def faults_of_path(problem: Problem, t: Array, q: Array) -> list[str]:
    """What is wrong with a path; empty: it solves the problem."""
    faults = []
    if t[0] != 0.0 or np.abs(q[0] - problem.start_q).max() > 1e-6:
        faults.append("it does not begin at the start")
    if (np.diff(t) <= 0.0).any() or t[-1] > problem.duration:
        faults.append("its times do not increase, or are longer than the trial")
    limits = problem.robot.limits
    if ((q < limits.position[:, 0] - 1e-6) | (q > limits.position[:, 1] + 1e-6)).any():
        faults.append("it leaves the position limits")
    faults += _speed_faults(problem, t, q)
    faults += _goal_faults(problem, t, q)
    faults += _collision_faults(problem, *held(problem, *refined(t, q)))
    return faults


def _speed_faults(problem: Problem, t: Array, q: Array) -> list[str]:
    robot = problem.robot
    change = np.diff(q, axis=0)
    base = 0 if not robot.headings else robot.dof - (robot.n_actions - (2 if robot.non_holonomic else 3))
    actions = 0 if not robot.headings else (2 if robot.non_holonomic else 3)
    rates = np.abs(change[:, base:]) / np.diff(t)[:, None]
    faults = []
    if (rates > SPEED_SHARE * robot.limits.velocity[actions:, 1]).any():
        faults.append("it is faster than the joints can be")
    if robot.non_holonomic:
        middle = 0.5 * (q[1:, 2] + q[:-1, 2])
        sideways = np.abs(np.cos(middle) * change[:, 1] - np.sin(middle) * change[:, 0])
        if (sideways > SLIP * np.linalg.norm(change[:, :2], axis=1) + SLIP_M).any():
            faults.append("its base slips sideways")
    return faults


def _goal_faults(problem: Problem, t: Array, q: Array) -> list[str]:
    """Whether the last row is within every tolerance for as long as it is held; moving goals: from the entry on."""
    moving = any(goal.moving for goal in problem.goal)
    times, rows = (t, q) if moving else (t[-1:], q[-1:])
    inside = []
    for time, row in zip(times, rows, strict=True):
        frames, values = problem.robot.frames(row.tolist()), row.tolist()
        inside.append(
            all(
                goal.distance(goal.value(values, frames), goal.motion.evaluate(np.array([time]))[0][0].tolist())
                <= goal.tolerance
                for goal in problem.goal
                if goal.tolerance is not None
            )
        )
    entered = inside.index(True) if True in inside else None
    if entered is None or not all(inside[entered:]):
        return ["it does not end within the goal's tolerances"]
    if moving and t[-1] < problem.duration - problem.dt:
        return ["it does not follow the goal to the end"]
    return []


def _collision_faults(problem: Problem, t: Array, q: Array) -> list[str]:
    with closing(_engine(problem)) as engine:
        last: tuple[float, Array] | None = None
        for time, row in zip(t, q, strict=True):
            poses = [obstacle.poses(np.array([time])) for obstacle in problem.obstacles]
            engine.set_state(row.tolist(), problem.start_u.tolist())
            engine.place_obstacles([p[0].tolist() for p, _ in poses], [o[0].tolist() for _, o in poses])
            (clearance, body, obstacle), (own, first, second) = engine.clearance()
            if clearance <= 0.0:
                return [f"at {time:.2f} s {body} is {-clearance:.4f} m inside {obstacle}"]
            if own < -engine.contact_slack_m:
                return [f"at {time:.2f} s {first} is {-own:.4f} m inside {second}"]
            if last is not None and (names := _touching_since(engine, problem, last, (time, row))):
                return [f"before {time:.2f} s {names[0]} is inside {names[1]}"]
            last = time, row
    return []


def _touching_since(
    engine: BulletEngine, problem: Problem, first: tuple[float, Array], second: tuple[float, Array]
) -> tuple[str, str] | None:
    """Bodies that touch on the straight way between two configurations, at the second of which the engine is."""
    (start, before), (end, after) = first, second
    span, collision = (np.array([start]), np.array([end])), engine._collision
    step = SpatialStep(
        polyline(np.stack([before, after])),
        np.abs(after - before) / (end - start),
        start,
        end - start,
        [
            float((o.motion.speed_bound(*span) + 2.0 * radius * o.turning.speed_bound(*span))[0]) * (end - start)
            for o, radius in zip(problem.obstacles, engine._world.obstacle_radii, strict=True)
        ],
        np.concatenate([collision.obstacles.bounds, collision.own.bounds]),
    )
    bodies = SpatialSweptBodies(engine._world, collision, problem.obstacles, step)
    touch = first_touch(bodies, -engine.contact_slack_m)
    engine.restore()
    return None if touch is None else bodies.names(touch.pair)


def _engine(problem: Problem) -> BulletEngine:
    """Geometry only, whatever forces the trial simulates."""
    entry: dict[str, Any] = problem.to_dict()
    settings = {**entry["environment"], "dynamics": False}
    return BulletEngine(Problem.from_dict({**entry, "environment": settings}, problem.name))
