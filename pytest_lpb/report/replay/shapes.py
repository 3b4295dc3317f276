"""Meshes for pictures in space: few enough triangles for a page, near enough to the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.problem.spatial.triangles import mesh_triangles
from pytest_lpb.report.replay.numbers import fine_step, listed

FloatArray = NDArray[np.float64]

MAX_TRIANGLES = 420  # of a mesh
POSITION_PARTS = 1000  # in which a mesh's longest side is told
CELLS = (64, 48, 36, 28, 22, 18, 14, 11, 9, 7, 5, 3)  # along the longest side, tried in turn


def mesh_block(path: Path) -> dict[str, Any]:
    """A mesh as the page draws it. Raises ScenarioError and OSError when the file cannot be read."""
    vertices, faces = simplified(mesh_triangles(path), MAX_TRIANGLES)
    step = fine_step(vertices, POSITION_PARTS)
    return {"vertices": listed(vertices, step), "faces": listed(faces.astype(float), 1.0)}


def simplified(triangles: FloatArray, most: int) -> tuple[FloatArray, NDArray[np.intp]]:
    """Vertices (V, 3) and faces (F, 3) of a mesh given as corners (n, 3, 3), with at most `most` faces if it can be.

    Vertices within a cell of a grid become their mean (Rossignac and Borrel, 1993); the finest grid that does is taken.
    """
    corners = triangles.reshape(-1, 3)
    low, size = corners.min(axis=0), float(np.ptp(corners, axis=0).max()) or 1.0
    vertices, faces = _merged(corners, np.round((corners - low) / size * 1e6).astype(np.int64))
    for cells in CELLS:
        if len(faces) <= most:
            break
        vertices, faces = _merged(corners, np.floor((corners - low) / size * cells).astype(np.int64))
    return vertices, faces


def _merged(corners: FloatArray, cells: NDArray[np.int64]) -> tuple[FloatArray, NDArray[np.intp]]:
    """One vertex per occupied cell, and the faces that are left between different ones, each once."""
    _, index = np.unique(cells, axis=0, return_inverse=True)
    index = index.reshape(-1)
    counts = np.bincount(index)
    vertices = np.column_stack([np.bincount(index, corners[:, axis]) / counts for axis in range(3)])
    faces = index.reshape(-1, 3)
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return vertices, faces[np.sort(first)]
