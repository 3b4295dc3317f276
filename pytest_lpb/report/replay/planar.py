"""Replays in the plane: capsules, discs and polygons."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.environment.heading import heading_of
from pytest_lpb.problem.planar.shapes import outline_of, planar_shape

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle
    from pytest_lpb.problem.robot import Robot

FloatArray = NDArray[np.float64]

DIGITS = 4  # after the point [m]


class PlanarMotion:
    """Parts: ["capsule", body, x, y, x, y, radius], ["disc", 0, radius], ["polygon", 0, [[x, y], ...]]."""

    def __init__(self) -> None:
        self.meshes: list[Path] = []

    def robot(self, robot: Robot) -> list[Any]:
        """Capsules of the bodies."""
        return [
            ["capsule", _links(robot).index(body.link), *(round(number, DIGITS) for number in capsule)]
            for body in robot.collision_bodies
            for capsule in body.capsules
        ]

    def heading(self, robot: Robot) -> list[Any] | None:
        """The base's."""
        found = heading_of(robot)
        return None if found is None else [_links(robot).index(found[0]), round(found[1], DIGITS)]

    def extent(self, robot: Robot, q: FloatArray) -> FloatArray:
        """Corners of squares around the ends of the capsules."""
        frames = np.array([robot.frames(row) for row in q.tolist()])
        points = [frames[:, :, :2].reshape(-1, 2)]
        for body in robot.collision_bodies:
            x, y, cos, sin = np.moveaxis(frames[:, robot.link_index(body.link)], 1, 0)
            for ax, ay, bx, by, radius in body.capsules:
                for px, py in ((ax, ay), (bx, by)):
                    end = np.column_stack([x + cos * px - sin * py, y + sin * px + cos * py])
                    points += [end - radius, end + radius]
        return np.concatenate(points)

    def poses(self, robot: Robot, q: FloatArray) -> FloatArray:
        """x, y, angle of the links that have bodies; the angle is never wrapped."""
        chosen = [robot.link_index(link) for link in _links(robot)]
        frames = np.array([robot.frames(row) for row in q.tolist()])[:, chosen]
        angles = np.unwrap(np.arctan2(frames[..., 3], frames[..., 2]), axis=0)
        return np.concatenate([frames[..., :2], angles[..., None]], axis=2)

    def obstacle(self, obstacle: Obstacle) -> list[Any]:
        """A disc, or a polygon."""
        outline = outline_of(planar_shape(obstacle.entry))
        if isinstance(outline, float):
            return [["disc", 0, outline]]
        return [["polygon", 0, [[round(x, DIGITS), round(y, DIGITS)] for x, y in outline]]]

    def obstacle_poses(self, obstacle: Obstacle, t: FloatArray) -> FloatArray:
        """x, y, angle."""
        positions, angles = obstacle.poses(t)
        return np.column_stack([positions, angles])

    def around(self, obstacle: Obstacle, t: FloatArray) -> FloatArray:
        """Corners of the square around it."""
        outline = outline_of(planar_shape(obstacle.entry))
        reach = outline if isinstance(outline, float) else float(np.linalg.norm(outline, axis=1).max())
        positions = obstacle.poses(t)[0]
        return np.concatenate([positions - reach, positions + reach])


def _links(robot: Robot) -> list[str]:
    return list(dict.fromkeys(body.link for body in robot.collision_bodies))
