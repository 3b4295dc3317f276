"""Time series of one trial, sampled for the page: errors, clearance, motion with its limits, diagnostics."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.report.numbers import show_exact, unit_text
from pytest_lpb.report.replay.numbers import changed_rows, fine_step, listed, needed_rows, thinned_rows
from pytest_lpb.report.scale import drawable
from pytest_lpb.trial.units import unit_of

if TYPE_CHECKING:
    from pytest_lpb.problem.robot import Limits
    from pytest_lpb.trajectory import Trajectory

FloatArray = NDArray[np.float64]
Rows = Callable[[FloatArray, FloatArray, float], NDArray[np.intp]]

MAX_POINTS = 160  # of a line
VALUE_PARTS = 200  # in which a line's range is told: a part is less than a pixel
TASK_PARTS = 1000  # the same of errors and clearance, whose values are read
MAX_DIAGNOSTICS = 12  # charts of what a planner records
PLANNER = "planner_"  # prefix of these columns

# Which points of a line suffice to draw it: joined by straight lines, held until the next, or each by itself.
ROWS: dict[str, Rows] = {
    "line": needed_rows,
    "step": lambda _, values, tolerance: changed_rows(values, tolerance),
    "dots": lambda t, _, __: np.arange(len(t)),
}
# Of what is held from row to row, both are right; the one with fewer points is taken.
DRAWN_AS = {"line": ("line",), "step": ("line", "step"), "dots": ("dots",)}


def charts(trajectory: Trajectory) -> list[dict[str, Any]]:
    """Charts from top to bottom, without those that have no values."""
    made = [*_task(trajectory), *_motion(trajectory), *_diagnostics(trajectory)]
    return [chart for chart in made if chart["lines"]]


def diagnostics_left_out(trajectory: Trajectory) -> list[str]:
    """What the planner recorded that has no chart."""
    return _keys(trajectory)[MAX_DIAGNOSTICS:]


def _task(trajectory: Trajectory) -> Iterator[dict[str, Any]]:
    """What the trial is about: errors of the sub-goals, clearance, time of the planner's calls."""
    problem = trajectory.problem
    for goal in problem.goal:
        title = "distance to goal" if goal is problem.primary else f"error of {goal.name}"
        for part, errors in zip(goal.components, trajectory.goal_errors(goal), strict=True):
            line = _line(trajectory, "", errors, "line", parts=TASK_PARTS)
            yield _chart(title, part.unit, [line], part.tolerance, "tolerance")
    clearance = [_line(trajectory, "", trajectory.step_clearance, "line", parts=TASK_PARTS)]
    yield _chart("clearance", "m", clearance, problem.safety_margin, "safety margin")
    yield _chart("solver time", "ms", [_line(trajectory, "", trajectory.solver_wall_ms, "dots")])


def _motion(trajectory: Trajectory) -> Iterator[dict[str, Any]]:
    """Positions, velocities and actions by joint, with their limits; a chart per unit."""
    robot = trajectory.problem.robot
    of_action = _limits_of_action(trajectory.problem.control, robot.limits)
    for title, column, names, series, limits, kind in (
        ("position", "q", robot.joint_names, trajectory.q, robot.limits.position, "line"),
        ("velocity", "u", robot.action_names, trajectory.u, robot.limits.velocity, "line"),
        ("action", "action", robot.action_names, trajectory.action, of_action, "step"),
    ):
        by_unit: dict[str, list[dict[str, Any]]] = defaultdict(list)
        for index, name in enumerate(names):
            unit = unit_of(f"{column}{index}", trajectory.problem)
            by_unit[unit].append(_line(trajectory, name, series[:, index], kind, limits[index]))
        for unit, lines in by_unit.items():
            # A line by itself has no legend.
            of = f" {lines[0]['name']}" if len(lines) == 1 else ""
            yield _chart(f"{title}{of}", unit, lines) | {"below": True}


def _limits_of_action(control: str, limits: Limits) -> FloatArray:
    return {"velocity": limits.velocity, "acceleration": limits.acceleration, "torque": limits.effort}[control]


def _diagnostics(trajectory: Trajectory) -> Iterator[dict[str, Any]]:
    """What the planner recorded of itself, a chart per key: only the planner knows what can be compared."""
    for key in _keys(trajectory)[:MAX_DIAGNOSTICS]:
        line = _line(trajectory, "", trajectory.planner(key), "line")
        yield _chart(f"planner: {key.replace('_', ' ')}", "", [line]) | {"below": True}


def _keys(trajectory: Trajectory) -> list[str]:
    return sorted(name.removeprefix(PLANNER) for name in trajectory.columns if name.startswith(PLANNER))


def _chart(
    title: str,
    unit: str,
    lines: Sequence[dict[str, Any]],
    limit: float | None = None,
    limit_name: str = "",
) -> dict[str, Any]:
    shown = unit_text(unit)
    return {
        "title": f"{title} [{shown}]" if shown else title,
        "lines": [line for line in lines if line["t"]["n"]],
        "limit": limit,
        "limitLabel": "" if limit is None else f"{limit_name} {show_exact(limit)} {shown}".rstrip(),
    }


def _line(
    trajectory: Trajectory,
    name: str,
    values: FloatArray,
    kind: str,
    limits: FloatArray | None = None,
    parts: int = VALUE_PARTS,
) -> dict[str, Any]:
    known = np.where(drawable(values), values, np.nan)
    # Rows in which the planner was not asked are no gaps.
    rows = np.flatnonzero(~np.isnan(known))
    rows = rows[thinned_rows(known[rows], MAX_POINTS)]
    t = trajectory.t
    step = fine_step(known[rows], parts)
    chosen = {way: rows[ROWS[way](t[rows], known[rows], step)] for way in DRAWN_AS[kind]}
    way, rows = min(chosen.items(), key=lambda item: len(item[1]))
    line: dict[str, Any] = {
        "name": name,
        "kind": way,
        "t": listed(t[rows], fine_step(np.diff(t[:2]), 1)),
        "v": listed(known[rows], step),
    }
    if limits is not None and np.isfinite(limits).any():
        line["limits"] = [float(f"{limit:.6g}") if np.isfinite(limit) else None for limit in limits]
    return line
