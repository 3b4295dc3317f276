"""A sub-goal in joint space, in the plane and in space alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from pytest_lpb.problem.angles import angle_error, wrapped
from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.robot import Robot

JOINT_UNITS = {"prismatic": "m", "revolute": "rad"}  # by joint type


class JointGoal(SubGoal):
    """Joints at given positions; the error is the largest of them, of prismatic [m] and revolute joints [rad] apart."""

    unit: ClassVar[str] = "rad"

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        super().__init__(entry, robot)
        self.joints: tuple[int, ...] = tuple(robot.joint_names.index(name) for name in entry["joints"])
        self._headings = robot.headings
        self.joint_units = tuple(JOINT_UNITS[robot.joint_types[index]] for index in self.joints)
        self.unit = " or ".join(self.units)  # type: ignore[misc] # an instance's own unit, by its joints

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the joints: m, rad, or both."""
        return tuple(unit for unit in JOINT_UNITS.values() if unit in self.joint_units)

    def value(self, q: Sequence[float], frames: Any) -> list[float]:  # noqa: ARG002
        """Positions of the joints [rad or m]."""
        return [q[index] for index in self.joints]

    def distance(self, value: Sequence[float], target: Sequence[float]) -> float:
        """Largest absolute joint error [rad or m], of all joints alike; a base's heading is wrapped."""
        return max(self._joint_errors(value, target))

    def errors(self, value: Sequence[float], target: Sequence[float]) -> tuple[float, ...]:
        """Largest absolute joint error of each unit, one number per entry of `components` [m or rad]."""
        errors = list(zip(self.joint_units, self._joint_errors(value, target), strict=True))
        return tuple(max(error for found, error in errors if found == unit) for unit in self.units)

    def _joint_errors(self, value: Sequence[float], target: Sequence[float]) -> list[float]:
        return [
            angle_error(have, want) if index in self._headings else abs(have - want)
            for index, have, want in zip(self.joints, value, target, strict=True)
        ]

    def residual(self, value: Sequence[float], target: Sequence[float]) -> list[float]:
        """Differences of the joints [rad or m]; a base's heading is wrapped."""
        return [
            wrapped(have - want) if index in self._headings else have - want
            for index, have, want in zip(self.joints, value, target, strict=True)
        ]
