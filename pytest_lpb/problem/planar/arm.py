"""An arm of n revolute joints in the plane, fixed at the origin. q_i turns link i against the one before it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, sin
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pytest_lpb.problem.planar.robot import Frame, PlanarRobot, Scalar, integrate_holonomic
from pytest_lpb.problem.robot import CollisionBody, FloatArray


class PlanarArm(PlanarRobot):
    """Planar arm with links `base` (a disc), `link1`.. (capsules from their joint on) and the tip frame `end`."""

    def __init__(self, entry: Mapping[str, Any]) -> None:
        self.lengths = tuple(float(length) for length in entry["links"])  # [m]
        super().__init__(entry)

    def _joints(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        count = len(self.lengths)
        return tuple(f"joint{i + 1}" for i in range(count)), ("revolute",) * count

    def _links(self) -> tuple[str, ...]:
        return ("base", *(f"link{i + 1}" for i in range(len(self.lengths))), "end")

    def _geometry(self) -> tuple[CollisionBody, ...]:
        radius = self.body_radius
        base = CollisionBody("base", "base", ((0.0, 0.0, 0.0, 0.0, radius),))
        links = (
            CollisionBody(f"link{i + 1}", f"link{i + 1}", ((0.0, 0.0, length, 0.0, radius),))
            for i, length in enumerate(self.lengths)
        )
        return (base, *links)

    def _adjacent(self, first: str, second: str) -> bool:
        return abs(self.link_index(first) - self.link_index(second)) <= 1

    def frames(self, q: Sequence[Any], cos: Scalar = cos, sin: Scalar = sin) -> list[Frame]:
        """Frames of base, link1.., end; a link's frame lies at its joint, x along the link."""
        frames = [(0.0, 0.0, 1.0, 0.0)]
        x = y = angle = 0.0
        c, s = 1.0, 0.0
        for qi, length in zip(q, self.lengths, strict=True):
            angle += qi
            c, s = cos(angle), sin(angle)
            frames.append((x, y, c, s))
            x += length * c
            y += length * s
        frames.append((x, y, c, s))
        return frames

    def integrate(
        self, q: list[float], u: list[float], action: list[float], dt: float
    ) -> tuple[list[float], list[float]]:
        """State after dt [s] under the constant action, exact."""
        return integrate_holonomic(self.control, q, u, action, dt)

    def link_speeds(self, before: list[float], after: list[float]) -> list[tuple[float, float]]:
        """Sums over the links below of length times rate; a link turns at the sum of the rates of its joints."""
        speeds = [(0.0, 0.0)]
        speed = rate = first = last = 0.0
        for start, end, length in zip(before, after, self.lengths, strict=True):
            first += start
            last += end
            rate = max(abs(first), abs(last))
            speeds.append((speed, rate))
            speed += length * rate
        speeds.append((speed, rate))
        return speeds

    def pair_levers(self, first: tuple[int, float], second: tuple[int, float]) -> list[float]:
        """The joints between two bodies turn one against the other: by the chain from the joint to either of them."""
        (lower, below), (upper, above) = sorted((first, second))
        levers = [0.0] * self.dof
        for joint in range(lower, min(upper, self.dof)):
            # Joint i lies at the start of link i + 1, and `lengths` begin with that link's.
            outwards = sum(self.lengths[joint : upper - 1]) + above
            inwards = sum(self.lengths[max(lower - 1, 0) : joint]) + below
            levers[joint] = min(outwards, inwards)
        return levers

    @property
    def reach(self) -> float:
        """Length of the stretched arm [m]."""
        return sum(self.lengths)

    def jacobian(self, q: ArrayLike, link: str) -> FloatArray:
        """Velocity of a link's frame per qd, (3, dof): a joint moves what lies beyond it."""
        frames = np.array(self.frames(np.asarray(q, dtype=float).tolist()))[:, :2]
        index = self.link_index(link)
        moving = min(index, self.dof)
        result = np.zeros((3, self.dof))
        arms = frames[index] - frames[1 : moving + 1]
        result[0, :moving] = -arms[:, 1]
        result[1, :moving] = arms[:, 0]
        result[2, :moving] = 1.0
        return result

    def link_positions(self, q: FloatArray) -> FloatArray:
        """Positions of base, link1.., end along a trajectory q (N, dof): (N, dof + 2, 2) [m]."""
        angles = np.cumsum(q, axis=1)
        steps = np.stack([np.cos(angles), np.sin(angles)], axis=2) * np.array(self.lengths)[:, None]
        positions = np.zeros((len(q), self.dof + 2, 2))
        positions[:, 2:] = np.cumsum(steps, axis=1)
        return positions
