"""Spatial problems in pictures: silhouettes of obstacles and of the robot's collision geometry, and its skeleton.

What is drawn is what collides: the silhouette of a convex body is the hull of its projected corners, exactly. Concave
meshes are drawn as their hull.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.solids import Solid, geometry_of, pose_from, solid_of, solids_of
from pytest_lpb.report.canvas import path_through
from pytest_lpb.report.depiction import Sheet
from pytest_lpb.report.projection import Disc, Outline, Projection, convex_hull, corners_of
from pytest_lpb.report.scene_marks import around_links, configurations, finite_rows
from pytest_lpb.report.view import Mark, PlannerStyle

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle
    from pytest_lpb.problem.robot import Robot
    from pytest_lpb.trajectory import Trajectory

FloatArray = NDArray[np.float64]

ROUND = 2.0 * np.pi * np.arange(32) / 32  # [rad] corners of what is round
SKELETON_PX = 2.5
GHOST = "ghost"


class SpatialDepiction:
    """Silhouettes in orthographic projection; see `Depiction`."""

    def outline(
        self, obstacle: Obstacle, position: FloatArray, orientation: FloatArray, projection: Projection
    ) -> Outline | None:
        """An obstacle's silhouette: position (3,) [m], quaternion wxyz (4,)."""
        try:
            solid = solid_of(geometry_of(obstacle))
        except (ScenarioError, OSError):
            return None
        return silhouette(solid.placed(pose_from(position, orientation)), projection)

    def extent(self, trajectory: Trajectory, projection: Projection) -> FloatArray:
        """Points around the links at all rows, and corners of the bodies at the end."""
        last = int(finite_rows(trajectory)[-1])
        bodies = [corners_of(outline) for outline in _silhouettes(trajectory, last, projection)]
        return np.concatenate([around_links(trajectory, projection), *bodies])

    def start(self, trajectory: Trajectory, projection: Projection) -> FloatArray:
        """Corners of the bodies, and the links' frames."""
        robot = trajectory.problem.robot
        links = projection.of(robot.link_positions(configurations(trajectory)[:1])[0])
        return np.concatenate([links, *(corners_of(body) for body in _silhouettes(trajectory, 0, projection))])

    def has_ghosts(self, robot: Robot) -> bool:
        """Whether it has a skeleton: a path says all of a single body."""
        return bool(bones_of(robot))

    def robot(
        self, sheet: Sheet, trajectory: Trajectory, row: int, css: str, style: PlannerStyle | None
    ) -> Iterator[Mark]:
        """Silhouettes of the bodies at start and end, and lines between the recorded positions of joined links."""
        if css != GHOST:
            outlines = _silhouettes(trajectory, row, sheet.projection)
            yield Mark("".join(map(sheet.canvas.outline, outlines)), f"body {css}", style)
        ends = [np.stack([trajectory.link(name)[row] for name in bone]) for bone in bones_of(trajectory.problem.robot)]
        lines = "".join(path_through(sheet.canvas.pixels(sheet.projection.of(end))) for end in ends)
        yield Mark(lines, f"skeleton {css}", style, SKELETON_PX)


def bones_of(robot: Robot) -> list[tuple[str, str]]:
    """Pairs of links that a joint connects, the parent first."""
    assert isinstance(robot, SpatialRobot)
    own = set(robot.link_names)
    return [(joint.parent, joint.child) for joint in robot.urdf.joints if joint.parent in own and joint.child in own]


def _silhouettes(trajectory: Trajectory, row: int, projection: Projection) -> Iterator[Outline]:
    """Of a robot's collision geometry at a row; meshes that cannot be read any more are left out."""
    robot = trajectory.problem.robot
    assert isinstance(robot, SpatialRobot)
    frames = robot.link_frames(configurations(trajectory)[row])
    for frame, name in zip(frames, robot.link_names, strict=True):
        for shape in robot.urdf.link(name).collisions:
            try:
                yield from (silhouette(solid.placed(frame), projection) for solid in solids_of(shape))
            except (ScenarioError, OSError):
                continue


def silhouette(solid: Solid, projection: Projection) -> Outline:
    """What is seen of a placed solid."""
    points = projection.of(solid.points)
    if len(points) == 1:
        return Disc(points[0], solid.radius)
    if solid.radius > 0.0:
        circle = solid.radius * np.column_stack([np.cos(ROUND), np.sin(ROUND)])
        points = (points[:, None] + circle).reshape(-1, 2)
    return convex_hull(points)
