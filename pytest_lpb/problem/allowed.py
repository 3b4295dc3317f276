"""Which files a file of a stranger may name: those of its own project.

The project is the nearest folder above the file with one of `MARKS`, else the folder above the file's own.
The environment variable LPB_ALLOW_PATHS names further folders, separated as in PATH.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

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


def project_of(file: Path) -> Path:
    """The folder whose files a file may name."""
    folder = file.resolve().parent
    marked = (above for above in (folder, *folder.parents) if any((above / mark).exists() for mark in MARKS))
    return next(marked, folder.parent)


def allowed_by_user() -> str:
    """Folders that the user allows besides, as the environment variable has them."""
    return os.environ.get(ALLOWED, "")


def refusal(path: Path, home: Path, more: Sequence[Path] = ()) -> str | None:
    """Why a file may not be named, in words; None when it may.

    Args:
        path: the file, which need not be there; links are followed.
        home: the project, links followed.
        more: further folders that are allowed.
    """
    allowed = [home, *more, *(Path(text).resolve() for text in allowed_by_user().split(os.pathsep) if text)]
    try:
        resolved = path.resolve()
    except (OSError, RuntimeError):
        return "is a link that leads to itself"
    if any(resolved.is_relative_to(folder) for folder in allowed):
        return None
    return f"lies outside of {home}; allowed are files below it, or below folders that {ALLOWED} names"
