"""What pictures need of shapes in space: a few points that span them, and a radius around these."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pytest_lpb.problem.extents import extents_of
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.rotations import matrix_of
from pytest_lpb.problem.spatial.urdf import Geometry

RIM_POINTS = 24  # of a cylinder's rims

OBSTACLE_SIZES: dict[str, Callable[[Obstacle], tuple[float | None, ...]]] = {
    "sphere": lambda obstacle: (obstacle.radius,),
    "box": lambda obstacle: obstacle.size or (),
    "cylinder": lambda obstacle: (obstacle.radius, obstacle.length),
    "capsule": lambda obstacle: (obstacle.radius, obstacle.length),
    "mesh": lambda obstacle: (obstacle.scale,) * 3,
}


@dataclass(frozen=True, eq=False)
class Solid:
    """The convex hull of `points` (N, 3) [m], grown by `radius` [m]."""

    points: FloatArray
    radius: float = 0.0

    def placed(self, pose: FloatArray) -> Solid:
        """The same at a pose (4, 4)."""
        return Solid(self.points @ pose[:3, :3].T + pose[:3, 3], self.radius)


def geometry_of(obstacle: Obstacle) -> Geometry:
    """An obstacle's shape as a robot's links have them; of a registered shape the box around it."""
    if obstacle.shape not in OBSTACLE_SIZES:
        return Geometry("box", extents_of(obstacle))
    size = tuple(float(value or 0.0) for value in OBSTACLE_SIZES[obstacle.shape](obstacle))
    return Geometry(obstacle.shape, size, file=None if obstacle.file is None else Path(obstacle.file))


def _box(shape: Geometry) -> Solid:
    signs = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
    return Solid(signs * np.array(shape.size))


def _cylinder(shape: Geometry) -> Solid:
    radius, length = shape.size
    angles = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS, endpoint=False)
    rim = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full(RIM_POINTS, 0.5 * length)])
    return Solid(np.concatenate([rim, rim * (1.0, 1.0, -1.0)]))


def _capsule(shape: Geometry) -> Solid:
    radius, length = shape.size
    return Solid(np.array([[0.0, 0.0, -0.5 * length], [0.0, 0.0, 0.5 * length]]), radius)


def _mesh(shape: Geometry) -> Solid:
    from pytest_lpb.problem.spatial.meshes import mesh_vertices  # imports PyBullet

    assert shape.file is not None
    return Solid(mesh_vertices(shape.file, (shape.size[0], shape.size[1], shape.size[2])))


_SOLIDS: dict[str, Callable[[Geometry], Solid]] = {
    "sphere": lambda shape: Solid(np.zeros((1, 3)), shape.size[0]),
    "box": _box,
    "cylinder": _cylinder,
    "capsule": _capsule,
    "mesh": _mesh,
}


def solid_of(shape: Geometry) -> Solid:
    """The solid of a shape, at its origin; of a mesh, its convex hull.

    Raises ScenarioError and OSError for a mesh that cannot be read.
    """
    return _SOLIDS[shape.kind](shape).placed(shape.origin)


def solids_of(shape: Geometry) -> list[Solid]:
    """The same with a solid for each convex hull of a mesh: together they are what collides."""
    from pytest_lpb.problem.spatial.hulls import mesh_hulls  # imports PyBullet

    if shape.file is None:
        return [solid_of(shape)]
    hulls = mesh_hulls(shape.file, (shape.size[0], shape.size[1], shape.size[2]))
    return [Solid(hull).placed(shape.origin) for hull in hulls]


def pose_from(position: FloatArray, quaternion: FloatArray) -> FloatArray:
    """Pose (4, 4) from a position (3,) [m] and a unit quaternion wxyz (4,)."""
    pose = np.eye(4)
    pose[:3, :3] = matrix_of(quaternion.tolist())
    pose[:3, 3] = position
    return pose
