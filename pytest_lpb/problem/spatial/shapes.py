"""Shapes of obstacles in space: how PyBullet makes them, and what their distances need.

Bullet surrounds boxes, cylinders and convex hulls with a margin: what it measures is the distance to the shape grown by
a ball of `HULL_MARGIN_M`. Boxes and cylinders are made that much larger, so that Bullet's core, which it shrinks by the
margin again, is exactly the shape wanted; the margin is then added back to every distance. Spheres, capsules and
concave meshes have none.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from math import hypot, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.registries import registered_vertices
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.loadable_meshes import loadable
from pytest_lpb.problem.spatial.mesh_files import check_mesh

HULL_MARGIN_M = 0.001  # [m] Bullet's margin around boxes, cylinders and convex hulls


@dataclass(frozen=True)
class BulletShape:
    """A shape as PyBullet makes it.

    Attributes:
        keywords: of `createCollisionShape`, with the margin.
        margin: [m] to add to distances.
        radius: [m] of a ball around the shape's origin that holds it; None: to be asked of PyBullet.
    """

    keywords: Mapping[str, Any]
    margin: float
    radius: float | None


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


def _mesh(entry: Mapping[str, Any]) -> BulletShape:
    concave = bool(entry.get("concave"))
    keywords = {
        "shapeType": pybullet.GEOM_MESH,
        "fileName": str(entry["file"]),
        "meshScale": [entry.get("scale", 1.0)] * 3,
    }
    flags = {"flags": pybullet.GEOM_FORCE_CONCAVE_TRIMESH} if concave else {}
    return BulletShape(keywords | flags, 0.0 if concave else HULL_MARGIN_M, None)


def _registered(entry: Mapping[str, Any]) -> BulletShape:
    vertices = registered_vertices(entry)
    keywords = {"shapeType": pybullet.GEOM_MESH, "vertices": vertices.tolist()}
    return BulletShape(keywords, HULL_MARGIN_M, float(np.linalg.norm(vertices, axis=1).max()))


# A new shape of obstacles in space is one entry here (and its class in the schema).
BULLET_SHAPES: dict[str, Callable[[Mapping[str, Any]], BulletShape]] = {
    "sphere": _sphere,
    "box": _box,
    "cylinder": _cylinder,
    "capsule": _capsule,
    "mesh": _mesh,
}

# Kinds of a robot's collision geometry whose distances carry no margin.
EXACT_GEOMETRIES = frozenset({"sphere", "capsule"})


def shape_key(entry: Mapping[str, Any]) -> tuple[Any, ...]:
    """What a body is made of, wherever it lies: equal keys, equal shapes."""
    file = entry.get("file")
    stat = Path(file).stat() if file else None
    size = entry.get("size")
    return (
        entry["shape"],
        entry.get("radius"),
        tuple(size) if size else None,
        entry.get("length"),
        *(() if entry["shape"] in BULLET_SHAPES else (registered_vertices(entry).tobytes(),)),
        *((str(file), stat.st_mtime_ns, stat.st_size, entry.get("scale"), entry.get("concave")) if stat else ()),
    )


def create_body(client: Client, entry: Mapping[str, Any]) -> tuple[int, float, float]:
    """Create an obstacle's body at the origin: its PyBullet id, margin [m], and radius [m] of a ball that holds it.

    Raises ScenarioError for a mesh that cannot be read.
    """
    if entry.get("file"):
        check_mesh(Path(entry["file"]))
    shape = BULLET_SHAPES.get(entry["shape"], _registered)(entry)
    try:
        with ExitStack() as stack:
            keywords = dict(shape.keywords)
            if "fileName" in keywords:
                folder = stack.enter_context(tempfile.TemporaryDirectory())
                keywords["fileName"] = str(loadable(Path(keywords["fileName"]), Path(folder)))
            collision = client.call("createCollisionShape", **keywords)
    except pybullet.error:
        raise ScenarioError(
            f"obstacle {entry['name']!r}: PyBullet cannot read {entry.get('file', entry['shape'])}; "
            "meshes are .obj or .stl files of triangles"
        ) from None
    body: int = client.call("createMultiBody", baseMass=0, baseCollisionShapeIndex=collision)
    radius = shape.radius
    if radius is None:
        radius = farthest_corner(client.call("getAABB", body), (0.0, 0.0, 0.0))
    return body, shape.margin, radius


def farthest_corner(box: tuple[tuple[float, ...], tuple[float, ...]], point: tuple[float, ...]) -> float:
    """Distance [m] of a point to the farthest corner of an axis-aligned box (lower, upper)."""
    return sqrt(sum(max(abs(low - x), abs(high - x)) ** 2 for low, high, x in zip(box[0], box[1], point, strict=True)))
