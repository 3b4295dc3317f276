"""Which files a scenario may name: those of its own project. One of a stranger is not to read, and record, others."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pytest_lpb.documents.faults import Fault, Loc
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.allowed import project_of, refusal
from pytest_lpb.problem.paths import PLACES


def escapes(data: Any, scenario: Path) -> list[Fault]:
    """A fault for each file outside of what a scenario file may name, by itself or through its URDF.

    Args:
        data: the file's content, paths absolute.
        scenario: the file.
    """
    named = list(_named(data))
    if not named:
        return []
    home = project_of(scenario)
    faults = [Fault(loc, f"{path} {refused}") for loc, path in named if (refused := refusal(Path(path), home))]
    return faults or [fault for loc, path in named if loc == URDF for fault in _escaping_meshes(loc, Path(path), home)]


URDF: Loc = ("robot", "urdf")


def _escaping_meshes(loc: Loc, urdf: Path, home: Path) -> Iterator[Fault]:
    # Imported late: most scenarios name no URDF.
    from pytest_lpb.problem.spatial.robot_files import escaping_meshes

    try:
        yield from (Fault(loc, text) for text in escaping_meshes(urdf, home))
    except ScenarioError:
        return  # it cannot be read, which is told with the robot's other faults


def _named(data: Any) -> Iterator[tuple[Loc, str]]:
    """Places of paths, and the paths."""
    for section, key in PLACES if isinstance(data, dict) else ():
        part = data.get(section)
        entries: list[tuple[Loc, Any]] = [((section,), part)]
        if isinstance(part, list):
            entries = [((section, index), item) for index, item in enumerate(part)]
        for loc, entry in entries:
            path = entry.get(key) if isinstance(entry, dict) else None
            if isinstance(path, str) and "\0" not in path:  # no file's name; the check that the file is there says so
                yield (*loc, key), path
