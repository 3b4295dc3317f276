"""Sub-goals: a target that may move, and how far the robot is from it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
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


@dataclass(frozen=True)
class ErrorComponent:
    """The part of a sub-goal's error that has one unit."""

    unit: str  # m or rad
    tolerance: float | None  # in this unit; None: a preference
    column: str  # of the trial file


class SubGoal(ABC):
    """One constraint of a composed goal.

    Args:
        entry: the sub-goal's entry in a concrete problem.
        robot: the robot it speaks of.
    """

    unit: ClassVar[str]  # of the error: m or rad; `m or rad` of joints of both types

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        self.name: str = entry["name"]
        self.type: str = entry["type"]
        self.link: str | None = entry.get("link")
        given: float | Mapping[str, float] | None = entry.get("tolerance")
        self._tolerances: Mapping[str, float] = given if isinstance(given, Mapping) else {}
        # Of a tolerance per unit the smaller one: within it, every unit is within its own.
        self.tolerance: float | None = min(given.values()) if isinstance(given, Mapping) else given
        self.weight: float = float(entry.get("weight", 1.0))
        self.primary: bool = bool(entry.get("primary", False))
        self.motion: Motion = self._motion(entry)
        self.robot = robot

    @property
    def moving(self) -> bool:
        """Whether the target depends on time."""
        return self.motion.moving

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the error: m, rad, or both."""
        return (self.unit,)

    @cached_property
    def components(self) -> tuple[ErrorComponent, ...]:
        """What the error consists of, by unit; the goal is reached where each component is within its tolerance."""
        column, apart = f"goal_{self.name}_error", len(self.units) > 1
        return tuple(
            ErrorComponent(unit, self._tolerances.get(unit, self.tolerance), f"{column}_{unit}" if apart else column)
            for unit in self.units
        )

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

    def errors(self, value: Sequence[float], target: Sequence[float]) -> tuple[float, ...]:
        """Distance of a value to a target, one number per entry of `components` [m or rad]."""
        return (self.distance(value, target),)

    def excess(self, value: Sequence[float], target: Sequence[float], share: float = 1.0) -> float:
        """How far the error exceeds a share of the tolerance, in its worst component; not positive: reached."""
        errors = zip(self.errors(value, target), self.components, strict=True)
        return max(error - share * (component.tolerance or 0.0) for error, component in errors)

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
