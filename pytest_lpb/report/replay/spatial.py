"""Replays in space: the visual geometry of a robot's links, and obstacles, as solids and meshes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.environment.heading import heading_of
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.rotations import quaternions_of
from pytest_lpb.problem.spatial.solids import geometry_of, pose_from, solid_of
from pytest_lpb.problem.spatial.triangles import can_be_read
from pytest_lpb.problem.spatial.urdf import Geometry
from pytest_lpb.report.scene_marks import known_bodies

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle
    from pytest_lpb.problem.robot import Robot

FloatArray = NDArray[np.float64]

DIGITS = 4  # after the point, of lengths [m] and of matrices


class SpatialMotion:
    """Parts: [kind, body, size, pose as 12 numbers row by row, place of the mesh or null]."""

    def __init__(self) -> None:
        self.meshes: list[Path] = []

    def robot(self, robot: Robot) -> list[Any]:
        """What is seen of each link; what collides where a link's visual files are of a kind that is not read."""
        assert isinstance(robot, SpatialRobot)
        return [self._part(shape, body) for body, (_, shapes) in enumerate(_bodies(robot)) for shape in shapes]

    def heading(self, robot: Robot) -> list[Any] | None:
        """The base's."""
        assert isinstance(robot, SpatialRobot)
        found = heading_of(robot)
        return None if found is None else [_posed(robot).index(found[0]), round(found[1], DIGITS)]

    def extent(self, robot: Robot, q: FloatArray) -> FloatArray:
        """Corners of cubes around the ends of the bodies' capsules; the links where a mesh cannot be read any more."""
        assert isinstance(robot, SpatialRobot)
        frames = robot.link_frames_along(q)
        points = [frames[:, :, :3, 3].reshape(-1, 3)]
        for body in known_bodies(robot):
            pose = frames[:, robot.link_index(body.link)]
            for capsule in body.capsules:
                for point in (capsule[:3], capsule[3:6]):
                    end = pose[:, :3, :3] @ np.array(point) + pose[:, :3, 3]
                    points += [end - capsule[6], end + capsule[6]]
        return np.concatenate(points)

    def poses(self, robot: Robot, q: FloatArray) -> FloatArray:
        """Position and quaternion of the links that are told; quaternions do not jump to their negative."""
        assert isinstance(robot, SpatialRobot)
        chosen = [robot.link_index(name) for name in _posed(robot)]
        frames = robot.link_frames_along(q)[:, chosen]
        turns = quaternions_of(frames[..., :3, :3].reshape(-1, 3, 3)).reshape(*frames.shape[:2], 4)
        return np.concatenate([frames[..., :3, 3], continuous(turns)], axis=2)

    def obstacle(self, obstacle: Obstacle) -> list[Any]:
        """The shape as it collides."""
        return [self._part(geometry_of(obstacle), 0)]

    def obstacle_poses(self, obstacle: Obstacle, t: FloatArray) -> FloatArray:
        """Position and quaternion."""
        positions, turns = obstacle.poses(t)
        return np.concatenate([positions, continuous(turns)], axis=1)

    def around(self, obstacle: Obstacle, t: FloatArray) -> FloatArray:
        """Corners of boxes around what it consists of."""
        solid = solid_of(geometry_of(obstacle))
        positions, turns = obstacle.poses(t)
        points = [solid.placed(pose_from(*pose)).points for pose in zip(positions, turns, strict=True)]
        low, high = (np.array([edge(p, axis=0) for p in points]) for edge in (np.min, np.max))
        return np.concatenate([low - solid.radius, high + solid.radius])

    def _part(self, shape: Geometry, body: int) -> list[Any]:
        mesh = None
        if shape.file is not None:
            if shape.file not in self.meshes:
                self.meshes.append(shape.file)
            mesh = self.meshes.index(shape.file)
        pose = np.round(shape.origin[:3], DIGITS).ravel() + 0.0
        return [shape.kind, body, [round(float(length), DIGITS) for length in shape.size], pose.tolist(), mesh]


def continuous(turns: FloatArray) -> FloatArray:
    """Quaternions (N, ..., 4) with the sign that is nearest to the one before."""
    signs = np.where((turns[1:] * turns[:-1]).sum(axis=-1) < 0.0, -1.0, 1.0)
    result = turns.copy()
    result[1:] *= np.cumprod(signs, axis=0)[..., None]
    return result


def _posed(robot: SpatialRobot) -> list[str]:
    """Links whose poses are told: those with something to draw, then the one that shows the heading."""
    drawn = [name for name, _ in _bodies(robot)]
    found = heading_of(robot)
    return drawn if found is None or found[0] in drawn else [*drawn, found[0]]


def _bodies(robot: SpatialRobot) -> Iterator[tuple[str, list[Geometry]]]:
    """Links with something to draw."""
    for name in robot.link_names:
        link = robot.urdf.link(name)
        seen = [shape for shape in link.visuals if shape.file is None or can_be_read(shape.file)]
        shapes = seen if len(seen) == len(link.visuals) and seen else list(link.collisions) or seen
        readable = [shape for shape in shapes if shape.file is None or can_be_read(shape.file)]
        if readable:
            yield name, readable
