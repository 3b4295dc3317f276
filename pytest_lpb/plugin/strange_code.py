"""Code and settings of pytest in run folders: nothing of ours writes them, and pytest would run or obey them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from pytest_lpb.bounded import read_bounded
from pytest_lpb.errors import LpbError

MODULES = ("conftest.py", "__init__.py")
SETTINGS = ("pytest.ini", ".pytest.ini", "pytest.toml", ".pytest.toml", "pyproject.toml", "tox.ini", "setup.cfg")
RUN_FILE = "run.json"
MAX_BYTES = 100_000_000  # of run.json
OURS = ("planners", "scenarios")  # keys of a run.json; a run may lack one


def refuse_strange_code(paths: Iterable[Path], run: Path | None = None) -> None:
    """Raise UsageError for paths in run folders where pytest would find code or settings on its way.

    Args:
        paths: files and folders.
        run: a folder that is taken for a run whatever its run.json says, or `latest`.
    """
    certain = None if run is None else _led_to(run).resolve()
    for path in [*paths, *([] if certain is None else [certain])]:
        # Each run folder by itself: links are followed first, as pytest does.
        found = next(_strange(path.resolve(), certain), None)
        if found is not None:
            raise pytest.UsageError(
                f"{path} lies in a run folder that holds {found}, which pytest would use; no run writes it: remove it"
            )


def _led_to(run: Path) -> Path:
    """The run folder that a file `latest` leads to, where links are refused; else the same."""
    if not run.is_file():
        return run
    from pytest_lpb.run.folder import RunFolder  # late: it takes a while, and few runs need it

    try:
        return RunFolder.open(run).path
    except LpbError:
        return run  # told when the run is read


def _strange(path: Path, certain: Path | None) -> Iterator[Path]:
    """Files that pytest would use on the way from a run folder to a path in it."""
    passed: list[Path] = []
    for folder in (path, *path.parents):
        passed.append(folder)
        if (folder / RUN_FILE).is_file():
            found = [way / name for way in passed for name in (*MODULES, *SETTINGS) if (way / name).exists()]
            if found and (folder == certain or _is_ours(folder / RUN_FILE)):
                yield from found


def _is_ours(file: Path) -> bool:
    """Whether a file of that name is of a run of ours: others may use the name."""
    try:
        # In any encoding, as where runs are read.
        content = json.loads(read_bounded(file, MAX_BYTES))
    except (LpbError, ValueError, RecursionError):
        return False
    return isinstance(content, dict) and not content.keys().isdisjoint(OURS)
