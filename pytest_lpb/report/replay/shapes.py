"""Meshes for pictures in space: few enough triangles for a page, near enough to the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.problem.spatial.triangles import mesh_triangles
from pytest_lpb.report.replay.numbers import fine_step, listed

FloatArray = NDArray[np.float64]

MAX_TRIANGLES = 600  # of a mesh
POSITION_PARTS = 1000  # in which a mesh's longest side is told
SAME_VERTEX = 1_000_000  # cells along the longest side within which corners are one vertex
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
    # Corners of neighbours are vertices of their own in the file; the finest grid makes them one.
    whole = _merged(corners, np.arange(len(corners)).reshape(-1, 3), (corners - low) / size * SAME_VERTEX)
    vertices, faces = whole
    for cells in CELLS:
        if len(faces) <= most:
            break
        vertices, faces = _merged(*whole, (whole[0] - low) / size * cells)
    return vertices, faces


def _merged(vertices: FloatArray, faces: NDArray[np.intp], cells: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
    """One vertex, the mean, per occupied cell (rounded down), and the faces left between different ones, each once."""
    _, index = np.unique(_joined(np.floor(cells).astype(np.int64)), return_inverse=True)
    counts = np.bincount(index)
    means = np.column_stack([np.bincount(index, vertices[:, axis]) / counts for axis in range(3)])
    faces = index[faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(_joined(np.sort(faces, axis=1)), return_index=True)
    return means, faces[np.sort(first)]


def _joined(rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """Three whole numbers below 2^21 as one: sorting these is far faster than sorting rows."""
    joined: NDArray[np.intp] = (rows[:, 0] << 42) | (rows[:, 1] << 21) | rows[:, 2]
    return joined
