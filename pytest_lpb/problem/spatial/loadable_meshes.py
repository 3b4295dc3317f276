"""Meshes in a form that PyBullet reads: STL files of text are written as binary ones, beside what is loaded."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from pytest_lpb.bounded import read_bounded
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.spatial.mesh_limits import MAX_MESH_BYTES
from pytest_lpb.problem.spatial.meshes_of_stl import HEADER_BYTES, TRIANGLE, corners_of, is_text
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


def loadable_model(model: UrdfModel, folder: Path) -> UrdfModel:
    """The model with its collision meshes in a form that PyBullet reads."""

    def changed(shape: Geometry) -> Geometry:
        return shape if shape.file is None else replace(shape, file=loadable(shape.file, folder))

    return replace(
        model, links=tuple(replace(link, collisions=tuple(map(changed, link.collisions))) for link in model.links)
    )
