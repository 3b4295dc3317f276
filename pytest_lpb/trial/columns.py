"""The columns of a trial file, from what the loop logged; links, goals and obstacles for all rows at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.trajectory import AXES
from pytest_lpb.trial.loop import Log

Columns = dict[str, NDArray[Any]]
NS_PER_MS = 1e6
TURNS = {2: ("theta",), 3: ("qw", "qx", "qy", "qz")}  # columns of an obstacle's orientation, by dimension


def columns_of(problem: Problem, log: Log) -> Columns:
    """All columns by name, each (N + 1,): see section 7 of the contract."""
    rows = len(log.q)
    t = np.arange(rows, dtype=np.float64) * problem.dt
    columns: Columns = {"t": t}
    _numbered(columns, "q", _matrix(log.q, problem.robot.dof))
    _numbered(columns, "qd", _matrix(log.qd, problem.robot.dof))
    _numbered(columns, "u", _matrix(log.u, problem.robot.n_actions))
    _numbered(columns, "action", _with_last_row(log.action, problem.robot.n_actions, rows))
    _numbered(columns, "applied", _with_last_row(log.applied, problem.robot.n_actions, rows))
    _add_links(columns, problem, _matrix(log.q, problem.robot.dof))
    _add_goals(columns, problem, t, _matrix(log.goal_errors, sum(len(goal.components) for goal in problem.goal)))
    _add_obstacles(columns, problem, t)
    distances, bodies, obstacles = zip(*log.clearance, strict=True) if rows else ((), (), ())
    columns["clearance_m"] = np.array(distances, dtype=float)
    columns["clearance_body"] = np.array(bodies, dtype=object)
    columns["clearance_obstacle"] = np.array(obstacles, dtype=object)
    columns["self_clearance_m"] = np.array(log.self_clearance, dtype=float)
    columns["clearance_step_min_m"] = np.array(log.step_clearance, dtype=float)
    columns["self_clearance_step_min_m"] = np.array(log.self_step_clearance, dtype=float)
    _add_calls(columns, log, rows)
    return columns


def _matrix(rows: Sequence[Sequence[float]], width: int) -> FloatArray:
    return np.array(rows, dtype=float).reshape(len(rows), width)


def _with_last_row(steps: Sequence[Sequence[float]], width: int, rows: int) -> FloatArray:
    """Steps as (rows, width), NaN where no action was applied: in the last row."""
    matrix = np.full((rows, width), np.nan)
    matrix[: len(steps)] = _matrix(steps, width)
    return matrix


def _numbered(columns: Columns, prefix: str, matrix: FloatArray) -> None:
    for index in range(matrix.shape[1]):
        columns[f"{prefix}{index}"] = np.ascontiguousarray(matrix[:, index])


def _add_links(columns: Columns, problem: Problem, q: FloatArray) -> None:
    positions = problem.robot.link_positions(q)
    for index, link in enumerate(problem.robot.link_names):
        for axis in range(problem.dimension):
            columns[f"link_{link}_{AXES[axis]}"] = np.ascontiguousarray(positions[:, index, axis])


def _add_goals(columns: Columns, problem: Problem, t: FloatArray, errors: FloatArray) -> None:
    first = 0
    for goal in problem.goal:
        _numbered(columns, f"goal_{goal.name}_", goal.motion.evaluate(t)[0])
        own = errors[:, first : first + len(goal.components)]
        columns[f"goal_{goal.name}_error"] = own.max(axis=1)
        for component, series in zip(goal.components, own.T, strict=True):
            columns[component.column] = np.ascontiguousarray(series)
        first += len(goal.components)


def _add_obstacles(columns: Columns, problem: Problem, t: FloatArray) -> None:
    for obstacle in problem.obstacles:
        positions, turns = obstacle.poses(t)
        for axis in range(problem.dimension):
            columns[f"obstacle_{obstacle.name}_{AXES[axis]}"] = np.ascontiguousarray(positions[:, axis])
        for letter, values in zip(TURNS[problem.dimension], np.atleast_2d(turns.T), strict=True):
            columns[f"obstacle_{obstacle.name}_{letter}"] = np.ascontiguousarray(values)


def _add_calls(columns: Columns, log: Log, rows: int) -> None:
    called = np.array(log.call_row, dtype=int)
    keys = sorted({key for diagnostics in log.diagnostics for key in diagnostics})
    series = {
        "solver_wall_ms": np.array(log.call_wall_ns) / NS_PER_MS,
        "solver_cpu_ms": np.array(log.call_cpu_ns) / NS_PER_MS,
        **{f"planner_{key}": [d.get(key, np.nan) for d in log.diagnostics] for key in keys},
    }
    for name, values in series.items():
        columns[name] = np.full(rows, np.nan)
        columns[name][called] = values
