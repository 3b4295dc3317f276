"""Vertices of meshes as PyBullet reads them, and capsules that hold a robot's collision geometry."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import lru_cache
from math import hypot, sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.content import file_digest
from pytest_lpb.problem.spatial.hulls import mesh_hulls
from pytest_lpb.problem.spatial.loadable_meshes import loadable_hulls
from pytest_lpb.problem.spatial.mesh_files import check_mesh
from pytest_lpb.problem.spatial.triangles import mesh_triangles
from pytest_lpb.problem.spatial.urdf import Geometry, Link, UrdfModel
from pytest_lpb.problem.spatial.urdf_writer import urdf_text

MAX_POINTS_PER_EDGE = 50

Capsule = tuple[float, ...]  # ax, ay, az, bx, by, bz, radius [m]


def mesh_vertices(path: Path, scale: tuple[float, float, float]) -> FloatArray:
    """Vertices (n, 3) [m] of all convex hulls of a mesh file, laid on PyBullet's grid.

    Raises ScenarioError for a file that PyBullet cannot read.
    """
    check_mesh(path)
    return _vertices(path, scale, file_digest(path))


@lru_cache(maxsize=256)
def _vertices(path: Path, scale: tuple[float, float, float], _digest: str) -> FloatArray:
    # As a robot's link: PyBullet reads more kinds of files for robots than for bodies made by hand.
    with tempfile.TemporaryDirectory() as folder:
        link = Link("mesh", (Geometry("mesh", scale, file=loadable_hulls(path, Path(folder))),))
        file = Path(folder) / "mesh.urdf"
        file.write_text(urdf_text(UrdfModel("mesh", (link,), ())), encoding="utf-8")
        client = Client()
        try:
            body = client.call("loadURDF", str(file), useFixedBase=True, flags=pybullet.URDF_IGNORE_VISUAL_SHAPES)
            vertices = np.array(client.call("getMeshData", body, -1)[1], dtype=float).reshape(-1, 3)
        except pybullet.error:
            vertices = np.zeros((0, 3))
        finally:
            client.close()
    if not len(vertices):
        raise ScenarioError(f"{path}: PyBullet cannot read this mesh; allowed are .obj, .stl and .dae files")
    vertices.flags.writeable = False
    return vertices


def covering_capsule(points: FloatArray) -> Capsule:
    """A small capsule that holds all points (n, 3): along their principal axis, its caps moved in as far as they go."""
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    offset = points - centre
    _, _, axes = np.linalg.svd(offset, full_matrices=False)
    axis = axes[0]
    along = offset @ axis
    across = offset - along[:, None] * axis
    # The middle of the points around the axis, not their mean: half of a link may have most of its vertices.
    shift = 0.5 * (across.min(axis=0) + across.max(axis=0))
    shift -= (shift @ axis) * axis
    distance = np.sqrt(((across - shift) ** 2).sum(axis=1))
    radius = float(distance.max())
    reach = np.sqrt(np.maximum(radius * radius - distance * distance, 0.0))  # of a cap beyond its centre, there
    low, high = float((along + reach).min()), float((along - reach).max())
    if low > high:
        low = high = 0.5 * (low + high)
        radius = float(np.sqrt(distance**2 + (along - low) ** 2).max())
    start, end = centre + shift + low * axis, centre + shift + high * axis
    return (*start.tolist(), *end.tolist(), radius)


def _placed(origin: FloatArray, half: float, radius: float) -> Capsule:
    """A capsule along z, its cap centres `half` [m] from the origin."""
    reach = half * origin[:3, 2]
    return (*(origin[:3, 3] - reach).tolist(), *(origin[:3, 3] + reach).tolist(), radius)


def _of_points(points: FloatArray, origin: FloatArray) -> Capsule:
    return covering_capsule(points @ origin[:3, :3].T + origin[:3, 3])


def _of_box(shape: Geometry) -> Capsule:
    corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T * np.array(shape.size)
    return _of_points(corners, shape.origin)


def _of_cylinder(shape: Geometry) -> Capsule:
    radius, length = shape.size
    if length > 2.0 * radius:  # caps whose balls just hold the rims
        half = 0.5 * length
        return _placed(shape.origin, half - 0.5 * radius, hypot(radius, 0.5 * radius))
    return _placed(shape.origin, 0.0, hypot(radius, 0.5 * length))


def _of_mesh(shape: Geometry) -> Capsule:
    assert shape.file is not None
    return _of_points(mesh_vertices(shape.file, (shape.size[0], shape.size[1], shape.size[2])), shape.origin)


_CAPSULES: dict[str, Callable[[Geometry], Capsule]] = {
    "sphere": lambda shape: _placed(shape.origin, 0.0, shape.size[0]),
    "capsule": lambda shape: _placed(shape.origin, 0.5 * shape.size[1], shape.size[0]),
    "box": _of_box,
    "cylinder": _of_cylinder,
    "mesh": _of_mesh,
}


def capsule_of(shape: Geometry) -> Capsule:
    """A capsule in the link's frame that holds a shape; exact for spheres and capsules."""
    return _CAPSULES[shape.kind](shape)


def surface_points(file: str, scale: float, spacing: float, *, concave: bool) -> FloatArray:
    """Points (n, 3) [m] on a mesh, or on its convex hulls, no farther than `spacing` [m] from their neighbours."""
    return surface_sample(file, scale, spacing, concave=concave)[0]


def surface_sample(file: str, scale: float, spacing: float, *, concave: bool) -> tuple[FloatArray, float]:
    """Points as `surface_points` gives them, and how far from the nearest of them the surface may be [m].

    Edges get at most `MAX_POINTS_PER_EDGE` points: on large faces the points lie farther apart than `spacing`.
    """
    triangles = scale * mesh_triangles(Path(file)) if concave else _hull_triangles(Path(file), scale)
    points, widest = [triangles.reshape(-1, 3)], 0.0
    for a, b, c in triangles:
        longest = float(max(np.linalg.norm(b - a), np.linalg.norm(c - b), np.linalg.norm(a - c)))
        count = min(int(longest / spacing), MAX_POINTS_PER_EDGE)
        widest = max(widest, longest / (count + 1))
        if count:
            pairs = [(i, j) for i in range(count + 2) for j in range(count + 2 - i)]
            shares = np.array(pairs, dtype=float) / (count + 1)
            points.append(a + shares[:, :1] * (b - a) + shares[:, 1:] * (c - a))
    # No point of a triangle is farther from its nearest corner than its longest edge over the root of 3.
    return np.unique(np.round(np.vstack(points), 6), axis=0), widest / sqrt(3.0)


def _hull_triangles(path: Path, scale: float) -> FloatArray:
    return np.concatenate([hull[_faces(hull)] for hull in mesh_hulls(path, (scale, scale, scale))])


def _faces(points: FloatArray) -> NDArray[np.intp]:
    """Triangles (n, 3) of the convex hull of points, as their indices."""
    from scipy.spatial import ConvexHull, QhullError  # late: it takes a third of a second

    try:
        found = ConvexHull(points)
    except QhullError:  # flat: moved apart by rounding errors
        found = ConvexHull(points, qhull_options="QJ")
    return np.asarray(found.simplices, dtype=np.intp)
