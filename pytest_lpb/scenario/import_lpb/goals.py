"""Sub-goals of an experiment as sub-goals of a scenario file."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pytest_lpb.names import is_name
from pytest_lpb.scenario.import_lpb.fields import Fields, ranges_between
from pytest_lpb.scenario.import_lpb.motions import LostError, motion_of
from pytest_lpb.scenario.import_lpb.robots import BenchRobot, Frame

JOINT_SPACE = "staticJointSpaceSubGoal"


@dataclass
class Goals:
    """What became of an experiment's `goal`.

    Attributes:
        goals: sub-goals of the scenario file.
        ranges: `randomize.goal`, or nothing.
        lost: what has no place in a scenario file.
        notes: what has one, but means something slightly different.
    """

    goals: list[dict[str, Any]] = field(default_factory=list)
    ranges: Any = None
    lost: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def goals_of(experiment: Fields, robot: BenchRobot, count: int) -> Goals:
    """All sub-goals. Raises LpbError for wrong ones, and when none is left or none has a tolerance."""
    experiment.needed("goal")
    result = Goals()
    for name, fields in experiment.below("goal").mappings().items():
        convert = _joint_goal if _is_joint_space(fields) else _position_goal
        try:
            goal = convert(fields, robot, count, result)
        except LostError as error:
            result.lost.append(str(error))
            continue
        primary = bool(fields.get(fields.first("is_primary_goal", "prime")))
        if primary and any(other["primary"] for other in result.goals):
            result.lost.append(f"{fields.name}: that it is primary, too; the first one is")
            primary = False
        weight = fields.first("weight", "w")
        goal |= {"weight": fields.number(weight, 1.0), "primary": primary}
        if goal["weight"] < 0.0:
            raise fields.error(f"found {goal['weight']:g}; a weight is not below 0", weight)
        if "epsilon" in fields:
            goal["tolerance"] = fields.positive("epsilon")
        result.goals.append({"name": name if is_name(name) else f"goal{len(result.goals)}", **goal})
        if primary:
            result.ranges = _ranges(fields, goal, robot, count, result)
    if not result.goals:
        reasons = "; ".join(result.lost) or "it is empty"
        raise experiment.error(f"no sub-goal of it can be converted: {reasons}", "goal")
    if all("tolerance" not in goal for goal in result.goals):
        raise experiment.error("no sub-goal has an epsilon; success is undefined without", "goal")
    return result


def _is_joint_space(fields: Fields) -> bool:
    return fields.get("type") == JOINT_SPACE or fields.get("jointSpace") is True


def _joint_goal(fields: Fields, robot: BenchRobot, count: int, result: Goals) -> dict[str, Any]:
    """A configuration: the entries of q that `indices` names."""
    joints = robot.joints(count)
    target = fields.numbers("desired_position")
    indices = _indices(fields, len(joints)) if "indices" in fields else list(range(len(target)))
    if len(indices) != len(target) or len(target) > len(joints):
        raise fields.error(
            f"found {len(target)} numbers for {len(indices)} of {len(joints)} joints", "desired_position"
        )
    result.notes.append(f"{fields.name}: epsilon bounds the largest joint error here, the norm of all errors there")
    return {"type": "joint", "joints": [joints[index] for index in indices], "target": target}


def _position_goal(fields: Fields, robot: BenchRobot, count: int, result: Goals) -> dict[str, Any]:
    """Coordinates of a frame, in the world's axes, that `indices` names."""
    parent = robot.frame(fields, ["parent_link"], fields.get("parent_link") or 0, count)
    child = robot.frame(fields, ["child_link"], fields.needed("child_link"), count)
    if child.link is None:
        raise fields.error("found the world; a link of the robot is required", "child_link")
    indices = _indices(fields, robot.dimension)
    offset = _still(parent, robot, count)
    if offset is None:
        raise LostError(f"{fields.name}, which is relative to a moving link in the world's axes")
    if fields.get("angle") is not None:
        result.lost.append(f"{fields.name}.angle, an orientation beside the position")
    place, notes = motion_of(fields, "desired_position", "target", offset[indices], len(indices))
    result.notes.extend(notes)
    goal: dict[str, Any] = {"type": "position", "link": child.link, **place}
    if any(child.point):
        goal["point"] = list(child.point[: robot.dimension])
    if indices != list(range(robot.dimension)):
        goal["axes"] = indices
    return goal


def _still(parent: Frame, robot: BenchRobot, count: int) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    """Where the frame that a target is relative to stands, (dimension,) [m]; None when it moves."""
    fixed_base = robot.frames(count)[0].link
    if parent.link is not None and parent.link != fixed_base:
        return None
    return np.array(parent.point[: robot.dimension])


def _indices(fields: Fields, size: int) -> list[int]:
    given = [int(number) for number in fields.numbers("indices")]
    if not given or len(set(given)) < len(given) or not all(0 <= index < size for index in given):
        raise fields.error(f"found {given}; allowed: different numbers of 0 to {size - 1}", "indices")
    return given


def _ranges(fields: Fields, goal: dict[str, Any], robot: BenchRobot, count: int, result: Goals) -> Any:
    """`randomize.goal` from the primary sub-goal's `low` and `high`."""
    if "low" not in fields or "high" not in fields:
        return None
    ranges = ranges_between(fields, "low", fields, "high")
    whole = len(ranges) == (len(robot.joints(count)) if goal["type"] == "joint" else robot.dimension)
    if "target" not in goal or not whole or len(ranges) != len(goal["target"]):
        result.lost.append(f"{fields.name}.low and .high, which are no ranges of all that its target has")
        return None
    return {"q": ranges} if goal["type"] == "joint" else ranges
