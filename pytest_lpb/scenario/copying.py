"""Copies of scenario files, with the meshes, robots and certified paths they name, in the same folders."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from pytest_lpb.documents.atomic import write_once
from pytest_lpb.errors import LpbError
from pytest_lpb.problem.spatial.assets import asset_files
from pytest_lpb.scenario.shelf import Entry


def copy_scenarios(entries: Iterable[Entry], source: Path, target: Path, studies: Iterable[Path] = ()) -> list[Path]:
    """Copy scenarios, and studies of them, from one folder to another; the copied scenario files.

    Nothing is overwritten, and nothing is copied if a scenario is there already, or another file of the name of one
    that it needs. Raises LpbError with that file.
    """
    entries = list(entries)
    needed = {file.resolve() for entry in entries for named in entry.files for file in asset_files(named)}
    scenarios = [entry.path for entry in entries]
    copies = {path: target / path.relative_to(source) for path in scenarios}
    copies |= {path: target / path.relative_to(source) for path in studies}
    copies |= {path: target / path.relative_to(source.resolve()) for path in sorted(needed)}
    for path, copy in copies.items():
        if copy.exists() and (path in scenarios or copy.read_bytes() != path.read_bytes()):
            raise LpbError(f"{copy} is there already, and nothing was copied; remove it, or copy to another folder")
    for path, copy in copies.items():
        write_once(copy, path.read_bytes())
    return [copies[path] for path in scenarios]
