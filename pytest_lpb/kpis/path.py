"""KPIs about the path: how far the link of the primary goal, and the joints, have moved."""

from __future__ import annotations

import math

import numpy as np

from pytest_lpb.kpis.derived import measured, norms, of_joint_type, positions, segment_lengths
from pytest_lpb.kpis.registry import kpi
from pytest_lpb.trajectory import Trajectory

# [m] How far the recorded error of a goal in the world may be from the distance of its link: rounding.
SAME_DISTANCE = 1e-6


@kpi("path_length_m", "m", "lower", "solved", group="path")
def path_length(trajectory: Trajectory) -> float:
    """Length of the polyline through all p_k [m]."""
    return float(segment_lengths(trajectory).sum())


@kpi("path_length_to_goal_m", "m", "lower", "solved", group="path")
def path_length_to_goal(trajectory: Trajectory) -> float:
    """Length of the polyline through p_k up to time_to_goal [m]; NaN when the goal is not reached."""
    row = trajectory.goal_row
    return math.nan if row is None else float(segment_lengths(trajectory)[:row].sum())


def _joint_path_length(trajectory: Trajectory, joint_type: str) -> float:
    joints = of_joint_type(trajectory, joint_type)
    if not joints.any():
        return math.nan
    return float(norms(np.diff(measured(trajectory.q[:, joints]), axis=0)).sum())


@kpi("joint_path_length_rad", "rad", "lower", "solved", group="path")
def joint_path_length_rad(trajectory: Trajectory) -> float:
    """Length of the polyline in the space of revolute joints [rad]; NaN without any."""
    return _joint_path_length(trajectory, "revolute")


@kpi("joint_path_length_m", "m", "lower", "solved", group="path")
def joint_path_length_m(trajectory: Trajectory) -> float:
    """Length of the polyline in the space of prismatic joints, points and bases [m]; NaN without any."""
    return _joint_path_length(trajectory, "prismatic")


@kpi("path_length_ratio", "1", "lower", "solved", group="path")
def path_length_ratio(trajectory: Trajectory) -> float:
    """Path length to the goal over the straight line between the ends of that path, sum ‖Δp_k‖ / ‖p_K − p_0‖ >= 1.

    K is the row of time_to_goal, when the tolerance is entered: the target itself may be nearer or farther. NaN
    unless the primary goal is a place in the world for the frame of its link (no single axis, no point beside the
    frame, not relative to another link), farther from p_0 than its tolerance.
    """
    problem, row = trajectory.problem, trajectory.goal_row
    goal = problem.primary
    if row is None or goal.type != "position":
        return math.nan
    path, targets = positions(trajectory)[:, : problem.dimension], trajectory.goal(goal.name)
    error = trajectory.goal_errors(goal)[0][0]
    if targets.shape[1] != path.shape[1] or abs(math.dist(path[0], targets[0]) - error) > SAME_DISTANCE:
        return math.nan
    straight = math.dist(path[0], path[row])
    if straight == 0.0 or math.dist(path[0], targets[row]) <= (goal.tolerance or 0.0):
        return math.nan
    # Rounding may leave the sum of the steps a little below the line that they add up to.
    return max(1.0, path_length_to_goal(trajectory) / straight)
