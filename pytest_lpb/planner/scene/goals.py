"""Sub-goals as errors x(q, target) that are zero where they are met; one function per type and dimension.

Turns are measured so that the error is smooth everywhere: the length of a space rotation's error is 2 sin(angle/2).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import sqrt
from typing import Any

import casadi

from pytest_lpb.planner.base import GoalInfo
from pytest_lpb.planner.scene.maps import State
from pytest_lpb.planner.scene.parts import heading
from pytest_lpb.planner.scene.robot_parts import steered
from pytest_lpb.planner.scene.shapes import length
from pytest_lpb.symbolic.kinematics import turn_of_quaternion

# (state, sub-goal, target, lookahead [m]) -> error (m, 1)
Error = Callable[[State, GoalInfo, Any, float], Any]

NEAREST_SHARE = 0.5  # of the distance to the goal: the lookahead there, so that a base faces the goal as it arrives


def _position(state: State, goal: GoalInfo, target: Any, lookahead: float) -> Any:
    frames, entry = state.frames, goal.entry
    dimension = state.robot.dimension
    point = tuple(entry.get("point") or (0.0,) * dimension)[:dimension]
    position = frames.point(goal.link or "", point)
    reference = entry.get("relative_to")
    if reference not in (None, "world"):
        origin, turn = frames.of(str(reference))
        position = turn.T @ (position - origin)
    axes = list(entry.get("axes") or range(dimension))
    error = position[axes] - target
    if lookahead > 0.0 and steered(state.robot) and axes[:2] == [0, 1] and reference in (None, "world"):
        error[:2] += _ahead(state, error[:2], lookahead)
    return error


def _ahead(state: State, error: Any, lookahead: float) -> Any:
    """What a base that cannot move sideways is steered by: the point ahead of it, nearer the nearer the goal.

    With at most half of the distance left the error vanishes at the goal only (input-output linearisation with a fixed
    distance would miss it by that distance: Siciliano et al., "Robotics", 2009, section 11.6.1).
    """
    distance = length(error)
    ahead = NEAREST_SHARE * distance * lookahead / (NEAREST_SHARE * distance + lookahead)
    return ahead * heading(state.frames)[:2]


def _angle(angle: Any) -> Any:
    """An angle wrapped to [-pi, pi], differentiable but at its ends."""
    return casadi.atan2(casadi.sin(angle), casadi.cos(angle))


def _planar_orientation(state: State, goal: GoalInfo, target: Any, lookahead: float) -> Any:  # noqa: ARG001
    rotation = state.frames.of(goal.link or "")[1]
    c, s = casadi.cos(target), casadi.sin(target)
    return casadi.atan2(c * rotation[1, 0] - s * rotation[0, 0], c * rotation[0, 0] + s * rotation[1, 0])


def _orientation(state: State, goal: GoalInfo, target: Any, lookahead: float) -> Any:  # noqa: ARG001
    # |R - R_target| = 2 sqrt(2) sin(angle / 2), Frobenius' norm
    difference = state.frames.of(goal.link or "")[1] - turn_of_quaternion(target / length(target))
    return casadi.reshape(difference, 9, 1) / sqrt(2.0)


def _axes(state: State, goal: GoalInfo) -> tuple[Any, Any]:
    """The two axes of an alignment in the world, of unit length."""
    frames, entry, dimension = state.frames, goal.entry, state.robot.dimension
    axis = frames.of(goal.link or "")[1] @ casadi.DM(list(entry["axis"])[:dimension])
    other: Any = casadi.SX(casadi.DM(list(entry["other_axis"])[:dimension]))
    if entry.get("other", "world") != "world":
        other = frames.of(str(entry["other"]))[1] @ other
    return axis / casadi.norm_2(axis), other / casadi.norm_2(other)


def _planar_alignment(state: State, goal: GoalInfo, target: Any, lookahead: float) -> Any:  # noqa: ARG001
    axis, other = _axes(state, goal)
    sine, cosine = other[0] * axis[1] - other[1] * axis[0], casadi.dot(axis, other)
    return _angle(casadi.atan2(sine, cosine) - target)


def _alignment(state: State, goal: GoalInfo, target: Any, lookahead: float) -> Any:  # noqa: ARG001
    # The target is an angle of zero; |a - b| = 2 sin(angle / 2).
    axis, other = _axes(state, goal)
    return axis - other


def _joint(state: State, goal: GoalInfo, target: Any, lookahead: float) -> Any:  # noqa: ARG001
    robot = state.robot
    errors = []
    for place, name in enumerate(goal.entry["joints"]):
        index = robot.joint_names.index(name)
        error = state.q[index] - target[place]
        errors.append(_angle(error) if index in robot.headings else error)
    return casadi.vertcat(*errors)


# One entry per dimension and type of sub-goal.
ERRORS: Mapping[tuple[int, str], Error] = {
    (2, "position"): _position,
    (2, "orientation"): _planar_orientation,
    (2, "alignment"): _planar_alignment,
    (2, "joint"): _joint,
    (3, "position"): _position,
    (3, "orientation"): _orientation,
    (3, "alignment"): _alignment,
    (3, "joint"): _joint,
}
