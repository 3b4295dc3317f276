"""Geometry of potential fields in space: control points on the robot, distances to obstacles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.motion.directions import lengths, unit
from pytest_lpb.planner.base import FloatArray, Observation, ObstacleInfo
from pytest_lpb.planner.fields import Points, SelfDistances, nearest_of_bodies
from pytest_lpb.problem.robot import Robot
from pytest_lpb.problem.spatial.robot import SpatialRobot

SAMPLES = 32  # configurations in which pairs of bodies are looked at
MESH_SPACING = 0.04  # [m] between the points that stand for a mesh


class SpatialControlPoints:
    """Points along the capsules that hold a robot's bodies, each with the radius of its capsule.

    A non-holonomic base without an arm cannot evade sideways, but a point ahead of it can: it has a second body there.

    Args:
        robot: spatial robot.
        spacing: largest distance between two of them along a capsule [m].
        lookahead: of the second body of a non-holonomic base [m].
    """

    def __init__(self, robot: Robot, spacing: float, lookahead: float) -> None:
        assert isinstance(robot, SpatialRobot)
        self._robot = robot
        ahead = (0.0, lookahead) if robot.non_holonomic and robot.n_actions == 2 else (0.0,)
        local: list[FloatArray] = []
        links: list[int] = []
        radii: list[float] = []
        bodies: list[int] = []
        owners: list[str] = []
        for body in robot.collision_bodies:
            for capsule in body.capsules:
                for shift in ahead:
                    start, end = np.array(capsule[:3]), np.array(capsule[3:6])
                    count = ceil(float(np.linalg.norm(end - start)) / spacing - 1e-9)
                    bodies.append(len(local))
                    for share in np.linspace(0.0, 1.0, count + 1) if count else (0.0,):
                        local.append(start + share * (end - start) + (shift, 0.0, 0.0))
                        links.append(robot.link_index(body.link))
                        radii.append(capsule[6])
                        owners.append(body.name)
        self.radii = np.array(radii)
        self.owners = owners
        self._links = np.array(links, dtype=np.intp)
        self._local = np.array(local).reshape(-1, 3)
        self._bodies: NDArray[np.intp] = np.array(bodies, dtype=np.intp)
        self._body_of = np.repeat(np.arange(len(bodies)), np.diff([*bodies, len(local)]))

    def at(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (m, 3) [m] and Jacobians per qd (m, 3, dof) at q."""
        frames, whole = self._robot.frames_and_jacobians(q)
        of_links, jacobians = frames[self._links], whole[self._links]
        arms = (of_links[:, :3, :3] @ self._local[:, :, None])[:, :, 0]
        spin = np.zeros((len(arms), 3, 3))  # minus the cross product matrices of the arms
        spin[:, 0, 1], spin[:, 0, 2], spin[:, 1, 2] = arms[:, 2], -arms[:, 1], arms[:, 0]
        spin -= np.swapaxes(spin, 1, 2)
        return of_links[:, :3, 3] + arms, jacobians[:, :3] + spin @ jacobians[:, 3:]

    def nearest(self, distance: FloatArray) -> FloatArray:
        """Which points (m, n), as True, are nearest of their body to an obstacle; of distances (m, n) [m]."""
        return nearest_of_bodies(distance, self._bodies, self._body_of)


class SpatialSelfDistances(SelfDistances):
    """Distances between a robot's own bodies, by the capsules that hold them.

    Capsules of neighbouring links overlap where their geometry does not: pairs that are nearer than `influence` in most
    configurations are left out.

    Args:
        robot: spatial robot.
        points: its control points.
        influence: distance [m] from which bodies repel each other.
    """

    def __init__(self, robot: Robot, points: Points, influence: float) -> None:
        super().__init__(robot, points)
        limits = np.clip(robot.limits.position, -np.pi, np.pi)
        generator = np.random.Generator(np.random.PCG64(0))
        near = np.zeros(len(robot.self_collision_pairs))
        for _ in range(SAMPLES):
            positions, _ = points.at(limits[:, 0] + generator.random(robot.dof) * (limits[:, 1] - limits[:, 0]))
            near += self.least(positions) < influence
        kept = [pair for pair, count in zip(robot.self_collision_pairs, near, strict=True) if count < 0.5 * SAMPLES]
        super().__init__(robot, points, kept)


