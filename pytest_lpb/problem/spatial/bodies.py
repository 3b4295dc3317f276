"""Shapes of a robot as bodies whose distances PyBullet measures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import hypot
from typing import Any

import numpy as np

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.bullet_files import MARGIN_M, create_hulls
from pytest_lpb.problem.spatial.client import Client
from pytest_lpb.problem.spatial.convex.cores import CORES, Core, Points
from pytest_lpb.problem.spatial.hulls import Hulls, mesh_hulls
from pytest_lpb.problem.spatial.layout import Part
from pytest_lpb.problem.spatial.rotations import from_matrix, matrix_of
from pytest_lpb.problem.spatial.shapes import BULLET_SHAPES, HULL_MARGIN_M
from pytest_lpb.problem.spatial.urdf import Geometry

NO_LINK = -1  # PyBullet's index of the base


@dataclass(eq=False, slots=True)
class Body:
    """A part of the robot whose distance is measured: one shape.

    Attributes:
        name: of the robot's link.
        id: PyBullet's body, and `link`: the index of its link.
        margin: [m] to add to distances.
        radius: [m] of a sphere around the robot's link's frame that holds the shape.
        cores: its convex shapes, in the frame of the centre of mass of the link that carries it.
        carrier: of a body of its own, the robot's link that carries it, with its frame in the link's centre of mass.
        move: of the robot, by their number, that the body was last put to its place after.
    """

    name: str
    id: int
    link: int
    margin: float
    radius: float
    cores: tuple[Core, ...]
    carrier: int | None = None
    move: int = -1


def create_part(client: Client, robot: int, part: Part, link: int) -> Body:
    """The body of a part of a robot, made where it is separate.

    Args:
        client: where the robot is loaded.
        robot: PyBullet's id of it.
        part: the shape.
        link: PyBullet's index of the link that carries it.

    Raises ScenarioError for a mesh that cannot be read.
    """
    margin = _MARGINS.get(part.shape.kind, HULL_MARGIN_M)
    radius = farthest_point(part.shape)
    pose = np.linalg.inv(_centre_of_mass(client, robot, link)) @ part.placed.origin
    cores = tuple(core.placed(pose[:3, :3], pose[:3, 3]) for core in _cores_of(part.shape))
    if not part.separate:
        return Body(part.name, robot, link, margin, radius, cores)
    create = _create_mesh if part.shape.kind == "mesh" else _create_shape
    return Body(part.name, create(client, part.shape, pose), NO_LINK, margin, radius, cores, carrier=link)


def _cores_of(shape: Geometry) -> tuple[Core, ...]:
    if shape.kind == "mesh":
        return tuple(Points(hull) for hull in _hulls_of(shape))
    return (CORES[shape.kind](_ENTRIES[shape.kind](shape)),)


def farthest_point(shape: Geometry) -> float:
    """Distance [m] from the link's frame to the farthest point of a shape."""
    return _FARTHEST[shape.kind](shape)


def _centre_of_mass(client: Client, robot: int, link: int) -> FloatArray:
    """Pose (4, 4) of the frame of a link's centre of mass in the link's frame."""
    position, (x, y, z, w) = client.call("getLinkState", robot, link)[2:4]
    pose = np.eye(4)
    pose[:3, :3] = matrix_of((w, x, y, z))
    pose[:3, 3] = position
    return pose


def _create_mesh(client: Client, shape: Geometry, pose: FloatArray) -> int:
    return create_hulls(client, [hull @ pose[:3, :3].T + pose[:3, 3] for hull in _hulls_of(shape)])


def _create_shape(client: Client, shape: Geometry, pose: FloatArray) -> int:
    w, x, y, z = from_matrix(pose[:3, :3])
    keywords = BULLET_SHAPES[shape.kind](_ENTRIES[shape.kind](shape)).keywords
    collision = client.call(
        "createCollisionShape",
        **keywords,
        collisionFramePosition=pose[:3, 3].tolist(),
        collisionFrameOrientation=(x, y, z, w),
    )
    body: int = client.call("createMultiBody", baseMass=0, baseCollisionShapeIndex=collision)
    return body


def _hulls_of(shape: Geometry) -> Hulls:
    assert shape.file is not None
    return mesh_hulls(shape.file, (shape.size[0], shape.size[1], shape.size[2]))


def _round(shape: Geometry) -> dict[str, Any]:
    return {"radius": shape.size[0], "length": shape.size[-1]}


# Of shapes whose distances carry another margin than `HULL_MARGIN_M`.
_MARGINS = {"sphere": 0.0, "capsule": 0.0, "mesh": MARGIN_M}

# A shape's sizes as obstacles have them.
_ENTRIES: dict[str, Callable[[Geometry], Mapping[str, Any]]] = {
    "sphere": _round,
    "cylinder": _round,
    "capsule": _round,
    "box": lambda shape: {"size": shape.size},
}


def _farthest_of(points: FloatArray, shape: Geometry) -> float:
    return float(np.linalg.norm(points @ shape.origin[:3, :3].T + shape.origin[:3, 3], axis=1).max())


def _farthest_of_box(shape: Geometry) -> float:
    corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T * np.array(shape.size)
    return _farthest_of(corners, shape)


def _farthest_of_capsule(shape: Geometry) -> float:
    ends = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, -0.5]]) * (shape.size[1] if shape.kind == "capsule" else 0.0)
    return _farthest_of(ends, shape) + shape.size[0]


def _farthest_of_cylinder(shape: Geometry) -> float:
    x, y, z = (shape.origin[:3, :3].T @ shape.origin[:3, 3]).tolist()  # the link's frame, seen from the shape
    return hypot(hypot(x, y) + shape.size[0], abs(z) + 0.5 * shape.size[1])


_FARTHEST: dict[str, Callable[[Geometry], float]] = {
    "sphere": _farthest_of_capsule,
    "capsule": _farthest_of_capsule,
    "box": _farthest_of_box,
    "cylinder": _farthest_of_cylinder,
    "mesh": lambda shape: max(_farthest_of(hull, shape) for hull in _hulls_of(shape)),
}
