"""Files that a problem names: URDFs, meshes, SRDF files and certified paths."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from pytest_lpb.problem.packages import SCHEME, PackageFinder

Loc = tuple[str | int, ...]

# Where files are named: keys from the top down; lists on the way are gone through.
PLACES: tuple[tuple[str, ...], ...] = (
    ("robot", "urdf"),
    ("robot", "self_collision_pairs", "srdf"),
    ("obstacles", "file"),
    ("certified", "path"),
)


def with_absolute_paths(data: Any, folder: Path) -> Any:
    """Content of a scenario file in which relative paths are taken from `folder`; anything else stays as it is.

    So does `package://NAME/..` where ROS and the folders above have no such file.
    """
    finder = PackageFinder(folder / "scenario")

    def absolute(path: str) -> str:
        if path.startswith(SCHEME):
            return str(finder.find(path) or path)
        return os.path.normpath(folder / path)

    return with_paths(data, absolute)


def paths_in(data: Any) -> list[str]:
    """Every path in the content of a scenario file, as written there."""
    return [path for _, path in located_paths(data)]


def located_paths(data: Any) -> Iterator[tuple[Loc, str]]:
    """Every path in the content of a scenario file, and where it stands."""
    for keys in PLACES:
        if isinstance(data, dict):
            yield from _located(data, keys, ())


def _located(part: Any, keys: Sequence[str], loc: Loc) -> Iterator[tuple[Loc, str]]:
    if not keys:
        if isinstance(part, str):
            yield loc, part
    elif isinstance(part, list):
        for index, entry in enumerate(part):
            yield from _located(entry, keys, (*loc, index))
    elif isinstance(part, dict) and keys[0] in part:
        yield from _located(part[keys[0]], keys[1:], (*loc, keys[0]))


def with_paths(data: Any, change: Callable[[str], str]) -> Any:
    """Content of a scenario file with every path changed; a copy where there is any."""
    if not isinstance(data, dict):
        return data
    result = dict(data)
    for keys in PLACES:
        result = _changed(result, keys, change)
    return result


def _changed(part: Any, keys: Sequence[str], change: Callable[[str], str]) -> Any:
    if not keys:
        return change(part) if isinstance(part, str) else part
    if isinstance(part, list):
        return [_changed(entry, keys, change) for entry in part]
    if isinstance(part, dict) and keys[0] in part:
        return {**part, keys[0]: _changed(part[keys[0]], keys[1:], change)}
    return part
