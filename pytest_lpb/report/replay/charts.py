"""Time series of one trial, sampled for the page: distance to the goals, clearance, actions, solver time."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.report.numbers import show_exact, unit_text
from pytest_lpb.report.replay.numbers import fine_step, listed, thinned_rows
from pytest_lpb.report.scale import drawable
from pytest_lpb.trial.units import unit_of

if TYPE_CHECKING:
    from pytest_lpb.trajectory import Trajectory

FloatArray = NDArray[np.float64]

MAX_POINTS = 200  # of a line
VALUE_PARTS = 1000  # in which a line's range is told


def charts(trajectory: Trajectory) -> list[dict[str, Any]]:
    """Charts from top to bottom, without those that have no values."""
    return [chart for chart in _all(trajectory) if chart["lines"]]


def _all(trajectory: Trajectory) -> Iterator[dict[str, Any]]:
    problem = trajectory.problem
    for goal in problem.goal:
        title = "distance to goal" if goal is problem.primary else f"error of {goal.name}"
        for part, errors in zip(goal.components, trajectory.goal_errors(goal), strict=True):
            yield _chart(title, part.unit, trajectory, {"": errors}, "line", part.tolerance, "tolerance")
    clearance = {"": trajectory.clearance}
    yield _chart("clearance", "m", trajectory, clearance, "line", problem.safety_margin, "safety margin")
    by_unit: dict[str, dict[str, FloatArray]] = defaultdict(dict)
    for index in range(trajectory.action.shape[1]):
        by_unit[unit_of(f"action{index}", problem)][f"action{index}"] = trajectory.action[:, index]
    for unit, actions in by_unit.items():
        yield _chart("action", unit, trajectory, actions, "step")
    yield _chart("solver time", "ms", trajectory, {"": trajectory.solver_wall_ms}, "dots")


def _chart(
    title: str,
    unit: str,
    trajectory: Trajectory,
    series: dict[str, FloatArray],
    kind: str,
    limit: float | None = None,
    limit_name: str = "",
) -> dict[str, Any]:
    shown = unit_text(unit)
    lines = [_line(name, trajectory.t, values) for name, values in series.items() if drawable(values).any()]
    return {
        "title": f"{title} [{shown}]" if shown else title,
        "kind": kind,
        "lines": lines,
        "limit": limit,
        "limitLabel": "" if limit is None else f"{limit_name} {show_exact(limit)} {shown}".rstrip(),
    }


def _line(name: str, t: FloatArray, values: FloatArray) -> dict[str, Any]:
    known = np.where(drawable(values), values, np.nan)
    # Rows in which the planner was not asked are no gaps.
    rows = np.flatnonzero(~np.isnan(known))
    rows = rows[thinned_rows(known[rows], MAX_POINTS)]
    times, chosen = t[rows], known[rows]
    return {
        "name": name,
        "t": listed(times, fine_step(np.diff(t[:2]), 1)),
        "v": listed(chosen, fine_step(chosen, VALUE_PARTS)),
    }
