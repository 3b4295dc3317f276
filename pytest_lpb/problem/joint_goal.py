"""A sub-goal in joint space, in the plane and in space alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from pytest_lpb.problem.angles import angle_error, wrapped
from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.robot import Robot


class JointGoal(SubGoal):
    """Joints at given positions; the error is the largest of them."""

    unit: ClassVar[str] = "rad"

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        super().__init__(entry, robot)
        self.joints: tuple[int, ...] = tuple(robot.joint_names.index(name) for name in entry["joints"])
        self._headings = robot.headings
        if all(robot.joint_types[index] == "prismatic" for index in self.joints):
            self.unit = "m"  # type: ignore[misc] # an instance's own unit, by its joints

    def value(self, q: Sequence[float], frames: Any) -> list[float]:  # noqa: ARG002
        """Positions of the joints [rad or m]."""
        return [q[index] for index in self.joints]

    def distance(self, value: Sequence[float], target: Sequence[float]) -> float:
        """Largest absolute joint error [rad or m]; a base's heading is wrapped."""
        return max(
            angle_error(have, want) if index in self._headings else abs(have - want)
            for index, have, want in zip(self.joints, value, target, strict=True)
        )

    def residual(self, value: Sequence[float], target: Sequence[float]) -> list[float]:
        """Differences of the joints [rad or m]; a base's heading is wrapped."""
        return [
            wrapped(have - want) if index in self._headings else have - want
            for index, have, want in zip(self.joints, value, target, strict=True)
        ]
