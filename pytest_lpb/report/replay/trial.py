"""One trial as the page replays it: poses over time, the path, charts; and the problem it was run on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.environment.framing import with_neighbours
from pytest_lpb.errors import LpbError
from pytest_lpb.report.numbers import finite
from pytest_lpb.report.replay.charts import charts, diagnostics_left_out
from pytest_lpb.report.replay.motion import Motion
from pytest_lpb.report.replay.numbers import fine_step, listed
from pytest_lpb.report.scene_marks import configurations, finite_rows, goal_points, primary_link

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle
    from pytest_lpb.problem.problem import Problem
    from pytest_lpb.trajectory import Trajectory

FloatArray = NDArray[np.float64]

MAX_FRAMES = 120
MAX_PATH_POINTS = 200
MAX_TRACK_POINTS = 100  # of what moves by itself
POSITION_PARTS = 4000  # in which the size of the scene is told
ANGLE_STEP = 1e-3  # [rad], and of quaternions
FARTHEST = 3.0  # sizes of the fixed scene from its middle beyond which paths are not followed


def trial_block(trajectory: Trajectory, motion: Motion) -> dict[str, Any]:
    """Poses of the bodies, the goal link's path, and charts."""
    rows = finite_rows(trajectory)
    t, q = trajectory.t, configurations(trajectory)
    low, high = bounds(trajectory, motion)
    frames = _spread(rows, MAX_FRAMES)
    poses = motion.poses(trajectory.problem.robot, q[frames])
    path_rows = _spread(rows, MAX_PATH_POINTS)
    dimension = trajectory.problem.dimension
    path = trajectory.link(primary_link(trajectory))[path_rows, :dimension]
    step = fine_step(np.array([0.0, float((high - low).max())]), POSITION_PARTS)
    time_step = fine_step(np.diff(t[:2]), 1)
    return {
        "t": listed(t[frames], time_step),
        **_listed_poses(_within(poses, low, high), step, dimension),
        "path": {"t": listed(t[path_rows], time_step), "at": listed(_within(path, low, high), step)},
        "end": round(float(t[-1]), 6),
        "low": np.round(low, 4).tolist(),
        "high": np.round(high, 4).tolist(),
        "touched": _touched(trajectory),
        "contact": finite(trajectory.contact_time),
        "charts": charts(trajectory),
        "more": diagnostics_left_out(trajectory),
    }


def scene_block(trajectory: Trajectory, motion: Motion) -> dict[str, Any]:
    """Obstacles and the goal of a problem."""
    problem = trajectory.problem
    low, high = bounds(trajectory, motion)
    step = fine_step(np.array([0.0, float((high - low).max())]), POSITION_PARTS)
    whole = _everything(trajectory, motion)
    return {
        "dimension": problem.dimension,
        "low": np.round(whole[0], 4).tolist(),
        "high": np.round(whole[1], 4).tolist(),
        "obstacles": [_obstacle(obstacle, problem, motion, step) for obstacle in problem.obstacles],
        "goal": _goal(trajectory, step),
    }


def robot_block(trajectory: Trajectory, motion: Motion) -> dict[str, Any]:
    """The parts of the robot, and where it heads."""
    robot = trajectory.problem.robot
    return {"parts": motion.robot(robot), "heading": motion.heading(robot)}


