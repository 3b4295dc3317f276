"""Checks STL files: binary ones of exactly the length that their count of triangles needs, or texts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.spatial.mesh_limits import MAX_MESH_COORDINATE, MAX_MESH_TRIANGLES

HEADER_BYTES = 80  # before the number of triangles
TRIANGLE = np.dtype([("numbers", "<f4", (4, 3)), ("attribute", "<u2")])  # normal, three corners


def is_binary(content: bytes) -> bool:
    """Whether an STL is binary, and as long as its count of triangles says."""
    return len(content) == _length(_count(content))


def is_text(content: bytes) -> bool:
    """Whether an STL is a text, as far as its first word says."""
    return not is_binary(content) and content.lstrip()[:5].lower() == b"solid"


def corners_of(content: bytes) -> NDArray[np.float64]:
    """Corners (n, 3, 3) of the triangles. Raises ValueError for a text with words that are no numbers."""
    if is_binary(content):
        rows = np.frombuffer(content, TRIANGLE, _count(content), HEADER_BYTES + 4)
        return np.asarray(rows["numbers"][:, 1:], dtype=float)
    lines = (line.split() for line in content.decode("ascii", errors="replace").splitlines())
    corners = [[float(number) for number in parts[1:4]] for parts in lines if parts and parts[0].lower() == "vertex"]
    return np.array(corners).reshape(-1, 3, 3)


def check_stl(content: bytes, path: Path) -> None:
    """Check an STL file. Raises ScenarioError."""
    if not (is_binary(content) or is_text(content)):
        count = _count(content)
        raise ScenarioError(
            f"{path}: is damaged: {count} triangles take {_length(count)} bytes, but the file has {len(content)}"
        )
    try:
        corners = corners_of(content)
    except ValueError as error:
        raise ScenarioError(f"{path}: is damaged: {error}") from None
    if not 0 < len(corners) <= MAX_MESH_TRIANGLES:
        raise ScenarioError(f"{path}: has {len(corners)} triangles; allowed are 1 to {MAX_MESH_TRIANGLES}")
    right = (np.abs(corners) <= MAX_MESH_COORDINATE).all(axis=(1, 2))
    if not right.all():
        row = int(np.argmin(right))
        raise ScenarioError(
            f"{path}: triangle {row} has the corners {corners[row].tolist()}; "
            f"allowed are numbers within ±{MAX_MESH_COORDINATE:g}"
        )


def _count(content: bytes) -> int:
    return int.from_bytes(content[HEADER_BYTES : HEADER_BYTES + 4], "little")


def _length(triangles: int) -> int:
    return HEADER_BYTES + 4 + triangles * TRIANGLE.itemsize
