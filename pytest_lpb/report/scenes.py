"""One picture per scenario: obstacles, goal, start and the path of every planner on the same problem."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pytest_lpb.errors import LpbError
from pytest_lpb.report.canvas import canvas_for
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.depiction import Depiction, Sheet, depiction_for
from pytest_lpb.report.numbers import finite, show
from pytest_lpb.report.overview import by_success, endings
from pytest_lpb.report.projection import PROJECTIONS, Projection, corners_of
from pytest_lpb.report.scene_marks import (
    CONTACTS,
    Drawn,
    ghost_rows,
    goal_marks,
    goal_points,
    obstacle_marks,
    path_marks,
    robot_marks,
)
from pytest_lpb.report.timelines import timelines
from pytest_lpb.report.view import Mark, Panel, PlannerStyle, ScenarioSection, Scene, SceneEntry

FloatArray = NDArray[np.float64]

CORNER_TIMES = 25  # times at which a moving obstacle's corners are held in the picture


def scenario_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> ScenarioSection | None:
    """The picture of every scenario; None without trials."""
    return ScenarioSection(by_success(data, styles), scenes(data, styles)) if len(data.trials) else None


def scenes(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[Scene]:
    """A scene for every scenario, in the order of the table of trials."""
    by_scenario = data.trials.groupby("scenario", sort=False)
    return [_scene(data, styles, number, str(name), rows) for number, (name, rows) in enumerate(by_scenario)]


def representative(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of one scenario to draw: one per planner, of the first seed that most planners ran."""
    planners = rows.groupby("seed")["planner"].nunique()
    seed = planners[planners == planners.max()].index.min()
    chosen = rows[rows["seed"] == seed].drop_duplicates("planner")
    others = rows[~rows["planner"].isin(chosen["planner"])].sort_values("seed").drop_duplicates("planner")
    order = {planner: place for place, planner in enumerate(dict.fromkeys(rows["planner"]))}
    shown: pd.DataFrame = pd.concat([chosen, others]).sort_values("planner", key=lambda names: names.map(order))
    return shown


def _scene(
    data: ReportData, styles: Mapping[str, PlannerStyle], number: int, scenario: str, rows: pd.DataFrame
) -> Scene:
    chosen = representative(rows.assign(outcome=endings(rows)))
    notes: list[str] = []
    drawn = list(_loaded(data, styles, chosen, notes))
    if len({text for text in chosen["problem_hash"].fillna("") if text}) > 1:
        notes.append("The planners shown ran different problems; obstacles and goal are those of the first.")
    # A scenario's file may have changed between two runs of a study; what lies in one picture has one dimension.
    dimension = drawn[0].trajectory.problem.dimension if drawn else 2
    drawable = [trial for trial in drawn if trial.trajectory.problem.dimension == dimension]
    seeds = sorted(set(chosen["seed"]))
    return Scene(
        number=number,
        scenario=scenario,
        caption=f"Seed {', '.join(str(seed) for seed in seeds)} of {rows['seed'].nunique()}",
        panels=[_panel(drawable, projection) for projection in PROJECTIONS[dimension]] if drawable else [],
        timelines=timelines(drawn),
        entries=[_entry(styles[str(row.planner)], row) for row in chosen.itertuples()],
        legend=_legend(drawable),
        notes=notes,
    )


def _loaded(
    data: ReportData, styles: Mapping[str, PlannerStyle], rows: pd.DataFrame, notes: list[str]
) -> Iterator[Drawn]:
    for row in rows.to_dict("records"):
        try:
            trajectory = data.trajectory_of(str(row["node_id"]))
        except (LpbError, OSError) as error:
            notes.append(f"{row['planner']}: no raw data ({error}).")
            continue
        if len(trajectory) == 0:
            notes.append(f"{row['planner']}: no recorded motion ({row['outcome']}).")
            continue
        yield Drawn(styles[row["planner"]], trajectory, str(row["outcome"]))


def _panel(drawn: Sequence[Drawn], projection: Projection) -> Panel:
    first = max(drawn, key=lambda trial: len(trial.trajectory))
    problem, until = first.trajectory.problem, float(first.trajectory.t[-1])
    depiction = depiction_for(problem.dimension)
    fixed = _fixed_points(first, until, depiction, projection)
    canvas = canvas_for(fixed, np.concatenate([depiction.extent(trial.trajectory, projection) for trial in drawn]))
    sheet = Sheet(canvas, projection, depiction)
    marks: list[Mark] = []
    for obstacle in problem.obstacles:
        marks += obstacle_marks(sheet, obstacle, until)
    marks += goal_marks(sheet, first.trajectory)
    ghosts = depiction.has_ghosts(problem.robot)
    for trial in drawn:
        rows = ghost_rows(trial) if ghosts else []
        marks += [mark for row in rows for mark in robot_marks(sheet, trial.trajectory, row, "ghost", trial)]
    marks += robot_marks(sheet, first.trajectory, 0, "start", None)
    for trial in drawn:
        marks += robot_marks(sheet, trial.trajectory, trial.last_row, "final", trial)
    for trial in drawn:
        marks += path_marks(sheet, trial)
    return canvas.panel(projection.title, projection.letters, marks)


def _fixed_points(trial: Drawn, until: float, depiction: Depiction, projection: Projection) -> FloatArray:
    problem = trial.trajectory.problem
    goal = projection.of(goal_points(trial.trajectory))
    parts = [projection.of(trial.path[:1]), goal, depiction.start(trial.trajectory, projection)]
    for obstacle in problem.obstacles:
        positions, turns = obstacle.poses(np.linspace(0.0, until, CORNER_TIMES if obstacle.moving else 1))
        for position, turn in zip(positions, turns, strict=True):
            outline = depiction.outline(obstacle, position, turn, projection)
            parts += [] if outline is None else [corners_of(outline)]
    tolerance = problem.primary.tolerance or 0.0
    parts += [goal + tolerance, goal - tolerance]
    return np.concatenate(parts)


def _entry(style: PlannerStyle, row: Any) -> SceneEntry:
    parts = [str(row.outcome).replace("_", " ")]
    if finite(getattr(row, "time_to_goal_s", None)) is not None:
        parts.append(f"goal after {show(row.time_to_goal_s)} s")
    if finite(getattr(row, "clearance_min_m", None)) is not None:
        parts.append(f"clearance {show(row.clearance_min_m)} m")
    return SceneEntry(style, " · ".join(parts), str(row.outcome))


def _legend(drawn: Sequence[Drawn]) -> list[tuple[str, str]]:
    if not drawn:
        return []
    problem = drawn[0].trajectory.problem
    entries = [
        ("start", "start"),
        ("goal", "goal and tolerance"),
        ("solved", "end, solved"),
        ("failed", "end, failed"),
    ]
    if problem.obstacles:
        entries.append(("obstacle", "obstacle"))
    if any(obstacle.moving for obstacle in problem.obstacles):
        entries.append(("ghost", "moving obstacle, later"))
    if any(trial.outcome in CONTACTS for trial in drawn):
        entries.append(("collision", "collision"))
    return entries
