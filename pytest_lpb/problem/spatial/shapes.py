"""Shapes of obstacles in space: how PyBullet makes them, and what their distances need.

Bullet surrounds boxes, cylinders and convex hulls with a margin: what it measures is the distance to the shape grown by
a ball of `HULL_MARGIN_M`. Boxes and cylinders are made that much larger, so that Bullet's core, which it shrinks by the
margin again, is exactly the shape wanted; the margin is then added back to every distance. Spheres, capsules and
concave meshes have none.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import hypot, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.registries import FloatArray, registered_vertices
from pytest_lpb.problem.spatial.bullet_files import MARGIN_M, create_hulls
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.content import file_digest
from pytest_lpb.problem.spatial.hulls import mesh_hulls
from pytest_lpb.problem.spatial.loadable_meshes import loadable
from pytest_lpb.problem.spatial.mesh_files import check_mesh

HULL_MARGIN_M = 0.001  # [m] Bullet's margin around boxes, cylinders and convex hulls


@dataclass(frozen=True)
class BulletShape:
    """A shape as PyBullet makes it.

    Attributes:
        keywords: of `createCollisionShape`, with the margin.
        margin: [m] to add to distances.
        radius: [m] of a sphere around the shape's origin that holds it.
    """

    keywords: Mapping[str, Any]
    margin: float
    radius: float


def _sphere(entry: Mapping[str, Any]) -> BulletShape:
    keywords = {"shapeType": pybullet.GEOM_SPHERE, "radius": entry["radius"]}
    return BulletShape(keywords, 0.0, entry["radius"])


def _box(entry: Mapping[str, Any]) -> BulletShape:
    half = [0.5 * length for length in entry["size"]]
    grown = [length + HULL_MARGIN_M for length in half]
    kind = {"shapeType": pybullet.GEOM_BOX}
    radius = sqrt(sum(length * length for length in half))
    return BulletShape(kind | {"halfExtents": grown}, HULL_MARGIN_M, radius)


def _cylinder(entry: Mapping[str, Any]) -> BulletShape:
    radius, length = entry["radius"], entry["length"]
    kind = {"shapeType": pybullet.GEOM_CYLINDER}
    grown = {"radius": radius + HULL_MARGIN_M, "height": length + 2.0 * HULL_MARGIN_M}
    return BulletShape(kind | grown, HULL_MARGIN_M, hypot(radius, 0.5 * length))


def _capsule(entry: Mapping[str, Any]) -> BulletShape:
    radius, length = entry["radius"], entry["length"]
    kind = {"shapeType": pybullet.GEOM_CAPSULE, "radius": radius}
    return BulletShape(kind | {"height": length}, 0.0, radius + 0.5 * length)


# A new shape of obstacles in space is one entry here (and its class in the schema).
BULLET_SHAPES: dict[str, Callable[[Mapping[str, Any]], BulletShape]] = {
    "sphere": _sphere,
    "box": _box,
    "cylinder": _cylinder,
    "capsule": _capsule,
}


def shape_key(entry: Mapping[str, Any]) -> tuple[Any, ...]:
    """What a body is made of, wherever it lies: equal keys, equal shapes. Raises OSError for a file that is gone."""
    file = entry.get("file")
    size = entry.get("size")
    return (
        entry["shape"],
        entry.get("radius"),
        tuple(size) if size else None,
        entry.get("length"),
        *(() if entry["shape"] in (*BULLET_SHAPES, "mesh") else (registered_vertices(entry).tobytes(),)),
        *((file_digest(Path(file)), str(file), entry.get("scale"), entry.get("concave")) if file else ()),
    )


def create_body(client: Client, entry: Mapping[str, Any]) -> tuple[int, float, float]:
    """Create an obstacle's body at the origin: its PyBullet id, margin [m], and radius [m] of a sphere that holds it.

    Raises ScenarioError for a mesh that cannot be read.
    """
    if entry["shape"] == "mesh":
        check_mesh(Path(entry["file"]))
        return (_create_surface if entry.get("concave") else _create_hulls)(client, entry)
    if entry["shape"] not in BULLET_SHAPES:
        return _hulls_as_body(client, [registered_vertices(entry)])
    shape = BULLET_SHAPES[entry["shape"]](entry)
    collision = client.call("createCollisionShape", **shape.keywords)
    return _create_still(client, collision), shape.margin, shape.radius


def _create_hulls(client: Client, entry: Mapping[str, Any]) -> tuple[int, float, float]:
    """A mesh's convex hull, or the hull of each of its objects."""
    return _hulls_as_body(client, mesh_hulls(Path(entry["file"]), (entry.get("scale", 1.0),) * 3))


def _hulls_as_body(client: Client, hulls: Sequence[FloatArray]) -> tuple[int, float, float]:
    radius = max(float(np.linalg.norm(hull, axis=1).max()) for hull in hulls)
    return create_hulls(client, hulls), MARGIN_M, radius


def _create_surface(client: Client, entry: Mapping[str, Any]) -> tuple[int, float, float]:
    """A mesh's triangles."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            collision = client.call(
                "createCollisionShape",
                shapeType=pybullet.GEOM_MESH,
                fileName=str(loadable(Path(entry["file"]), Path(folder))),
                meshScale=[entry.get("scale", 1.0)] * 3,
                flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
            )
    except pybullet.error:
        raise ScenarioError(
            f"obstacle {entry['name']!r}: PyBullet cannot read {entry['file']}; "
            "meshes are .obj or .stl files of triangles"
        ) from None
    body = _create_still(client, collision)
    lower, upper = client.call("getAABB", body)
    return body, 0.0, sqrt(sum(max(abs(low), abs(high)) ** 2 for low, high in zip(lower, upper, strict=True)))


def _create_still(client: Client, collision: int) -> int:
    body: int = client.call("createMultiBody", baseMass=0, baseCollisionShapeIndex=collision)
    return body
