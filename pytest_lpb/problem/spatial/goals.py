"""Sub-goals of spatial problems. Frames are (x, y, z, quaternion wxyz) per link, in the world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import atan2, sqrt
from typing import Any, ClassVar

from pytest_lpb.motion import Motion, NormalisedMotion
from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.robot import FloatArray, Robot
from pytest_lpb.problem.spatial.rotations import (
    angle_between,
    inverse,
    multiply,
    normalised,
    rotate,
    rotation_vector,
)

Frames = Any  # anything that gives a link's frame by its index


class PositionGoal(SubGoal):
    """A link's frame, or a `point` in it, at a position; of some world axes only, or relative to another link."""

    unit: ClassVar[str] = "m"

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        super().__init__(entry, robot)
        self.axes: tuple[int, ...] = tuple(entry.get("axes") or range(3))
        point = entry.get("point")
        self.point: tuple[float, ...] | None = tuple(point) if point and any(point) else None
        self._index = robot.link_index(entry["link"])
        relative = entry.get("relative_to")
        self._reference = None if relative in (None, "world") else robot.link_index(relative)

    def value(self, q: Sequence[float], frames: Frames) -> list[float]:  # noqa: ARG002
        """Position of the point, in the world or the reference link's frame [m]."""
        x, y, z, *turn = frames[self._index]
        if self.point is not None:
            dx, dy, dz = rotate(turn, self.point)
            x, y, z = x + dx, y + dy, z + dz
        if self._reference is not None:
            rx, ry, rz, *turn = frames[self._reference]
            x, y, z = rotate(inverse(turn), (x - rx, y - ry, z - rz))
        position = (x, y, z)
        return [position[axis] for axis in self.axes]

    def beyond_reach(self, target: Sequence[float] | FloatArray) -> bool:
        """Whether a target in the world lies outside the ball that the robot can reach."""
        if len(self.axes) < 3 or self._reference is not None:
            return False
        offset = [float(target[axis]) - float(self.robot.base_pose[axis, 3]) for axis in range(3)]
        length = sqrt(sum(x * x for x in self.point)) if self.point else 0.0
        return sqrt(sum(x * x for x in offset)) > self.robot.reach + length + (self.tolerance or 0.0)

    def distance(self, value: Sequence[float], target: Sequence[float]) -> float:
        """Euclidean distance [m]."""
        total = 0.0
        for have, want in zip(value, target, strict=True):
            total += (have - want) * (have - want)
        return sqrt(total)


class OrientationGoal(SubGoal):
    """A link's frame turned as a quaternion wxyz in the world says."""

    unit: ClassVar[str] = "rad"

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        super().__init__(entry, robot)
        self._index = robot.link_index(entry["link"])

    def _motion(self, entry: Mapping[str, Any]) -> Motion:
        return NormalisedMotion(super()._motion(entry))

    def value(self, q: Sequence[float], frames: Frames) -> list[float]:  # noqa: ARG002
        """Quaternion of the link, wxyz."""
        return list(frames[self._index][3:])

    def distance(self, value: Sequence[float], target: Sequence[float]) -> float:
        """Geodesic distance [rad]: the angle of the turn from one to the other."""
        return angle_between(value, normalised(target))

    def residual(self, value: Sequence[float], target: Sequence[float]) -> list[float]:
        """The turn from the target to the value, as a rotation vector in the world [rad]."""
        return list(rotation_vector(multiply(value, inverse(normalised(target)))))


class AlignmentGoal(SubGoal):
    """An axis of a link along an axis of the world or of another link: the target is an angle of zero."""

    unit: ClassVar[str] = "rad"

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        super().__init__({"target": [0.0], **entry}, robot)
        self._index = robot.link_index(entry["link"])
        self.axis: tuple[float, ...] = tuple(entry["axis"])
        other = entry.get("other", "world")
        self._other = None if other == "world" else robot.link_index(other)
        self.other_axis: tuple[float, ...] = tuple(entry["other_axis"])

    def value(self, q: Sequence[float], frames: Frames) -> list[float]:  # noqa: ARG002
        """Angle between the two axes [rad], in [0, pi]."""
        ax, ay, az = rotate(frames[self._index][3:], self.axis)
        bx, by, bz = self.other_axis if self._other is None else rotate(frames[self._other][3:], self.other_axis)
        cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        return [atan2(sqrt(cx * cx + cy * cy + cz * cz), ax * bx + ay * by + az * bz)]

    def distance(self, value: Sequence[float], target: Sequence[float]) -> float:
        """Angle between the axes [rad]."""
        return abs(value[0] - target[0])
