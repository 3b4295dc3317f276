"""Meshes in a form that PyBullet reads as they are meant, written beside what is loaded.

STL files of text become binary ones. OBJ files with groups that are no bodies get an object for each body.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from pytest_lpb.bounded import read_bounded
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.mesh_limits import MAX_MESH_BYTES
from pytest_lpb.problem.spatial.meshes_of_stl import HEADER_BYTES, TRIANGLE, corners_of, is_text
from pytest_lpb.problem.spatial.meshes_of_wavefront import count_objects, objects_of
from pytest_lpb.problem.spatial.urdf import Geometry, UrdfModel


def loadable(path: Path, folder: Path) -> Path:
    """A mesh that PyBullet reads: the file itself, or a copy of its triangles in `folder`.

    PyBullet takes an STL of text for a binary one, which ends the process or gives nothing.
    """
    if path.suffix.lower() != ".stl":
        return path
    content = read_bounded(path, MAX_MESH_BYTES, ScenarioError)
    if not is_text(content):
        return path
    corners = corners_of(content)
    rows = np.zeros(len(corners), TRIANGLE)
    rows["numbers"][:, 1:] = corners
    copy = folder / f"{len(list(folder.iterdir()))}.stl"
    copy.write_bytes(bytes(HEADER_BYTES) + len(rows).to_bytes(4, "little") + rows.tobytes())
    return copy


def loadable_hulls(path: Path, folder: Path) -> Path:
    """The same for a mesh of which PyBullet makes convex hulls: one for each body of `objects_of`."""
    if path.suffix.lower() != ".obj":
        return loadable(path, folder)
    content = read_bounded(path, MAX_MESH_BYTES, ScenarioError)
    bodies = objects_of(content)
    if len(bodies) == count_objects(content):
        return path
    copy = folder / f"{len(list(folder.iterdir()))}.obj"
    copy.write_text("".join(_object(number, points) for number, points in enumerate(bodies)), encoding="ascii")
    return copy


def _object(number: int, points: FloatArray) -> str:
    """An object of an OBJ that uses all its points, counted from its last one: enough for a hull."""
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
    last = len(points)
    faces = "".join(f"f {-last} {1 - last + index} {2 - last + index}\n" for index in range(last - 2))
    return f"o body{number}\n{vertices}{faces}"


def loadable_model(model: UrdfModel, folder: Path) -> UrdfModel:
    """The model with its collision meshes in a form that PyBullet reads."""

    def changed(shape: Geometry) -> Geometry:
        return shape if shape.file is None else replace(shape, file=loadable_hulls(shape.file, folder))

    return replace(
        model, links=tuple(replace(link, collisions=tuple(map(changed, link.collisions))) for link in model.links)
    )
