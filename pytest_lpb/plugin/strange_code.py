"""Code and settings of pytest in run folders: nothing of ours writes them, and pytest would run or obey them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

MODULES = ("conftest.py", "__init__.py")
SETTINGS = ("pytest.ini", ".pytest.ini", "pytest.toml", ".pytest.toml", "pyproject.toml", "tox.ini", "setup.cfg")
RUN_FILE = "run.json"


def refuse_strange_code(paths: Iterable[Path]) -> None:
    """Raise UsageError for paths in run folders where pytest would find code or settings on its way."""
    for path in paths:
        # Each run folder by itself: links are followed first, as pytest does.
        found = next(_strange(path.resolve()), None)
        if found is not None:
            raise pytest.UsageError(
                f"{path} lies in a run folder that holds {found}, which pytest would use; no run writes it: remove it"
            )


def _strange(path: Path) -> Iterator[Path]:
    """Files that pytest would use on the way from a run folder to a path in it."""
    passed: list[Path] = []
    for folder in (path, *path.parents):
        passed.append(folder)
        if (folder / RUN_FILE).is_file():
            found = [way / name for way in passed for name in (*MODULES, *SETTINGS) if (way / name).exists()]
            if found and _is_ours(folder / RUN_FILE):
                yield from found


def _is_ours(file: Path) -> bool:
    """Whether a file of that name is of a run of ours: others may use the name."""
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(content, dict) and {"planners", "scenarios"} <= content.keys()
