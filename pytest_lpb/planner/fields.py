"""Geometry of potential fields in the plane: control points on the robot, distances to obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np

from pytest_lpb.planner.base import FloatArray, ObstacleInfo, Observation
from pytest_lpb.planner.task import point_on_link
from pytest_lpb.problem.robot import Robot


class ControlPoints:
    """Points along the collision bodies of a robot, each with the radius of its body.

    Args:
        robot: planar robot.
        spacing: largest distance between two of them along a body [m].
    """

    def __init__(self, robot: Robot, spacing: float) -> None:
        self._robot = robot
        self._points: list[tuple[str, tuple[float, float]]] = []
        radii = []
        for body in robot.collision_bodies:
            for ax, ay, bx, by, radius in body.capsules:
                count = ceil(np.hypot(bx - ax, by - ay) / spacing)
                for s in np.linspace(0.0, 1.0, count + 1)[1 if count else 0 :]:
                    self._points.append((body.link, (ax + s * (bx - ax), ay + s * (by - ay))))
                    radii.append(radius)
        self.radii = np.array(radii)  # (m,) [m]

    def at(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (m, 2) [m] and Jacobians (m, 2, dof) at q."""
        placed = [point_on_link(self._robot, link, point, q) for link, point in self._points]
        return np.array([position for position, _ in placed]), np.array([jacobian for _, jacobian in placed])


class ObstacleField:
    """Distances of points to circles and rectangles.

    Args:
        obstacles: what the planner was told of them; positions come with each observation.
    """

    def __init__(self, obstacles: Sequence[ObstacleInfo]) -> None:
        # A circle is a rectangle of no size, rounded by its radius: one formula serves both.
        self._half = np.array([0.5 * np.array(o.size) if o.size else (0.0, 0.0) for o in obstacles])  # (n, 2) [m]
        self._radius = np.array([o.radius or 0.0 for o in obstacles])  # (n,) [m]

    def distances(self, points: FloatArray, observation: Observation) -> tuple[FloatArray, FloatArray]:
        """Signed distances (m, n) [m] of points (m, 2) to obstacles, and unit vectors (m, n, 2) away from them."""
        angle = observation["obstacle_orientation"]
        c, s = np.cos(angle), np.sin(angle)
        offset = points[:, None, :] - observation["obstacle_position"][None, :, :]
        local_x = c * offset[..., 0] + s * offset[..., 1]
        local_y = c * offset[..., 1] - s * offset[..., 0]
        gap_x, gap_y = np.abs(local_x) - self._half[:, 0], np.abs(local_y) - self._half[:, 1]
        along_x = (gap_x > 0.0) | (gap_x >= gap_y)
        along_y = (gap_y > 0.0) | (gap_y > gap_x)
        out_x = np.where(along_x, np.copysign(np.where(gap_x > 0.0, gap_x, 1.0), local_x), 0.0)
        out_y = np.where(along_y, np.copysign(np.where(gap_y > 0.0, gap_y, 1.0), local_y), 0.0)
        length = np.hypot(out_x, out_y)
        inside = (gap_x <= 0.0) & (gap_y <= 0.0)
        distance = np.where(inside, np.maximum(gap_x, gap_y), length) - self._radius
        away_x, away_y = (c * out_x - s * out_y) / length, (s * out_x + c * out_y) / length
        return distance, np.stack([away_x, away_y], axis=-1)
