"""Geometry of potential fields in the plane: control points on the robot, distances to obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.motion.directions import lengths, scaled, unit
from pytest_lpb.planner.base import FloatArray, Observation, ObstacleInfo
from pytest_lpb.problem.planar.arm import PlanarArm
from pytest_lpb.problem.planar.robot import PlanarRobot
from pytest_lpb.problem.robot import Robot


class Points(Protocol):
    """Points on a robot's bodies that obstacles push.

    Attributes: radii (m,) [m]; owners, the name of each point's body.
    """

    radii: FloatArray
    owners: list[str]

    def at(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (m, dimension) [m] and Jacobians per qd (m, dimension, dof) at q."""

    def nearest(self, distance: FloatArray) -> FloatArray:
        """Which points (m, n), as True, are nearest of their body to an obstacle; of distances (m, n) [m]."""


class Distances(Protocol):
    """Distances of points to obstacles."""

    def distances(self, points: FloatArray, observation: Observation) -> tuple[FloatArray, FloatArray]:
        """Signed distances (m, n) [m], and unit vectors (m, n, dimension) away from the obstacles."""


def nearest_of_bodies(distance: FloatArray, bodies: NDArray[np.intp], body_of: NDArray[np.intp]) -> FloatArray:
    """Which points (m, n), as True, are nearest of their body: the first points of bodies, the body of each point."""
    least = np.minimum.reduceat(distance, bodies, axis=0)
    chosen: FloatArray = distance == least[body_of]
    return chosen


