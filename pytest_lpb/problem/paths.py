"""Files that a problem names: URDFs, meshes and certified paths."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

# Where files are named: a section, and the key in it, or in each entry of its list.
PLACES = (("robot", "urdf"), ("obstacles", "file"), ("certified", "path"))


def with_absolute_paths(data: Any, folder: Path) -> Any:
    """Content of a scenario file in which relative paths are taken from `folder`; anything else stays as it is."""
    return with_paths(data, lambda path: os.path.normpath(folder / path))


def paths_in(data: Any) -> list[str]:
    """Every path in the content of a scenario file, as written there."""
    found: list[str] = []

    def keep(path: str) -> str:
        found.append(path)
        return path

    with_paths(data, keep)
    return found


def with_paths(data: Any, change: Callable[[str], str]) -> Any:
    """Content of a scenario file with every path changed; a copy where there is any."""
    if not isinstance(data, dict):
        return data
    result = dict(data)
    for section, key in PLACES:
        part = result.get(section)
        if isinstance(part, list):
            result[section] = [_changed(entry, key, change) for entry in part]
        elif part is not None:
            result[section] = _changed(part, key, change)
    return result


def _changed(part: Any, key: str, change: Callable[[str], str]) -> Any:
    if isinstance(part, dict) and isinstance(part.get(key), str):
        return {**part, key: change(part[key])}
    return part