class _Boxes:
    """Boxes, and spheres as boxes of no size that are rounded by a radius."""

    def __init__(self, obstacles: Sequence[ObstacleInfo]) -> None:
        self._half = np.array([0.5 * np.array(o.size) if o.size else np.zeros(3) for o in obstacles])
        self._radius = np.array([o.radius or 0.0 for o in obstacles])

    def distances(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of points (m, n, 3) in the obstacles' frames: signed distances (m, n), unit vectors (m, n, 3) outwards."""
        gap = np.abs(points) - self._half
        largest = gap.max(axis=-1)
        inside = largest <= 0.0
        # Outside away from the nearest point, inside out of the nearest face.
        out = np.where(inside[..., None], gap == largest[..., None], np.maximum(gap, 0.0))
        length = lengths(out)
        distance = np.where(inside, largest, length) - self._radius
        return distance, unit(np.copysign(out, points), length)


class _Long:
    """Capsules: distances to their axes."""

    def __init__(self, obstacles: Sequence[ObstacleInfo]) -> None:
        self._half = np.array([0.5 * (o.length or 0.0) for o in obstacles])
        self._radius = np.array([o.radius or 0.0 for o in obstacles])

    def distances(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """As of boxes."""
        out = points.copy()
        out[..., 2] -= np.clip(points[..., 2], -self._half, self._half)
        length = lengths(out)
        return length - self._radius, unit(out, length)


class _Cylinders:
    """Cylinders: boxes in the plane of axis and radius."""

    def __init__(self, obstacles: Sequence[ObstacleInfo]) -> None:
        self._half = np.array([0.5 * (o.length or 0.0) for o in obstacles])
        self._radius = np.array([o.radius or 0.0 for o in obstacles])

    def distances(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """As of boxes."""
        around = lengths(points[..., :2])
        gap = np.stack([around - self._radius, np.abs(points[..., 2]) - self._half], axis=-1)
        largest = gap.max(axis=-1)
        inside = largest <= 0.0
        out = np.where(inside[..., None], gap == largest[..., None], np.maximum(gap, 0.0))
        length = np.sqrt((out * out).sum(axis=-1))
        out = unit(out, length)
        radial = unit(points[..., :2], around)
        away = np.concatenate([out[..., :1] * radial, np.copysign(out[..., 1], points[..., 2])[..., None]], axis=-1)
        return np.where(inside, largest, length), away


class _Meshes:
    """Meshes, as points on their surfaces."""

    def __init__(self, obstacles: Sequence[ObstacleInfo]) -> None:
        from pytest_lpb.problem.spatial.meshes import surface_points  # late: it needs PyBullet

        self._clouds = [surface_points(o.file or "", o.scale, MESH_SPACING, concave=o.concave) for o in obstacles]

    def distances(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """As of boxes; distances are to the nearest point of the cloud, and never negative."""
        distance, away = np.empty(points.shape[:2]), np.empty(points.shape)
        for column, cloud in enumerate(self._clouds):
            offset = points[:, column, None, :] - cloud
            nearest = (offset * offset).sum(axis=-1).argmin(axis=1)
            away_from = offset[np.arange(len(nearest)), nearest]
            distance[:, column] = lengths(away_from)
            away[:, column] = unit(away_from, distance[:, column])
        return distance, away


# One entry per shape of obstacles in space.
_KINDS: dict[str, Callable[[Sequence[ObstacleInfo]], _Boxes | _Long | _Cylinders | _Meshes]] = {
    "sphere": _Boxes,
    "box": _Boxes,
    "capsule": _Long,
    "cylinder": _Cylinders,
    "mesh": _Meshes,
}


class SpatialObstacleField:
    """Distances of points to obstacles in space, those of one kind at once.

    Args:
        obstacles: what the planner was told of them; poses come with each observation.
    """

    def __init__(self, obstacles: Sequence[ObstacleInfo]) -> None:
        groups: dict[Callable[..., object], list[int]] = {}
        for index, obstacle in enumerate(obstacles):
            groups.setdefault(_KINDS[obstacle.shape], []).append(index)
        self._count = len(obstacles)
        self._groups = [
            (np.array(members), _KINDS[obstacles[members[0]].shape]([obstacles[i] for i in members]))
            for members in groups.values()
        ]

    def distances(self, points: FloatArray, observation: Observation) -> tuple[FloatArray, FloatArray]:
        """Signed distances (m, n) [m] of points (m, 3) to obstacles, and unit vectors (m, n, 3) away from them."""
        turns = _matrices(observation["obstacle_orientation"][: self._count])
        offset = points[:, None, :] - observation["obstacle_position"][: self._count]
        local = (offset[:, :, None, :] @ turns)[:, :, 0, :]
        distance, away = np.empty(local.shape[:2]), np.empty(local.shape)
        for members, kind in self._groups:
            distance[:, members], away[:, members] = kind.distances(local[:, members])
        return distance, (turns @ away[..., None])[..., 0]


def _matrices(q: FloatArray) -> FloatArray:
    """Rotation matrices (n, 3, 3) of unit quaternions wxyz (n, 4)."""
    w, x, y, z = q.T
    result = np.empty((len(q), 3, 3))
    result[:, 0, 0], result[:, 0, 1], result[:, 0, 2] = (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
    )
    result[:, 1, 0], result[:, 1, 1], result[:, 1, 2] = (
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
    )
    result[:, 2, 0], result[:, 2, 1], result[:, 2, 2] = (
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )
    return result
