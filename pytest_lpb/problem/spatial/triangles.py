"""Triangles of mesh files: Wavefront OBJ and STL."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.mesh_files import check_mesh, is_sound
from pytest_lpb.problem.spatial.meshes_of_stl import corners_of


def mesh_triangles(path: Path) -> FloatArray:
    """Corners (n, 3, 3) [m] of a mesh's triangles. Raises ScenarioError for what is no sound OBJ or STL."""
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise ScenarioError(f"{path}: triangles are read from .obj and .stl files")
    check_mesh(path)
    try:
        triangles = reader(path)
    except (ValueError, IndexError) as error:
        raise ScenarioError(f"{path}: cannot be read as {path.suffix[1:].upper()}: {error}") from None
    if not len(triangles):
        raise ScenarioError(f"{path}: has no triangles")
    return triangles


def can_be_read(path: Path) -> bool:
    """Whether a mesh's file is there, of a kind whose triangles are read, and sound."""
    return path.suffix.lower() in _READERS and path.is_file() and is_sound(path)


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
    return corners_of(path.read_bytes())


_READERS: dict[str, Callable[[Path], FloatArray]] = {".obj": _from_obj, ".stl": _from_stl}
