"""Which files a scenario may name: those of its own project. A file of a stranger is not to read, and record, others.

The project is the nearest folder above the scenario file with one of `MARKS`, else the folder above the file's own.
The environment variable LPB_ALLOW_PATHS names further folders, separated as in PATH.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pytest_lpb.documents.faults import Fault, Loc
from pytest_lpb.problem.paths import PLACES

ALLOWED = "LPB_ALLOW_PATHS"
MARKS = (
    "pytest.ini",
    ".pytest.ini",
    "pyproject.toml",
    "tox.ini",
    "setup.cfg",
    "conftest.py",
    ".git",
    "run.json",
    "package.xml",
)


def project_of(scenario: Path) -> Path:
    """The folder whose files a scenario file may name."""
    folder = scenario.resolve().parent
    marked = (above for above in (folder, *folder.parents) if any((above / mark).exists() for mark in MARKS))
    return next(marked, folder.parent)


def escapes(data: Any, scenario: Path) -> list[Fault]:
    """A fault for each file that lies outside of what a scenario file may name.

    Args:
        data: the file's content, paths absolute.
        scenario: the file.
    """
    named = list(_named(data))
    if not named:
        return []
    project = project_of(scenario)
    folders = [project, *(Path(text).resolve() for text in os.environ.get(ALLOWED, "").split(os.pathsep) if text)]
    return [
        Fault(loc, f"{path} lies outside of {project}; a scenario names files of its own project, or below {ALLOWED}")
        for loc, path in named
        if not any(Path(path).resolve().is_relative_to(folder) for folder in folders)
    ]


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
