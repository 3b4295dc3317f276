"""Sub-goals of planar problems. Frames are (x, y, cos, sin) per link, in the world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import atan2, hypot
from typing import Any, ClassVar

from pytest_lpb.problem.angles import angle_error, wrapped
from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.planar.robot import Frame
from pytest_lpb.problem.robot import FloatArray, Robot


class PositionGoal(SubGoal):
    """A link's frame, or a `point` in it, at a position; of a world axis or two, or relative to another link."""

    unit: ClassVar[str] = "m"

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        super().__init__(entry, robot)
        self.axes: tuple[int, ...] = tuple(entry.get("axes") or range(2))
        self.point: tuple[float, float] = tuple(entry.get("point") or (0.0, 0.0))[:2]
        self._index = robot.link_index(entry["link"])
        relative = entry.get("relative_to")
        self._reference = None if relative in (None, "world") else robot.link_index(relative)

    def value(self, q: Sequence[float], frames: Sequence[Frame]) -> list[float]:  # noqa: ARG002
        """Position of the point, in the world or the reference link's frame [m]."""
        x, y, c, s = frames[self._index]
        px, py = self.point
        position = (x + c * px - s * py, y + s * px + c * py)
        if self._reference is not None:
            rx, ry, rc, rs = frames[self._reference]
            dx, dy = position[0] - rx, position[1] - ry
            position = (rc * dx + rs * dy, rc * dy - rs * dx)
        return [position[axis] for axis in self.axes]

    def beyond_reach(self, target: Sequence[float] | FloatArray) -> bool:
        """Whether a target in the world lies outside the disc that the robot can reach."""
        reach = self.robot.reach + hypot(*self.point) + (self.tolerance or 0.0)
        return len(self.axes) == 2 and self._reference is None and hypot(target[0], target[1]) > reach

    def distance(self, value: Sequence[float], target: Sequence[float]) -> float:
        """Euclidean distance [m]."""
        if len(value) == 2:
            return hypot(value[0] - target[0], value[1] - target[1])
        return abs(value[0] - target[0])


class OrientationGoal(SubGoal):
    """A link's frame turned to an angle in the world."""

    unit: ClassVar[str] = "rad"

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        super().__init__(entry, robot)
        self._index = robot.link_index(entry["link"])

    def value(self, q: Sequence[float], frames: Sequence[Frame]) -> list[float]:  # noqa: ARG002
        """Angle of the link [rad]."""
        _, _, c, s = frames[self._index]
        return [atan2(s, c)]

    def distance(self, value: Sequence[float], target: Sequence[float]) -> float:
        """Geodesic distance [rad]."""
        return angle_error(value[0], target[0])

    def residual(self, value: Sequence[float], target: Sequence[float]) -> list[float]:
        """The angle left [rad], wrapped."""
        return [wrapped(value[0] - target[0])]


class AlignmentGoal(SubGoal):
    """An axis of a link along an axis of the world or of another link: the target is an angle of zero."""

    unit: ClassVar[str] = "rad"

    def __init__(self, entry: Mapping[str, Any], robot: Robot) -> None:
        super().__init__({"target": [0.0], **entry}, robot)
        self._index = robot.link_index(entry["link"])
        self.axis: tuple[float, float] = tuple(entry["axis"])[:2]
        other = entry.get("other", "world")
        self._other = None if other == "world" else robot.link_index(other)
        self.other_axis: tuple[float, float] = tuple(entry["other_axis"])[:2]

    def value(self, q: Sequence[float], frames: Sequence[Frame]) -> list[float]:  # noqa: ARG002
        """Angle between the two axes [rad], signed."""
        ax, ay = _turned(self.axis, frames[self._index])
        bx, by = self.other_axis if self._other is None else _turned(self.other_axis, frames[self._other])
        return [atan2(bx * ay - by * ax, bx * ax + by * ay)]

    def distance(self, value: Sequence[float], target: Sequence[float]) -> float:
        """Angle between the axes [rad]."""
        return angle_error(value[0], target[0])

    def residual(self, value: Sequence[float], target: Sequence[float]) -> list[float]:
        """The angle left [rad], wrapped."""
        return [wrapped(value[0] - target[0])]


def _turned(axis: tuple[float, float], frame: Frame) -> tuple[float, float]:
    _, _, c, s = frame
    return c * axis[0] - s * axis[1], s * axis[0] + c * axis[1]
