"""Convex hulls of meshes as the environment measures them: the vertices of the file, to the last digit.

What is one hull follows PyBullet: each named object or group of a Wavefront file, and any other file as a whole.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.bullet_files import saved_world, vertices_of
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.content import file_digest
from pytest_lpb.problem.spatial.mesh_files import check_mesh
from pytest_lpb.problem.spatial.meshes_of_stl import corners_of
from pytest_lpb.problem.spatial.meshes_of_wavefront import objects_of

FEW = 200  # vertices, among which looking for those inside of the hull takes longer than carrying them along

Hulls = tuple[FloatArray, ...]  # vertices (n, 3) [m] of each


def mesh_hulls(path: Path, scale: tuple[float, float, float]) -> Hulls:
    """Vertices (n, 3) [m] of each convex hull of a mesh file, in the file's axes, read-only.

    Raises ScenarioError for a file that is no mesh, or has no triangles.
    """
    check_mesh(path)
    return _hulls(path, scale, file_digest(path))


@lru_cache(maxsize=256)
def _hulls(path: Path, scale: tuple[float, float, float], _digest: str) -> Hulls:
    read = _READERS.get(path.suffix.lower())
    try:
        pieces = [] if read is None else [piece for piece in read(path) if len(piece)]
    except (ValueError, IndexError) as error:
        raise ScenarioError(f"{path}: cannot be read as {path.suffix[1:].upper()}: {error}") from None
    if not pieces:
        raise ScenarioError(f"PyBullet cannot read {path}; meshes are .obj, .stl or .dae files of triangles")
    hulls = tuple(_corners(piece * np.array(scale)) for piece in pieces)
    for hull in hulls:
        hull.flags.writeable = False
    return hulls


def _corners(points: FloatArray) -> FloatArray:
    """The points (n, 3) without most of those that are no corners of their convex hull."""
    points = np.unique(points, axis=0)
    if len(points) <= FEW:
        return points
    from scipy.spatial import ConvexHull, QhullError  # late: it takes a third of a second

    try:
        found: FloatArray = points[np.sort(ConvexHull(points).vertices)]
    except QhullError:  # flat
        return points
    return found


def _of_wavefront(path: Path) -> Iterable[FloatArray]:
    return objects_of(path.read_bytes())


def _of_stl(path: Path) -> Iterable[FloatArray]:
    return [corners_of(path.read_bytes()).reshape(-1, 3)]


def _of_collada(path: Path) -> Iterable[FloatArray]:
    """As PyBullet reads it, its units and the places of its parts included."""
    client = Client()
    try:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "mesh.urdf"
            file.write_text(_SURFACE.format(quoteattr(str(path))), encoding="utf-8")
            flags = pybullet.URDF_IGNORE_VISUAL_SHAPES
            client.call("loadURDF", str(file), useFixedBase=True, useMaximalCoordinates=True, flags=flags)
        return [vertices_of(saved_world(client))]
    except pybullet.error:
        return []
    finally:
        client.close()


_SURFACE = """<robot name="surface"><link name="surface"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial><collision concave="yes"><geometry>
<mesh filename={}/></geometry></collision></link></robot>
"""

_READERS: dict[str, Callable[[Path], Iterable[FloatArray]]] = {
    ".obj": _of_wavefront,
    ".stl": _of_stl,
    ".dae": _of_collada,
}
