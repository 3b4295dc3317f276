"""Clearance and goal error over time, one line per planner."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.report.canvas import path_through, thinned
from pytest_lpb.report.numbers import show_exact, unit_text
from pytest_lpb.report.scale import Scale, drawable, scale_for
from pytest_lpb.report.scene_marks import Drawn
from pytest_lpb.report.view import Line, Tick, Timeline

FloatArray = NDArray[np.float64]


def timelines(drawn: Sequence[Drawn]) -> list[Timeline]:
    """Goal error and clearance over time of the trials in a scene; without those that have no values."""
    if not drawn:
        return []
    problem = drawn[0].trajectory.problem
    goal = problem.primary
    errors = zip(*(trial.trajectory.goal_errors(goal) for trial in drawn), strict=True)
    clearances = [trial.trajectory.step_clearance for trial in drawn]
    found = [
        *(
            _timeline("goal error", unit_text(part.unit), drawn, values, part.tolerance, "tolerance")
            for part, values in zip(goal.components, errors, strict=True)
        ),
        _timeline("clearance", "m", drawn, clearances, problem.safety_margin, "safety margin"),
    ]
    return [timeline for timeline in found if timeline is not None]


def _timeline(
    name: str,
    unit: str,
    drawn: Sequence[Drawn],
    values: Sequence[FloatArray],
    limit: float | None,
    limit_name: str,
) -> Timeline | None:
    present = np.concatenate(values)
    present = present[drawable(present)]
    if len(present) == 0:
        return None
    shown = np.append(present, [0.0] if limit is None else [0.0, limit])
    time, value = scale_for(np.append(np.concatenate([d.trajectory.t for d in drawn]), 0.0)), scale_for(shown)
    lines = []
    for trial, series in zip(drawn, values, strict=True):
        places = np.column_stack([time.place(trial.trajectory.t), 1 - value.place(series)])
        lines.append(Line(trial.style, path_through(thinned(1000 * places))))
    return Timeline(
        title=f"{name} [{unit}]",
        x_ticks=time.ticks(7),
        y_ticks=_from_top(value),
        lines=[line for line in lines if line.d],
        limit=None if limit is None else round(float(1000 * (1 - value.place(np.array([limit]))[0])), 1),
        limit_label="" if limit is None else f"{limit_name} {show_exact(limit)} {unit}".rstrip(),
    )


def _from_top(scale: Scale) -> list[Tick]:
    return [Tick(round(100 - tick.at, 2), tick.label) for tick in scale.ticks(5)]