class ControlPoints:
    """Points along the collision bodies of a robot, each with the radius of its body.

    A non-holonomic base cannot evade sideways, but a point ahead of it can: it has a second disc there.

    Args:
        robot: planar robot.
        spacing: largest distance between two of them along a body [m].
        lookahead: of the second disc of a non-holonomic base [m].
    """

    def __init__(self, robot: Robot, spacing: float, lookahead: float) -> None:
        assert isinstance(robot, PlanarRobot), "control points are known for planar robots"
        self._robot = robot
        links: list[int] = []
        local: list[tuple[float, float]] = []
        radii: list[float] = []
        bodies: list[int] = []
        names: list[str] = []
        for body in robot.collision_bodies:
            capsules = body.capsules
            if robot.non_holonomic:
                ahead = tuple((ax + lookahead, ay, bx + lookahead, by, r) for ax, ay, bx, by, r in capsules)
                capsules = (*capsules, *ahead)
            for ax, ay, bx, by, radius in capsules:
                names.append(body.name)
                bodies.append(len(local))
                count = ceil(np.hypot(bx - ax, by - ay) / spacing - 1e-9)
                for s in np.linspace(0.0, 1.0, count + 1) if count else (0.0,):
                    links.append(robot.link_index(body.link))
                    local.append((ax + s * (bx - ax), ay + s * (by - ay)))
                    radii.append(radius)
        self.radii = np.array(radii)  # (m,) [m]
        self._bodies = np.array(bodies)  # first point of each capsule
        self._body_of = np.repeat(np.arange(len(bodies)), np.diff([*bodies, len(local)]))
        self._single = len(bodies) == len(local)
        self._links = np.array(links)
        self._local = np.array(local)
        self.owners = [names[body] for body in self._body_of]  # name of each point's body
        self._names = [robot.link_names[link] for link in links]
        # Joint j of an arm moves what lies on its own link or beyond; its axis is that link's frame.
        self._moved = self._links[:, None] > np.arange(robot.dof) if isinstance(robot, PlanarArm) else None

    def at(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (m, 2) [m] and Jacobians per qd (m, 2, dof) at q."""
        frames = np.array(self._robot.frames(q.tolist()))
        x, y, c, s = frames[self._links].T
        along, across = self._local.T
        positions = np.empty((len(x), 2))
        positions[:, 0] = x + c * along - s * across
        positions[:, 1] = y + s * along + c * across
        if self._moved is None:
            return positions, self._by_links(q, positions, frames)
        jacobians = np.empty((len(x), 2, self._robot.dof))
        axes = frames[1:-1]
        jacobians[:, 0, :] = (axes[:, 1] - positions[:, 1:]) * self._moved
        jacobians[:, 1, :] = (positions[:, :1] - axes[:, 0]) * self._moved
        return positions, jacobians

    def _by_links(self, q: FloatArray, positions: FloatArray, frames: FloatArray) -> FloatArray:
        """Jacobians (m, 2, dof) from those of the links' frames."""
        of_link = {name: self._robot.jacobian(q, name) for name in dict.fromkeys(self._names)}
        whole = np.array([of_link[name] for name in self._names])
        arms = positions - frames[self._links, :2]
        spin = np.stack([-arms[:, 1], arms[:, 0]], axis=1)
        jacobians: FloatArray = whole[:, :2] + spin[:, :, None] * whole[:, 2:]
        return jacobians

    def nearest(self, distance: FloatArray) -> FloatArray:
        """Which points (m, n), as True, are nearest of their body to an obstacle; of distances (m, n) [m]."""
        if self._single:
            return np.ones(distance.shape, dtype=bool)
        return nearest_of_bodies(distance, self._bodies, self._body_of)


class SelfDistances:
    """Distances between control points of bodies that must not touch.

    Args:
        robot: gives the pairs of bodies.
        points: its control points.
        pairs: those to look at; default all of the robot's.
    """

    def __init__(self, robot: Robot, points: Points, pairs: Sequence[tuple[str, str]] | None = None) -> None:
        owners = np.array(points.owners)
        first: list[int] = []
        second: list[int] = []
        starts: list[int] = []
        for one, other in robot.self_collision_pairs if pairs is None else pairs:
            i, j = np.meshgrid(np.flatnonzero(owners == one), np.flatnonzero(owners == other))
            starts.append(len(first))
            first += i.ravel().tolist()
            second += j.ravel().tolist()
        self._first, self._second, self._starts = np.array(first), np.array(second), np.array(starts)
        self._pair_of = np.repeat(np.arange(len(starts)), np.diff([*starts, len(first)]))
        self._radii = points.radii[self._first] + points.radii[self._second] if first else np.zeros(0)

    def least(self, positions: FloatArray) -> FloatArray:
        """The least distance of each pair of bodies (pairs,) [m] at positions (m, dimension)."""
        distance = lengths(positions[self._first] - positions[self._second]) - self._radii
        least: FloatArray = np.minimum.reduceat(distance, self._starts)
        return least

    def nearest(self, positions: FloatArray, within: float) -> tuple[NDArray[np.intp], NDArray[np.intp], FloatArray]:
        """The nearest points of each pair of bodies closer than `within` [m]: first, second, distance [m]."""
        if not len(self._starts):
            return self._first, self._second, self._radii
        offset = positions[self._first] - positions[self._second]
        distance = lengths(offset) - self._radii
        least = np.minimum.reduceat(distance, self._starts)
        chosen = np.flatnonzero((distance < within) & (distance == least[self._pair_of]))
        return self._first[chosen], self._second[chosen], distance[chosen]


class ObstacleField:
    """Distances of points to circles and rectangles.

    Args:
        obstacles: what the planner was told of them; positions come with each observation.
    """

    def __init__(self, obstacles: Sequence[ObstacleInfo]) -> None:
        # A circle is a rectangle of no size, rounded by its radius: one formula serves both.
        self._half = np.array([0.5 * np.array(o.size) if o.size else (0.0, 0.0) for o in obstacles])  # (n, 2) [m]
        self._radius = np.array([o.radius or 0.0 for o in obstacles])  # (n,) [m]
        self._count = len(obstacles)  # observations may have room for more
        self._round = not self._half.any()

    def distances(self, points: FloatArray, observation: Observation) -> tuple[FloatArray, FloatArray]:
        """Signed distances (m, n) [m] of points (m, 2) to obstacles, and unit vectors (m, n, 2) away from them."""
        offset = points[:, None, :] - observation["obstacle_position"][: self._count]
        if self._round:
            return self._from_circles(offset)
        angle = observation["obstacle_orientation"][: self._count]
        c, s = np.cos(angle), np.sin(angle)
        local_x = c * offset[..., 0] + s * offset[..., 1]
        local_y = c * offset[..., 1] - s * offset[..., 0]
        gap_x, gap_y = np.abs(local_x) - self._half[:, 0], np.abs(local_y) - self._half[:, 1]
        # Outside away from the nearest point, inside out of the nearest face.
        inside = (gap_x <= 0.0) & (gap_y <= 0.0)
        by_x = inside & (gap_x >= gap_y)
        out_x = np.copysign(np.where(inside, by_x, np.maximum(gap_x, 0.0)), local_x)
        out_y = np.copysign(np.where(inside, inside & ~by_x, np.maximum(gap_y, 0.0)), local_y)
        length = np.hypot(out_x, out_y)
        distance = np.where(inside, np.maximum(gap_x, gap_y), length) - self._radius
        out, length = scaled(np.stack([out_x, out_y], axis=-1), length)
        out_x, out_y = out[..., 0], out[..., 1]
        return distance, np.stack([(c * out_x - s * out_y) / length, (s * out_x + c * out_y) / length], axis=-1)

    def _from_circles(self, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        length = lengths(offset)
        return length - self._radius, unit(offset, length)
