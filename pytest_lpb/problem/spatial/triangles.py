"""Triangles of mesh files: Wavefront OBJ and STL."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.robot import FloatArray

_STL_HEADER = 80  # bytes before the number of triangles
_STL_TRIANGLE = np.dtype([("numbers", "<f4", (4, 3)), ("attribute", "<u2")])  # normal, three corners


def mesh_triangles(path: Path) -> FloatArray:
    """Corners (n, 3, 3) [m] of a mesh's triangles. Raises ScenarioError for files that are neither OBJ nor STL."""
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise ScenarioError(f"{path}: triangles are read from .obj and .stl files")
    try:
        triangles = reader(path)
    except (ValueError, IndexError) as error:
        raise ScenarioError(f"{path}: cannot be read as {path.suffix[1:].upper()}: {error}") from None
    if not len(triangles):
        raise ScenarioError(f"{path}: has no triangles")
    return triangles


def can_be_read(path: Path) -> bool:
    """Whether a mesh's file is there, and of a kind whose triangles are read."""
    return path.suffix.lower() in _READERS and path.is_file()


def _from_obj(path: Path) -> FloatArray:
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        kind, *rest = line.split() or [""]
        if kind == "v":
            vertices.append([float(number) for number in rest[:3]])
        elif kind == "f":
            corners = [int(corner.partition("/")[0]) for corner in rest]
            corners = [corner - 1 if corner > 0 else len(vertices) + corner for corner in corners]
            triangles += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
    return np.array(vertices).reshape(-1, 3)[np.array(triangles, dtype=np.intp).reshape(-1, 3)]


def _from_stl(path: Path) -> FloatArray:
    content = path.read_bytes()
    count = int.from_bytes(content[_STL_HEADER : _STL_HEADER + 4], "little")
    if len(content) == _STL_HEADER + 4 + count * _STL_TRIANGLE.itemsize:
        rows = np.frombuffer(content, _STL_TRIANGLE, count, _STL_HEADER + 4)
        return np.asarray(rows["numbers"][:, 1:], dtype=float)
    lines = (line.split() for line in content.decode("ascii", errors="replace").splitlines())
    corners = [[float(number) for number in parts[1:4]] for parts in lines if parts[:1] == ["vertex"]]
    return np.array(corners).reshape(-1, 3, 3)


_READERS: dict[str, Callable[[Path], FloatArray]] = {".obj": _from_obj, ".stl": _from_stl}
