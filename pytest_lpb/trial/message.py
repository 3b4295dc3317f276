"""How a trial ended, as a person would say it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pytest_lpb.environment.monitor import Violation
from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.trajectory import FloatArray, Trajectory

STUCK_SHARE = 0.2  # of the duration without getting nearer, from which on a trial was stuck
PROGRESS = 0.01  # of the way made in all, which counts as getting nearer
AT_LIMIT = 0.02  # [rad or m] from a position limit, within which a joint is at it
LARGEST_IN_FULL = 1e4  # [m or rad] beyond, distances are written with an exponent


def outcome_message(trajectory: Trajectory, violation: Violation | None, fault: str) -> str:
    """One sentence about a trial's outcome, with the figures that explain it."""
    outcome = trajectory.outcome
    if outcome in _VIOLATIONS and violation is not None:
        return f"{_VIOLATIONS[outcome](trajectory, violation)}, {_distance_left(trajectory, violation.row)}"
    if outcome in _SENTENCES:
        return _SENTENCES[outcome](trajectory)
    return f"{outcome.replace('_', ' ')} at t = {_end_time(trajectory):.4g} s: {fault}"


def _collision(trajectory: Trajectory, violation: Violation) -> str:
    _, body, obstacle = violation.clearance
    return f"{body!r} hit obstacle {obstacle!r} {_contact(trajectory, violation)}"


def _self_collision(trajectory: Trajectory, violation: Violation) -> str:
    _, body, other = violation.clearance
    return f"{body!r} hit {other!r} {_contact(trajectory, violation)}"


def _contact(trajectory: Trajectory, violation: Violation) -> str:
    """When two bodies first touched, and how they are at the row after that."""
    distance, row_time = violation.clearance[0], float(trajectory.t[violation.row])
    time = row_time if violation.time is None else violation.time
    if distance < 0.0:
        return f"at t = {time:.4g} s ({-distance:.2g} m deep)"
    return f"at t = {time:.4g} s, between two rows ({distance:.2g} m apart again at t = {row_time:.4g} s)"


def _joint_limit(trajectory: Trajectory, violation: Violation) -> str:
    joint = violation.joint or 0
    robot = trajectory.problem.robot
    lower, upper = robot.limits.position[joint]
    value = trajectory.q[violation.row, joint]
    return (
        f"joint {robot.joint_names[joint]!r} at {value:.4g} left its limits [{lower:g}, {upper:g}] "
        f"at t = {trajectory.t[violation.row]:.4g} s"
    )


_VIOLATIONS: dict[str, Callable[[Trajectory, Violation], str]] = {
    "collision": _collision,
    "self_collision": _self_collision,
    "joint_limit": _joint_limit,
}


def _success(trajectory: Trajectory) -> str:
    row = trajectory.goal_row or 0
    return f"reached the goal after {trajectory.t[row]:.4g} s{_closest(trajectory)}"


def _timeout(trajectory: Trajectory) -> str:
    return f"reached {_at_the_end(trajectory)}"


def _stalled(trajectory: Trajectory) -> str:
    return f"came to a standstill {_at_the_end(trajectory)}"


def _at_the_end(trajectory: Trajectory) -> str:
    left = f"{_distance_left(trajectory, -1)} after {_end_time(trajectory):.1f} s"
    return f"{left}{_not_held(trajectory)}{_stuck(trajectory)}{_at_limits(trajectory)}{_closest(trajectory)}"


def _not_held(trajectory: Trajectory) -> str:
    """For how long the goal was reached, though not for the hold time; empty for a goal that never was."""
    problem = trajectory.problem
    within = np.logical_and.reduce([trajectory.within(goal) for goal in problem.goal])
    if not within.any():
        return ""
    hold = "end" if problem.hold_time == "end" else f"{problem.hold_time:g} s"
    outside = np.flatnonzero(~within)
    if within[-1]:
        entered = int(outside[-1]) + 1 if len(outside) else 0
        return f", in the goal for the last {_seconds(trajectory, entered, -1)}; hold_time is {hold}"
    edges = np.flatnonzero(np.diff(np.concatenate(([False], within, [False])).astype(int)))
    starts, ends = edges[::2], edges[1::2] - 1
    longest = int(np.argmax(ends - starts))
    first, last = int(starts[longest]), int(ends[longest])
    if first == last:
        return f", in the goal at t = {trajectory.t[first]:.4g} s and out of it a step later; hold_time is {hold}"
    found = f"{_seconds(trajectory, first, last)} from t = {trajectory.t[first]:.4g} s"
    return f", in the goal for {'' if len(starts) == 1 else 'at most '}{found}; hold_time is {hold}"


