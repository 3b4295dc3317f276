"""Units of the columns of a trial file."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.joint_goal import JOINT_UNITS, JointGoal
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
        return JOINT_UNITS[kinds[index]]
    if prefix == "qd":
        return f"{JOINT_UNITS[kinds[index]]}/s"
    kind = problem.robot.action_kinds[index]
    if prefix != "u" and problem.control == "torque":
        return _FORCE[kind]
    unit = JOINT_UNITS[kind]
    return f"{unit}/s" if prefix == "u" or problem.control == "velocity" else f"{unit}/s^2"


def _goal_unit(column: str, problem: Problem) -> str:
    for goal in problem.goal:
        prefix = f"goal_{goal.name}_"
        units = {f"{prefix}error": goal.unit} | {component.column: component.unit for component in goal.components}
        units |= {f"{prefix}{index}": unit for index, unit in enumerate(_target_units(goal, problem))}
        if column in units:
            return units[column]
    return ""


def _target_units(goal: SubGoal, problem: Problem) -> Sequence[str]:
    """Units of a target's coordinates; a quaternion has none."""
    if isinstance(goal, JointGoal):
        return goal.joint_units
    quaternion = goal.type == "orientation" and problem.dimension == 3
    return ("" if quaternion else goal.unit,) * goal.motion.size
