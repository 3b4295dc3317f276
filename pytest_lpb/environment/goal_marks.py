"""Where the sub-goals of a spatial problem lie, for pictures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.goals import OrientationGoal, PositionGoal
from pytest_lpb.problem.spatial.rotations import matrix_of, normalised


@dataclass(frozen=True, eq=False)
class GoalMark:
    """A place to show.

    Attributes:
        position: (3,) [m], in the world.
        radius: the tolerance [m]; 0 for an orientation, or without one.
        rotation: (3, 3) of the frame wanted there; None: any will do.
    """

    position: FloatArray
    radius: float = 0.0
    rotation: FloatArray | None = None


def goal_marks(problem: Problem, t: float, frames: FloatArray) -> Iterator[GoalMark]:
    """Marks of the sub-goals that have a place, at a time [s], for link poses (links, 4, 4)."""
    places: dict[str | None, FloatArray] = {}
    for goal, entry in zip(problem.goal, problem.entry["goal"], strict=True):
        if isinstance(goal, PositionGoal):
            place = _place(goal, entry.get("relative_to"), _target(goal, t), problem, frames)
            places.setdefault(goal.link, place)
            yield GoalMark(place, goal.tolerance or 0.0)
    for goal in problem.goal:
        if isinstance(goal, OrientationGoal) and goal.link is not None:
            here = frames[problem.robot.link_index(goal.link), :3, 3]
            turn = matrix_of(normalised(_target(goal, t).tolist()))
            yield GoalMark(places.get(goal.link, here), rotation=turn)


def _target(goal: SubGoal, t: float) -> FloatArray:
    return np.asarray(goal.motion.evaluate(np.array([t]))[0][0])


def _place(
    goal: PositionGoal, reference: str | None, target: FloatArray, problem: Problem, frames: FloatArray
) -> FloatArray:
    """The target in the world; along axes that it says nothing of, where the robot is."""
    names = problem.robot.link_names
    frame = frames[names.index(reference)] if reference in names else np.eye(4)
    now = np.linalg.inv(frame) @ traced_pose(goal, problem, frames)
    now[list(goal.axes), 3] = target
    return np.asarray((frame @ now)[:3, 3])


def traced_pose(goal: SubGoal, problem: Problem, frames: FloatArray) -> FloatArray:
    """Pose (4, 4) of what a goal speaks of: its link, or a point in it; the last link for goals of none."""
    names = problem.robot.link_names
    pose: FloatArray = frames[-1 if goal.link is None else names.index(goal.link)].copy()
    point = getattr(goal, "point", None)
    if point is not None:
        pose[:3, 3] += pose[:3, :3] @ point
    return pose
