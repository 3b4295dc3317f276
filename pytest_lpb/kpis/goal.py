"""KPIs about the goal: how soon, how near, how well followed."""

from __future__ import annotations

import math

import numpy as np

from pytest_lpb.kpis.derived import measured, once, smallest, time_average
from pytest_lpb.kpis.path import path_length_to_goal
from pytest_lpb.kpis.registry import kpi
from pytest_lpb.trajectory import FloatArray, Trajectory


@once
def _primary_errors(trajectory: Trajectory) -> dict[str, FloatArray]:
    """Errors of the primary goal by unit, each (N + 1,)."""
    goal = trajectory.problem.primary
    return dict(zip(goal.units, map(measured, trajectory.goal_errors(goal)), strict=True))


def _final(trajectory: Trajectory, unit: str) -> float:
    errors = _primary_errors(trajectory)
    return float(errors[unit][-1]) if unit in errors else math.nan


def _least(trajectory: Trajectory, unit: str) -> float:
    errors = _primary_errors(trajectory)
    return smallest(errors[unit]) if unit in errors else math.nan


@kpi("time_to_goal_s", "s", "lower", "all", group="goal", restricted_to_duration=True)
def time_to_goal(trajectory: Trajectory) -> float:
    """Start of the first interval within every tolerance that lasts the hold time [s]; NaN without one."""
    row = trajectory.goal_row
    return math.nan if row is None else float(trajectory.t[row])


@kpi("final_goal_distance_m", "m", "lower", "all", group="goal")
def final_goal_distance(trajectory: Trajectory) -> float:
    """Error of the primary goal in the last row [m]; NaN for a goal in rad."""
    return _final(trajectory, "m")


@kpi("min_goal_distance_m", "m", "lower", "all", group="goal")
def min_goal_distance(trajectory: Trajectory) -> float:
    """Smallest error of the primary goal in any row [m]; NaN for a goal in rad."""
    return _least(trajectory, "m")


@kpi("final_goal_error_rad", "rad", "lower", "all", group="goal")
def final_goal_error(trajectory: Trajectory) -> float:
    """Error of the primary goal in the last row [rad]; NaN for a goal in m."""
    return _final(trajectory, "rad")


@kpi("min_goal_error_rad", "rad", "lower", "all", group="goal")
def min_goal_error(trajectory: Trajectory) -> float:
    """Smallest error of the primary goal in any row [rad]; NaN for a goal in m."""
    return _least(trajectory, "rad")


@once
def _tracking_error(trajectory: Trajectory) -> FloatArray | None:
    """Error [m] of a moving primary goal from the first row within its tolerance on; else None."""
    goal = trajectory.problem.primary
    if not goal.moving or "m" not in goal.units or goal.tolerance is None:
        return None
    error = _primary_errors(trajectory)["m"]
    entered = np.flatnonzero(trajectory.within(goal))
    return error[entered[0] :] if len(entered) else None


@kpi("tracking_error_mean_m", "m", "lower", "solved", group="goal")
def tracking_error_mean(trajectory: Trajectory) -> float:
    """Time average of a moving primary goal's error from the first entry into its tolerance on [m]."""
    error = _tracking_error(trajectory)
    return math.nan if error is None else time_average(error)


@kpi("tracking_error_rms_m", "m", "lower", "solved", group="goal")
def tracking_error_rms(trajectory: Trajectory) -> float:
    """Root mean square over time of a moving primary goal's error from the first entry on [m]."""
    error = _tracking_error(trajectory)
    return math.nan if error is None else math.sqrt(time_average(error**2))


@kpi("spl", "1", "higher", "all", group="goal")
def success_weighted_path_length(trajectory: Trajectory) -> float:
    """Success weighted by path length, S L* / max(L, L*); NaN unless the scenario carries a certified path.

    Anderson et al. 2018, "On Evaluation of Embodied Navigation Agents". L is the path length to the goal, L*
    that of the certified path.
    """
    shortest = trajectory.problem.certified_path_length_m
    if shortest is None:
        return math.nan
    length = path_length_to_goal(trajectory)
    # While the criteria of success are judged, spl among them, there is no verdict yet.
    solved = trajectory.metadata.get("success", trajectory.outcome == "success")
    if not solved or math.isnan(length):
        return 0.0
    return shortest / max(length, shortest) if shortest > 0.0 else float(length == 0.0)