def bounds(trajectory: Trajectory, motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Corners (2 or 3,) [m] of what is to be seen: the robot on its way unless it runs far away, its goal, and
    obstacles near them."""
    robot = trajectory.problem.robot
    q = configurations(trajectory)[_spread(finite_rows(trajectory), MAX_FRAMES)]
    goal = goal_points(trajectory)
    goal = goal[np.isfinite(goal).all(axis=1)]
    tolerance = trajectory.problem.primary.tolerance or 0.0
    fixed = np.concatenate([motion.extent(robot, q[:1]), goal - tolerance, goal + tolerance])
    low, high = fixed.min(axis=0), fixed.max(axis=0)
    reach = max(FARTHEST * float((high - low).max()), 1.0)
    points = motion.extent(robot, q)
    near = points[(np.abs(points - 0.5 * (low + high)) < reach).all(axis=1)]
    low, high = np.minimum(low, near.min(axis=0, initial=np.inf)), np.maximum(high, near.max(axis=0, initial=-np.inf))
    standing = [obstacle for obstacle in trajectory.problem.obstacles if not obstacle.moving]
    return with_neighbours(low, high, (_box(_around(motion, it, np.zeros(1))) for it in standing))


def _everything(trajectory: Trajectory, motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Corners (2 or 3,) [m] of the frame with all obstacles, wherever they move."""
    low, high = bounds(trajectory, motion)
    times = np.linspace(0.0, float(trajectory.t[-1]), 25)
    obstacles = trajectory.problem.obstacles
    boxes = [_box(_around(motion, it, times if it.moving else times[:1])) for it in obstacles]
    return (
        np.array([low, *(box[0] for box in boxes)]).min(axis=0),
        np.array([high, *(box[1] for box in boxes)]).max(axis=0),
    )


def _box(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    return points.min(axis=0), points.max(axis=0)


def _around(motion: Motion, obstacle: Obstacle, t: FloatArray) -> FloatArray:
    try:
        return motion.around(obstacle, t)
    except (LpbError, OSError):  # the file of a mesh is gone
        return obstacle.poses(t)[0]


def _spread(rows: NDArray[np.intp], most: int) -> NDArray[np.intp]:
    """At most `most` of the rows, evenly taken, the first and the last among them."""
    return rows[np.unique(np.round(np.linspace(0, len(rows) - 1, most)).astype(int))] if len(rows) > most else rows


def _within(values: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Positions (in the first numbers of the last axis) clipped to where they are still worth telling."""
    size = float((high - low).max())
    result = values.copy()
    axes = len(low)
    result[..., :axes] = np.clip(values[..., :axes], low - 2.0 * size, high + 2.0 * size)
    return result


def _listed_poses(poses: FloatArray, step: float, dimension: int) -> dict[str, Any]:
    """Positions and turns of bodies (N, bodies, numbers), or of one (N, numbers)."""
    rows = len(poses)
    return {
        "at": listed(poses[..., :dimension].reshape(rows, -1), step),
        "turn": listed(poses[..., dimension:].reshape(rows, -1), ANGLE_STEP),
    }


def _obstacle(obstacle: Obstacle, problem: Problem, motion: Motion, step: float) -> dict[str, Any]:
    times = np.linspace(0.0, problem.duration, MAX_TRACK_POINTS) if obstacle.moving else np.zeros(1)
    return {
        "name": obstacle.name,
        "parts": motion.obstacle(obstacle),
        "duration": problem.duration if obstacle.moving else 0.0,
        **_listed_poses(motion.obstacle_poses(obstacle, times), step, problem.dimension),
    }


def _goal(trajectory: Trajectory, step: float) -> dict[str, Any] | None:
    points = goal_points(trajectory)
    if len(points) == 0 or not np.isfinite(points).any():
        return None
    goal = trajectory.problem.primary
    rows = _spread(np.arange(len(points)), MAX_TRACK_POINTS) if goal.moving else np.zeros(1, dtype=int)
    return {
        "tolerance": goal.tolerance,
        "t": listed(trajectory.t[rows], fine_step(np.diff(trajectory.t[:2]), 1)),
        "at": listed(points[rows], step),
    }


def _touched(trajectory: Trajectory) -> str | None:
    """Name of the obstacle that ended the trial."""
    names = trajectory.columns.get("clearance_obstacle")
    if trajectory.outcome != "collision" or names is None:
        return None
    clearance = trajectory.step_clearance
    touching = np.flatnonzero(clearance <= 0.0)
    return str(names[touching[0]]) if len(touching) else None
