"""Checks Wavefront OBJ files as PyBullet reads them: every face names vertices that came before it."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.spatial.mesh_limits import (
    MAX_LINE_BYTES,
    MAX_LINES,
    MAX_MESH_COORDINATE,
    MAX_MESH_TRIANGLES,
    MAX_MESH_VERTICES,
)

Vertices = NDArray[np.float64]
Indices = NDArray[np.intp]

_LONG_LINE = re.compile(rb"[^\n]{%d,}" % (MAX_LINE_BYTES + 1))
_NO_TEXT = re.compile(rb"[\x00\x0b\x0c]|\r(?!\n)")
_VERTEX, _FACE = (re.compile(rb"^[ \t]*%s[ \t]+([^\r\n]*)" % kind, re.MULTILINE) for kind in (b"v", b"f"))
_CORNER = rb"-?\d{1,9}(?:/-?\d{0,9}){0,2}"
_CORNERS = re.compile(rb"(?:(?:[ \t]*%s(?=[ \t\n])){2,}[ \t]*\n)*" % _CORNER)
_BEHIND = re.compile(rb"/[^ \t\n]*")  # of a corner: texture and normal, whose numbers PyBullet checks itself
_OBJECT = re.compile(rb"^[ \t]*[og][ \t]+[^\s]", re.MULTILINE)
_MATERIALS = re.compile(rb"^[ \t]*mtllib[ \t]+([^\r\n]*)", re.MULTILINE)
_TEXTURES = re.compile(rb"^[ \t]*(?:map_\w+|bump|disp|decal|refl|norm)[ \t]+([^\r\n]*)", re.MULTILINE)


def check_wavefront(content: bytes, path: Path) -> None:
    """Check an OBJ file. Raises ScenarioError, with its line where a line is wrong."""
    _check_text(content, path)
    vertices, faces = list(_VERTEX.finditer(content)), list(_FACE.finditer(content))
    _check_count(len(vertices), MAX_MESH_VERTICES, "vertices", path)
    _check_vertices(vertices, path)
    if not faces:
        raise ScenarioError(f"{path}: has no triangles (lines that begin with f)")
    corners = _corners(faces, path)
    _check_count(int(np.maximum(corners - 2, 0).sum()), MAX_MESH_TRIANGLES, "triangles", path)
    rows = np.repeat(np.arange(len(faces)), corners)
    defined, used = (np.array([match.start() for match in matches]) for matches in (vertices, faces))
    indices, before = _indices(faces), np.searchsorted(defined, used)[rows]
    wrong = (indices > before) | (indices < -before) | (indices == 0)
    if wrong.any():
        corner = int(np.argmax(wrong))
        raise _fault(faces[rows[corner]], path, f"names vertex {indices[corner]} of {before[corner]} before this line")


def objects_of(content: bytes) -> list[NDArray[np.float64]]:
    """Vertices (n, 3) of each body of a sound OBJ: of each named object or group whose surface is closed.

    Those are the parts of a convex decomposition, as V-HACD and CoACD write them. All surfaces that are open, such as
    the sides of a body that its exporter has put into groups, are one body; PyBullet takes each side for itself.
    """
    vertices, faces = list(_VERTEX.finditer(content)), list(_FACE.finditer(content))
    rows = [match.group(1).split(None, 3)[:3] for match in vertices]
    points = np.array(rows, dtype=float).reshape(-1, 3)
    corners = np.array([len(match.group(1).split()) for match in faces], dtype=np.intp)
    defined, used = (np.array([match.start() for match in matches]) for matches in (vertices, faces))
    begun = np.array([match.start() for match in _OBJECT.finditer(content)])
    owner = np.repeat(np.where(corners > 2, np.searchsorted(begun, used), -1), corners)
    before = np.repeat(np.searchsorted(defined, used), corners)
    indices = _indices(faces)
    indices = np.where(indices > 0, indices - 1, before + indices)
    if len(np.unique(owner[owner >= 0])) > 1:
        owner = _bodies(points, indices, owner, corners)
    return [points[np.unique(indices[owner == part])] for part in np.unique(owner) if part >= 0]


def count_objects(content: bytes) -> int:
    """How many objects or groups with triangles an OBJ has, each of which PyBullet takes for a body."""
    begun = np.array([match.start() for match in _OBJECT.finditer(content)])
    used = [match.start() for match in _FACE.finditer(content) if len(match.group(1).split()) > 2]
    return len(np.unique(np.searchsorted(begun, np.array(used, dtype=np.intp))))


def _bodies(points: Vertices, indices: Indices, owner: Indices, corners: Indices) -> Indices:
    """The owner of each corner, with all owners of open surfaces made one.

    A surface is closed where each edge is in an even number of its faces; vertices at one place are the same.

    Args:
        points: vertices (n, 3).
        indices: of the vertex of each corner of each face (m,).
        owner: of each corner (m,); -1 for faces that are none.
        corners: how many each face has.
    """
    places = np.unique(points, axis=0, return_inverse=True)[1].reshape(-1)[indices]
    ends = np.cumsum(corners)
    following = np.roll(places, -1)
    following[ends - 1] = places[ends - corners]  # the last corner's edge leads to the first of its face
    edges = np.stack([owner, np.minimum(places, following), np.maximum(places, following)])
    edges, counts = np.unique(edges[:, (places != following) & (owner >= 0)], axis=1, return_counts=True)
    is_open = np.unique(edges[0, counts % 2 == 1])
    return owner if len(is_open) < 2 else np.where(np.isin(owner, is_open), is_open[0], owner)


def materials_of(content: bytes) -> Iterator[tuple[int, str]]:
    """Lines and names of the material files that an OBJ names."""
    yield from _names(_MATERIALS, content)


def textures_of(content: bytes, path: Path) -> Iterator[tuple[int, str]]:
    """Lines and names of the textures that a material file names. Raises ScenarioError for one that is no text."""
    _check_text(content, path)
    yield from _names(_TEXTURES, content)


def _names(pattern: re.Pattern[bytes], content: bytes) -> Iterator[tuple[int, str]]:
    """Each name once: of one file by ten million lines, too."""
    lines = {match.group(1): match.start() for match in reversed(list(pattern.finditer(content)))}
    for text, start in lines.items():
        name = text.decode("utf-8", errors="surrogateescape")
        # The whole line, and each word of it: readers differ in whether names have blanks, and options before them.
        for part in dict.fromkeys([name.strip(), name, *name.split()]):
            yield _line(content, start), part


def _check_text(content: bytes, path: Path) -> None:
    _check_count(content.count(b"\n"), MAX_LINES, "lines", path)
    found = _NO_TEXT.search(content)
    if found is not None:
        place = f"{path}:{_line(content, found.start())}"
        raise ScenarioError(f"{place}: found the byte 0x{found.group()[0]:02x}; this should be a text")
    found = _LONG_LINE.search(content)
    if found is not None:
        place = f"{path}:{_line(content, found.start())}"
        raise ScenarioError(f"{place}: has {len(found.group())} bytes in a line; allowed are {MAX_LINE_BYTES}")


def _check_count(found: int, most: int, what: str, path: Path) -> None:
    if found > most:
        raise ScenarioError(f"{path}: has {found} {what}; allowed are {most}")


def _check_vertices(vertices: list[re.Match[bytes]], path: Path) -> None:
    """Raise ScenarioError for vertices that are not three numbers or more."""
    rows = [match.group(1).split(None, 3)[:3] for match in vertices]
    if all(len(row) == 3 for row in rows) and _all_within(b" ".join([word for row in rows for word in row])):
        return
    for match, row in zip(vertices, rows, strict=True):
        if len(row) < 3 or not _all_within(b" ".join(row)):
            raise _fault(match, path, f"a vertex has three numbers within ±{MAX_MESH_COORDINATE:g}")


def _all_within(text: bytes) -> bool:
    """Whether words are numbers within the limit."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # what NumPy says of words that are none
        try:
            numbers = np.fromstring(text, dtype=float, sep=" ")
        except (ValueError, DeprecationWarning):
            return False
    return bool((np.abs(numbers) <= MAX_MESH_COORDINATE).all())


def _corners(faces: list[re.Match[bytes]], path: Path) -> NDArray[np.intp]:
    """How many corners each face has. Raises ScenarioError for one that has one only, or is no list of indices."""
    rows = [match.group(1) for match in faces]
    if not _CORNERS.fullmatch(b"\n".join([*rows, b""])):
        match = next(match for match in faces if not _CORNERS.fullmatch(match.group(1) + b"\n"))
        raise _fault(match, path, "a face has two corners or more, each an index, or several with / between them")
    return np.array([len(row.split()) for row in rows], dtype=np.intp)


def _indices(faces: list[re.Match[bytes]]) -> NDArray[np.intp]:
    """Index of the vertex of each corner (n,)."""
    text = b" ".join([match.group(1) for match in faces])
    return np.fromstring(_BEHIND.sub(b"", text) if b"/" in text else text, dtype=np.intp, sep=" ")


def _fault(match: re.Match[bytes], path: Path, what: str) -> ScenarioError:
    shown = match.group()[:60].decode("utf-8", errors="replace").strip()
    return ScenarioError(f"{path}:{_line(match.string, match.start())}: cannot be read as OBJ: found {shown!r}; {what}")


def _line(content: bytes, at: int) -> int:
    return content.count(b"\n", 0, at) + 1
