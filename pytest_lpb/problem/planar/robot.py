"""What planar robots share: link frames as scalars, poses and Jacobians from them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from math import cos, sin
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pytest_lpb.problem.robot import FloatArray, Robot

if TYPE_CHECKING:
    from pytest_lpb.problem.collision import CollisionSpace
    from pytest_lpb.problem.obstacle import Obstacle

Frame = tuple[float, float, float, float]  # x [m], y [m], cos and sin of the angle, in the world
Scalar = Callable[[Any], Any]  # a function of a number, or of a symbol


class PlanarRobot(Robot):
    """A robot in the plane. Angles turn from x to y; a frame's first axis points along its link."""

    dimension: ClassVar[int] = 2

    @abstractmethod
    def frames(self, q: Sequence[Any], cos: Scalar = cos, sin: Scalar = sin) -> list[Frame]:
        """Frames of all links at q, in the order of `link_names`; symbolic q come with symbolic functions."""

    def joint_velocity(self, q: Sequence[float], u: list[float]) -> list[float]:  # noqa: ARG002
        """qd at q under the actuated velocity u."""
        return u

    def link_speeds(self, before: list[float], after: list[float]) -> list[tuple[float, float]]:
        """Bounds, for each link, of the speed of its frame [m/s] and of its angular rate [rad/s].

        They hold while u changes linearly between two values. Contact between two rows is found with them; a robot
        that does not give them is judged at its rows alone.
        """
        raise NotImplementedError

    def pair_levers(self, first: tuple[int, float], second: tuple[int, float]) -> list[float]:
        """Bounds (n_actions,) of how much a unit of each entry of u changes the distance of two bodies per second [m].

        Args:
            first, second: of each body the index of its link, and the distance of its farthest point from the link's
                frame [m].
        """
        if first[0] != second[0]:
            raise NotImplementedError
        return [0.0] * self.n_actions

    def link_angle(self, q: Sequence[float], link: str) -> float:
        """Angle of a link's frame in the world [rad], not wrapped."""
        _, _, c, s = self.frames(q)[self.link_index(link)]
        return float(np.arctan2(s, c))

    def collision_space(self, obstacles: Sequence[Obstacle]) -> CollisionSpace:
        """Where this robot's clearance can be asked for."""
        from pytest_lpb.problem.planar.collision import PlanarSpace

        return PlanarSpace(self, obstacles)

    def forward_kinematics(self, q: ArrayLike, link: str) -> FloatArray:
        """Pose of a link's frame in the world, (3, 3) homogeneous. Raises ValueError for an unknown link."""
        x, y, c, s = self.frames(np.asarray(q, dtype=float).tolist())[self.link_index(link)]
        return np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])


def integrate_holonomic(
    control: str, q: list[float], u: list[float], action: list[float], dt: float
) -> tuple[list[float], list[float]]:
    """Exact motion of independent joints under a constant velocity, or a constant acceleration."""
    if control == "velocity":
        return [qi + ai * dt for qi, ai in zip(q, action, strict=True)], list(action)
    half = 0.5 * dt * dt
    return (
        [qi + ui * dt + ai * half for qi, ui, ai in zip(q, u, action, strict=True)],
        [ui + ai * dt for ui, ai in zip(u, action, strict=True)],
    )
