"""Planar problems in pictures: obstacles and robot as they are."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.problem.planar.shapes import outline_of, planar_shape
from pytest_lpb.report.canvas import path_through
from pytest_lpb.report.depiction import Sheet
from pytest_lpb.report.projection import Disc, Outline, Projection
from pytest_lpb.report.scene_marks import around_links, configurations
from pytest_lpb.report.view import Mark, PlannerStyle

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle
    from pytest_lpb.problem.robot import Robot
    from pytest_lpb.trajectory import Trajectory

FloatArray = NDArray[np.float64]


class PlanarDepiction:
    """Discs and rectangles, capsules of the robot; see `Depiction`."""

    def outline(
        self,
        obstacle: Obstacle,
        position: FloatArray,
        orientation: FloatArray,
        projection: Projection,  # noqa: ARG002 - there is one
    ) -> Outline:
        """An obstacle's outline: position (2,) [m], angle [rad]."""
        outline = outline_of(planar_shape(obstacle.entry))
        if isinstance(outline, float):
            return Disc(position, outline)
        angle = float(orientation)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return np.asarray(position + np.array(outline) @ turn.T)

    def extent(self, trajectory: Trajectory, projection: Projection) -> FloatArray:
        """Points around the links at all rows."""
        return around_links(trajectory, projection)

    def start(
        self,
        trajectory: Trajectory,  # noqa: ARG002 - nothing to add
        projection: Projection,  # noqa: ARG002 - as above
    ) -> FloatArray:
        """None: the path begins in the picture, and the robot is around it."""
        return np.empty((0, 2))

    def has_ghosts(self, robot: Robot) -> bool:
        """Whether it is an arm: a path says all of a single body."""
        return len(robot.collision_bodies) > 1

    def robot(
        self, sheet: Sheet, trajectory: Trajectory, row: int, css: str, style: PlannerStyle | None
    ) -> Iterator[Mark]:
        """Capsules as thick lines, all of a radius in one."""
        robot = trajectory.problem.robot
        q = configurations(trajectory)[row]
        by_radius: dict[float, list[FloatArray]] = {}
        for body in robot.collision_bodies:
            pose = robot.forward_kinematics(q, body.link)
            for capsule in body.capsules:
                ends = np.array(capsule[:4]).reshape(2, 2) @ pose[:2, :2].T + pose[:2, 2]
                by_radius.setdefault(capsule[4], []).append(sheet.canvas.pixels(ends))
        for radius, segments in by_radius.items():
            d = "".join(path_through(segment) for segment in segments)
            yield Mark(d, f"robot {css}", style, max(2 * radius * sheet.canvas.scale, 3.0))
