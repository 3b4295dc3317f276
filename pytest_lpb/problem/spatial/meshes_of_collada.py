"""Checks COLLADA files (.dae) as PyBullet reads them: every triangle names numbers that are there."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.spatial.mesh_limits import MAX_MESH_COORDINATE, MAX_MESH_TRIANGLES, MAX_MESH_VERTICES
from pytest_lpb.problem.spatial.xml_reader import Element, parse_xml

ARRAYS = ("triangles", "polylist", "polygons")
# What PyBullet takes to be there: without it, it ends the process.
ATTRIBUTES = {
    "unit": ("meter",),
    "geometry": ("id",),
    "vertices": ("id",),
    "input": ("semantic", "source"),
    "instance_geometry": ("url",),
    "instance_visual_scene": ("url",),
    "visual_scene": ("id",),
}
PARTS = {"COLLADA": ("asset", "library_geometries"), "vertices": ("input",), "triangles": ("p",)}
TEXTS = ("up_axis", "p")


def check_collada(content: bytes, path: Path) -> None:
    """Check a COLLADA file. Raises ScenarioError, with the line of what is wrong."""
    root = parse_xml(content, path, "COLLADA")
    if root.tag != "COLLADA":
        raise ScenarioError(f"{path}:{root.line}: found <{root.tag}>; a COLLADA file has <COLLADA>")
    for element in (root, *root.below()):
        _check_complete(element, path)
    vertices = triangles = 0
    for mesh in [element for element in root.below() if element.tag == "mesh"]:
        unnamed = [source for source in mesh.all("source") if "id" not in source.attributes]
        if unnamed:
            raise _fault(path, unnamed[0], "<source> has no id")
        rows = {source.attributes["id"]: _rows(source, path) for source in mesh.all("source")}
        _check_positions(mesh, rows, path)
        vertices += sum(rows.values())
        triangles += sum(_check_indices(part, mesh, rows, path) for kind in ARRAYS for part in mesh.all(kind))
    for found, most, what in (
        (vertices, MAX_MESH_VERTICES, "vertices and normals"),
        (triangles, MAX_MESH_TRIANGLES, "triangles"),
    ):
        if found > most:
            raise ScenarioError(f"{path}: has {found} {what}; allowed are {most}")


def _check_complete(element: Element, path: Path) -> None:
    """Raise ScenarioError for an element that lacks what PyBullet takes to be there."""
    for name in ATTRIBUTES.get(element.tag, ()):
        if not element.attributes.get(name, "").strip("# "):
            raise _fault(path, element, f"<{element.tag}> has no {name}")
    for tag in PARTS.get(element.tag, ()):
        if element.find(tag) is None:
            raise _fault(path, element, f"<{element.tag}> has no <{tag}>")
    if element.tag in TEXTS and not element.text.strip():
        raise _fault(path, element, f"<{element.tag}> is empty")


def _rows(source: Element, path: Path) -> int:
    """How many points a source of numbers has, by its stride."""
    array = source.find("float_array")
    if array is None:
        return 0
    numbers = _numbers(array, path)
    technique = source.find("technique_common")
    accessor = technique.find("accessor") if technique is not None else None
    if accessor is None:
        raise _fault(path, source, "<source> has no <technique_common> with an <accessor>")
    return len(numbers) // _whole(accessor, "stride", path, 1)


def _check_positions(mesh: Element, rows: Mapping[str, int], path: Path) -> None:
    """Raise ScenarioError for vertices without positions."""
    for vertices in mesh.all("vertices"):
        named = [given for given in vertices.all("input") if given.attributes["semantic"] == "POSITION"]
        if not any(given.attributes["source"].removeprefix("#") in rows for given in named):
            raise _fault(path, vertices, "<vertices> has no <input> of POSITION with a <source> of this mesh")


def _check_indices(part: Element, mesh: Element, rows: Mapping[str, int], path: Path) -> int:
    """How many triangles a part has, at least. Raises ScenarioError for indices of what is not there."""
    if not any(given.attributes["semantic"] == "VERTEX" for given in part.all("input")):
        raise _fault(path, part, f"<{part.tag}> has no <input> of VERTEX")
    inputs = [(_whole(given, "offset", path, 0), given) for given in part.all("input")]
    width = max((offset for offset, _ in inputs), default=0) + 1
    lists = [np.asarray(_numbers(given, path)) for given in part.all("p")]
    for indices, given in zip(lists, part.all("p"), strict=True):
        if len(indices) % width or not (indices == np.floor(indices)).all():
            raise _fault(path, given, f"found {len(indices)} numbers; whole ones are required, {width} for each corner")
        for offset, entry in inputs:
            used = indices[offset::width]
            for name in _sources(entry, mesh):
                there = rows.get(name, 0)
                if len(used) and not 0 <= used.min() <= used.max() < there:
                    raise _fault(
                        path, given, f"names point {used.max():.0f} or {used.min():.0f} of {there} in {name!r}"
                    )
    corners = sum(len(indices) // width for indices in lists)
    if _whole(part, "count", path, 0) > max(corners, len(lists)):
        raise _fault(path, part, f"says that it has {part.attributes['count']} parts, with {corners} corners")
    return corners // 3


def _sources(entry: Element, mesh: Element) -> list[str]:
    """Sources that an input reads: its own, or those of the vertices it names."""
    name = entry.attributes.get("source", "").removeprefix("#")
    for vertices in mesh.all("vertices"):
        if vertices.attributes["id"] == name:
            return [given.attributes.get("source", "").removeprefix("#") for given in vertices.all("input")]
    return [name]


def _whole(element: Element, key: str, path: Path, least: int) -> int:
    text = element.attributes.get(key, "" if key == "offset" else str(least))
    if not (text.isascii() and text.isdigit() and least <= int(text[:10]) and len(text) < 10):
        raise _fault(path, element, f"<{element.tag}> {key}: found {text[:60]!r}; a whole number is required")
    return int(text)


def _numbers(element: Element, path: Path) -> NDArray[np.float64]:
    words = element.text.split()
    try:
        numbers = np.array(words, dtype=str).astype(float) if words else np.zeros(0)
        right = bool((np.abs(numbers) <= MAX_MESH_COORDINATE).all())
    except ValueError:
        right = False
    if not right:
        raise _fault(path, element, f"<{element.tag}> holds what is no number, or none within ±{MAX_MESH_COORDINATE:g}")
    return numbers


def _fault(path: Path, element: Element, what: str) -> ScenarioError:
    return ScenarioError(f"{path}:{element.line}: {what}")
