"""Removes old run folders and nothing else: the newest stay, that which `latest` leads to, and any that is running."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pytest_lpb.documents.atomic import recording_error, unfinished
from pytest_lpb.errors import RecordingError
from pytest_lpb.run.folder import LATEST, RUN_FILE, RunFolder
from pytest_lpb.run.lock import RunLock

OURS = ("planners", "scenarios", "trials")  # what each of our run folders has: keys of run.json, and a folder


@dataclass(frozen=True)
class Pruned:
    """A run folder that was to be removed.

    Attributes:
        path: the run folder.
        kept: why it was not removed after all; empty when it was.
    """

    path: Path
    kept: str = ""


def prune(reports: Path, keep: int, *, dry_run: bool = False) -> Iterator[Pruned]:
    """Remove all run folders in a folder but the newest.

    Args:
        reports: the parent of run folders.
        keep: how many to keep.
        dry_run: whether nothing is removed.

    Raises RecordingError when it is no folder, or a run cannot be removed.
    """
    if not reports.is_dir():
        raise RecordingError(f"there is no folder {reports}: name the one that run folders lie in")
    latest = _latest(reports)
    for run in _newest_first(reports)[keep:]:
        yield Pruned(run, "latest leads to it" if run == latest else _removed(run, dry_run))


def _newest_first(reports: Path) -> list[Path]:
    """Run folders that a run of ours has written, links left out."""
    runs = []
    for path in reports.iterdir():
        if path.name.startswith(".") or path.is_symlink() or not (path / RUN_FILE).is_file():
            continue
        try:
            info = RunFolder.open(path).info()
        except RecordingError:
            continue  # whose it is nobody can tell
        if all(key in info or (path / key).is_dir() for key in OURS):
            runs.append((str(info.get("started") or ""), path.name, path.resolve()))
    return [path for _, _, path in sorted(runs, reverse=True)]


def _latest(reports: Path) -> Path | None:
    try:
        return RunFolder.open(reports / LATEST).path
    except RecordingError:
        return None


def _removed(run: Path, dry_run: bool) -> str:
    """Remove a run folder; why that was not done."""
    lock = RunLock()
    try:
        lock.take(run)
    except RecordingError:
        return "it is running"
    try:
        if not lock.held:
            return "whether it is running cannot be told: this file system has no locks"
        if not dry_run:
            # Out of sight first: half of a run is none.
            hidden = unfinished(run)
            run.rename(hidden)
            shutil.rmtree(hidden)
    except OSError as error:
        raise recording_error(f"cannot remove {run}", error) from error
    finally:
        lock.release()
    return ""
