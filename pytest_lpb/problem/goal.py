"""Sub-goals: a target that may move, and how far the robot is from it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any, ClassVar

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion import Motion, motion_from
from pytest_lpb.problem.registries import goals
from pytest_lpb.problem.robot import FloatArray, Robot

# (dimension, type) -> "module:Class". A new sub-goal type is one class and one line here.
GOAL_TYPES: dict[tuple[int, str], str] = {
    (2, "position"): "pytest_lpb.problem.planar.goals:PositionGoal",
    (2, "orientation"): "pytest_lpb.problem.planar.goals:OrientationGoal",
    (2, "joint"): "pytest_lpb.problem.joint_goal:JointGoal",
    (2, "alignment"): "pytest_lpb.problem.planar.goals:AlignmentGoal",
    (3, "position"): "pytest_lpb.problem.spatial.goals:PositionGoal",
    (3, "orientation"): "pytest_lpb.problem.spatial.goals:OrientationGoal",
    (3, "joint"): "pytest_lpb.problem.joint_goal:JointGoal",
    (3, "alignment"): "pytest_lpb.problem.spatial.goals:AlignmentGoal",
}


class SubGoal(ABC):
    """One constraint of a composed goal.

    Args:
        entry: the sub-goal's entry in a concrete problem.
        robot: the robot it speaks of.
    """

    unit: ClassVar[str]  # of the error: m or rad

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        self.name: str = entry["name"]
        self.type: str = entry["type"]
        self.link: str | None = entry.get("link")
        self.tolerance: float | None = entry.get("tolerance")
        self.weight: float = float(entry.get("weight", 1.0))
        self.primary: bool = bool(entry.get("primary", False))
        self.motion: Motion = self._motion(entry)
        self.robot = robot

    @property
    def moving(self) -> bool:
        """Whether the target depends on time."""
        return self.motion.moving

    def _motion(self, entry: Mapping[str, Any]) -> Motion:
        return motion_from(entry, key="target")

    def beyond_reach(self, target: Sequence[float] | FloatArray) -> bool:  # noqa: ARG002
        """Whether no configuration of the robot can be within tolerance of a target; False when it is not obvious."""
        return False

    @abstractmethod
    def value(self, q: Sequence[float], frames: Any) -> list[float]:
        """What the robot has now, in the target's coordinates; `frames` are the engine's link frames."""

    @abstractmethod
    def distance(self, value: Sequence[float], target: Sequence[float]) -> float:
        """Distance of a value to a target, in the sub-goal's unit [m or rad]."""

    def residual(self, value: Sequence[float], target: Sequence[float]) -> list[float]:
        """What the value is away from the target, as numbers that a small motion changes smoothly [m or rad]."""
        return [have - want for have, want in zip(value, target, strict=True)]


def goal_from(entries: Sequence[Mapping[str, Any]], robot: Robot) -> tuple[SubGoal, ...]:
    """The sub-goals of a concrete problem; exactly one of them is primary."""
    found = [_class_of(entry["type"], robot.dimension)(entry, robot) for entry in entries]
    if not any(goal.primary for goal in found):
        found[0].primary = True
    return tuple(found)


def _class_of(kind: str, dimension: int) -> Callable[[Mapping[str, Any], Robot], SubGoal]:
    """The class of a type of sub-goals. Raises ScenarioError for one that is unknown here."""
    target = GOAL_TYPES.get((dimension, kind))
    if target is not None:
        module, _, name = target.partition(":")
        built_in: type[SubGoal] = getattr(import_module(module), name)
        return built_in
    registered = goals.get(kind)
    if registered is None:
        raise ScenarioError(f"unknown type of sub-goal {kind!r}: what registers it is not loaded")
    return registered.create
