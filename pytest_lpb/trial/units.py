"""Units of the columns of a trial file."""

from __future__ import annotations

from pytest_lpb.problem.problem import Problem

_BY_SUFFIX = {
    "_ms": "ms",
    "_m": "m",
    "_x": "m",
    "_y": "m",
    "_z": "m",
    "_theta": "rad",
    **dict.fromkeys(("_qw", "_qx", "_qy", "_qz"), ""),
}
_LENGTH_OR_ANGLE = {"prismatic": "m", "revolute": "rad"}
_FORCE = {"prismatic": "N", "revolute": "N m"}


def unit_of(column: str, problem: Problem) -> str:
    """Unit of a column; empty for text, and for what a planner records."""
    if column == "t":
        return "s"
    if column.startswith(("planner_", "clearance_body", "clearance_obstacle")):
        return ""
    if column.startswith("goal_"):
        return _goal_unit(column, problem)
    for suffix, unit in _BY_SUFFIX.items():
        if column.endswith(suffix):
            return unit
    prefix, index = column.rstrip("0123456789"), int(column[len(column.rstrip("0123456789")) :])
    kinds = problem.robot.joint_types
    if prefix == "q":
        return _LENGTH_OR_ANGLE[kinds[index]]
    if prefix == "qd":
        return f"{_LENGTH_OR_ANGLE[kinds[index]]}/s"
    kind = problem.robot.action_kinds[index]
    if prefix != "u" and problem.control == "torque":
        return _FORCE[kind]
    unit = _LENGTH_OR_ANGLE[kind]
    return f"{unit}/s" if prefix == "u" or problem.control == "velocity" else f"{unit}/s^2"


def _goal_unit(column: str, problem: Problem) -> str:
    # Of `reach` and `reach_angle` the column goal_reach_angle_0 belongs to the longer one.
    owners = [goal for goal in problem.goal if column.startswith(f"goal_{goal.name}_")]
    if not owners:
        return ""
    goal = max(owners, key=lambda goal: len(goal.name))
    quaternion = goal.type == "orientation" and problem.dimension == 3
    return "" if quaternion and not column.endswith("_error") else goal.unit
