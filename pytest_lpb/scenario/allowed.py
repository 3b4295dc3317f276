"""Which files a scenario may name: those of its own project. One of a stranger is not to read, and record, others."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pytest_lpb.documents.faults import Fault, Loc
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.allowed import project_of, refusal
from pytest_lpb.problem.packages import SCHEME, PackageFinder
from pytest_lpb.problem.paths import located_paths


def escapes(data: Any, scenario: Path) -> list[Fault]:
    """A fault for each file outside of what a scenario file may name, by itself or through its URDF.

    Args:
        data: the file's content, paths absolute.
        scenario: the file.
    """
    # A text with \0 is no file's name; the check that the file is there says so.
    named = [(loc, path) for loc, path in located_paths(data) if "\0" not in path]
    if not named:
        return []
    home = project_of(scenario)
    faults = [fault for loc, path in named if (fault := _fault(loc, path, scenario, home))]
    return faults or [fault for loc, path in named if loc == URDF for fault in _escaping_meshes(loc, Path(path), home)]


def _fault(loc: Loc, path: str, scenario: Path, home: Path) -> Fault | None:
    if path.startswith(SCHEME):  # the others of packages have become absolute
        return Fault(loc, f"{path} is not there; {PackageFinder(scenario.absolute()).searched(path)}")
    refused = refusal(Path(path), home)
    return Fault(loc, f"{path} {refused}") if refused else None


URDF: Loc = ("robot", "urdf")


def _escaping_meshes(loc: Loc, urdf: Path, home: Path) -> Iterator[Fault]:
    # Imported late: most scenarios name no URDF.
    from pytest_lpb.problem.spatial.robot_files import escaping_meshes

    try:
        yield from (Fault(loc, text) for text in escaping_meshes(urdf, home))
    except ScenarioError:
        return  # it cannot be read, which is told with the robot's other faults