def _seconds(trajectory: Trajectory, first: int, last: int) -> str:
    return f"{float(trajectory.t[last] - trajectory.t[first]):.3g} s"


def _stuck(trajectory: Trajectory) -> str:
    """Since when the robot had not come nearer to its goal, if that is long: what local minima and cycles look like."""
    primary = trajectory.problem.primary
    if primary.moving:
        return ""
    errors = zip(primary.components, trajectory.goal_errors(primary), strict=True)
    left = [error for part, error in errors if part.tolerance is None or not error[-1] <= part.tolerance]
    if not left:
        return ""
    since = max(float(trajectory.t[_nearest_row(error)]) for error in left)
    if _end_time(trajectory) - since < STUCK_SHARE * trajectory.problem.duration:
        return ""
    return f", no nearer since t = {since:.4g} s: a local minimum or a cycle"


def _nearest_row(error: FloatArray) -> int:
    """First row that is as near to the goal as the robot ever came, but for `PROGRESS`."""
    nearest = float(error.min())
    return int(np.argmax(error <= nearest + PROGRESS * (float(error[0]) - nearest)))


def _at_limits(trajectory: Trajectory) -> str:
    """Joints that ended at their limits."""
    robot = trajectory.problem.robot
    lower, upper = robot.limits.position.T
    margin = np.minimum(trajectory.q[-1] - lower, upper - trajectory.q[-1])
    at = [name for name, left in zip(robot.joint_names, margin, strict=True) if left < AT_LIMIT]
    return f", {' and '.join(map(repr, at))} at the limit" if at else ""


_SENTENCES: dict[str, Callable[[Trajectory], str]] = {
    "success": _success,
    "timeout": _timeout,
    "stalled": _stalled,
}


def _distance_left(trajectory: Trajectory, row: int) -> str:
    """The primary goal's distance at a row; with other sub-goals, those outside their tolerance too."""
    primary = trajectory.problem.primary
    parts = [f"{_errors(trajectory, primary, row)} from the goal{_tolerance(primary)}"]
    missed = [goal for goal in trajectory.problem.goal if goal is not primary and not trajectory.within(goal)[row]]
    parts += [f"{_errors(trajectory, goal, row)} from {goal.name!r}{_tolerance(goal)}" for goal in missed]
    return " and ".join(parts)


def _errors(trajectory: Trajectory, goal: SubGoal, row: int) -> str:
    errors = zip(goal.components, trajectory.goal_errors(goal), strict=True)
    return " and ".join(f"{_distance(error[row])} {part.unit}" for part, error in errors)


def _tolerance(goal: SubGoal) -> str:
    if goal.tolerance is None:
        return ""
    given = (f"{_distance(part.tolerance or 0.0)} {part.unit}" for part in goal.components)
    return f" (tolerance {' and '.join(given)})"


def _closest(trajectory: Trajectory) -> str:
    clearance = trajectory.clearance
    if not len(clearance) or np.isnan(clearance).all():
        return ""
    row = int(np.nanargmin(clearance))
    name = trajectory.column("clearance_obstacle")[row]
    return f"; closest obstacle {name!r} at {_distance(clearance[row])} m"


def _distance(value: float) -> str:
    """A distance as text; one that diverged is no row of 300 digits."""
    return f"{value:.2f}" if abs(value) < LARGEST_IN_FULL else f"{value:.3g}"


def _end_time(trajectory: Trajectory) -> float:
    return float(trajectory.t[-1])
