"""Parts of a robot whose distances to obstacles are measured: balls, segments with a radius, boxes.

Every kind has a place: the numbers, functions of q, that its distances are functions of. All lengths in m.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, sqrt
from typing import Any, ClassVar

import casadi
import numpy as np

from pytest_lpb.planner.scene.segments import segment_distance
from pytest_lpb.planner.scene.shapes import SHAPES
from pytest_lpb.symbolic.kinematics import Frames

ROUND = frozenset({"circle", "sphere"})


@dataclass(frozen=True)
class ObstacleSymbols:
    """An obstacle at the origin: rotation (d, d), the numbers of its size."""

    shape: str
    turn: Any
    size: Any


@dataclass(frozen=True)
class Part(ABC):
    """A part of a robot, fixed to a link.

    Attributes:
        body: name of the collision body it is of.
        link: name of the link.
        radius: [m] that rounds it.
        ahead: [m] how far ahead of where it is, along the heading of a moving base, the part is taken to be.
    """

    exact: ClassVar[frozenset[str]]  # shapes of obstacles to which its distance is known in closed form

    body: str
    link: str
    radius: float
    ahead: float = field(default=0.0, kw_only=True)

    def place(self, frames: Frames) -> Any:
        """What distances are functions of, (k, 1)."""
        there = self.own_place(frames)
        return there + self.shift(self.ahead * heading(frames)) if self.ahead else there

    @abstractmethod
    def own_place(self, frames: Frames) -> Any:
        """The place where the part is."""

    @abstractmethod
    def shift(self, offset: Any) -> Any:
        """How the place changes, (k, 1), when the part moves by an offset (d, 1) [m]."""

    @abstractmethod
    def core_distance(self, place: Any, obstacle: ObstacleSymbols) -> Any:
        """Signed distance [m] of an obstacle to the part without its radius, by the part's place from the obstacle."""

    @abstractmethod
    def balls(self, excess: float) -> Iterator[Ball]:
        """Balls that hold the part, reaching at most `excess` [m] beyond it."""

    def distance(self, place: Any, obstacle: ObstacleSymbols) -> Any:
        """Signed distance [m] to an obstacle, by the part's place from the obstacle."""
        return self.core_distance(place, obstacle) - self.radius


@dataclass(frozen=True)
class Ball(Part):
    """A ball; its place is its centre in the world."""

    exact: ClassVar[frozenset[str]] = frozenset(SHAPES)

    centre: tuple[float, ...]  # in the link's frame [m]

    def own_place(self, frames: Frames) -> Any:
        """The centre."""
        return frames.point(self.link, self.centre)

    def shift(self, offset: Any) -> Any:
        """The offset."""
        return offset

    def core_distance(self, place: Any, obstacle: ObstacleSymbols) -> Any:
        """Of the centre to the obstacle's surface."""
        shape = SHAPES[obstacle.shape]
        return shape.distance(obstacle.turn.T @ place if shape.turns else place, obstacle.size)

    def balls(self, excess: float) -> Iterator[Ball]:  # noqa: ARG002
        """Itself."""
        yield self


@dataclass(frozen=True)
class Segment(Part):
    """A capsule; its place is the centres of its caps, one below the other."""

    exact: ClassVar[frozenset[str]] = frozenset({*ROUND, "capsule"})

    start: tuple[float, ...]  # in the link's frame [m]
    end: tuple[float, ...]

    def own_place(self, frames: Frames) -> Any:
        """Both cap centres."""
        return casadi.vertcat(frames.point(self.link, self.start), frames.point(self.link, self.end))

    def shift(self, offset: Any) -> Any:
        """The offset, twice."""
        return casadi.vertcat(offset, offset)

    def core_distance(self, place: Any, obstacle: ObstacleSymbols) -> Any:
        """Of the axis to a ball or capsule."""
        start, end = casadi.vertsplit(place, place.numel() // 2)
        radius = obstacle.size[0]
        if obstacle.shape in ROUND:
            return segment_distance([start, end], [casadi.SX.zeros(start.numel(), 1)]) - radius
        reach = 0.5 * obstacle.size[1] * obstacle.turn[:, 2]
        return segment_distance([start, end], [-reach, reach]) - radius

    def balls(self, excess: float) -> Iterator[Ball]:
        """Balls along the axis, so close that they hold the capsule."""
        start, end = np.array(self.start), np.array(self.end)
        spacing = 2.0 * sqrt((self.radius + excess) ** 2 - self.radius**2)
        whole = float(np.linalg.norm(end - start))
        count = max(1, ceil(whole / spacing - 1e-9))
        radius = sqrt(self.radius**2 + (0.5 * whole / count) ** 2)
        for share in np.linspace(0.0, 1.0, count + 1):
            centre = tuple((start + share * (end - start)).tolist())
            yield Ball(self.body, self.link, radius, centre, ahead=self.ahead)


@dataclass(frozen=True)
class Block(Part):
    """A box in space; its place is its centre and its three axes, one below the other."""

    exact: ClassVar[frozenset[str]] = frozenset({"sphere"})

    origin: tuple[float, ...]  # pose (16,) in the link's frame, row by row
    size: tuple[float, ...]  # full lengths [m]
    cover: tuple[Ball, ...]

    def own_place(self, frames: Frames) -> Any:
        """Centre and axes."""
        pose = np.array(self.origin).reshape(4, 4)
        rotation = frames.of(self.link)[1] @ casadi.DM(pose[:3, :3])
        return casadi.vertcat(frames.point(self.link, pose[:3, 3]), casadi.reshape(rotation, 9, 1))

    def shift(self, offset: Any) -> Any:
        """The offset, of the centre only."""
        return casadi.vertcat(offset, casadi.SX.zeros(9, 1))

    def core_distance(self, place: Any, obstacle: ObstacleSymbols) -> Any:
        """Of a ball's centre to the box, less the ball's radius."""
        local = -casadi.reshape(place[3:], 3, 3).T @ place[:3]
        return SHAPES["box"].distance(local, casadi.DM(list(self.size))) - obstacle.size[0]

    def balls(self, excess: float) -> Iterator[Ball]:  # noqa: ARG002 - asked for when the cover was made
        """The balls that were fitted to it."""
        yield from (replace(ball, ahead=self.ahead) for ball in self.cover)


def part_of_capsule(body: str, link: str, capsule: Sequence[float]) -> Part:
    """The part that a capsule of `CollisionBody` is: a ball where its ends are one."""
    *ends, radius = capsule
    start, end = tuple(ends[: len(ends) // 2]), tuple(ends[len(ends) // 2 :])
    return Ball(body, link, radius, start) if start == end else Segment(body, link, radius, start, end)


def ends_of(part: Part, place: Any) -> list[Any]:
    """Centre of a ball, or both cap centres of a capsule, of its place or of the place's velocity."""
    parts: list[Any] = casadi.vertsplit(place, place.numel() // 2) if isinstance(part, Segment) else [place]
    return parts


def distance_between(first: Part, second: Part, places: Sequence[Any]) -> Any:
    """Distance [m] between two balls or capsules of a robot, by their places."""
    ends, others = (ends_of(part, place) for part, place in zip((first, second), places, strict=True))
    return segment_distance(ends, others) - first.radius - second.radius


def heading(frames: Frames) -> Any:
    """Unit vector (d, 1) along the heading of a moving base, which is the third entry of q."""
    flat = casadi.vertcat(casadi.cos(frames.q[2]), casadi.sin(frames.q[2]))
    return casadi.vertcat(flat, casadi.SX.zeros(frames.robot.dimension - 2, 1))
