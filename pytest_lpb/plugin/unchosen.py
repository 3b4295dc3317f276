"""Says how to run what is named: scenario files without planners, folders with nothing but studies."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import pytest

from pytest_lpb.documents.recognition import SUFFIXES, is_study

_KEYS = (re.compile(r"^robot\s*:", re.MULTILINE), re.compile(r"^goal\s*:", re.MULTILINE))
_MAX_CHARACTERS = 1 << 20
_MAX_FILES = 10_000  # that are looked at below a folder
_MAX_NAMED = 3


def explain_unchosen_planners(config: pytest.Config) -> None:
    """Raise UsageError for the first argument that is a scenario file; other YAML files are other plugins' business."""
    for argument in config.args:
        path = Path(config.invocation_params.dir, argument.partition("::")[0])
        if path.suffix in (".yaml", ".yml") and path.is_file():
            text = path.read_bytes()[:_MAX_CHARACTERS].decode(errors="replace")
            if all(key.search(text) for key in _KEYS):
                raise pytest.UsageError(
                    f"{argument} is a scenario of pytest-lpb; choose planners to run it with: "
                    f"pytest --lpb-planners=pd,potential_field {argument}"
                )


def told_studies(config: pytest.Config) -> str:
    """Which studies lie in the folders that were named, and how to run one; empty without any."""
    here = config.invocation_params.dir
    folders = [path for argument in config.args if (path := here / argument.partition("::")[0]).is_dir()]
    studies = [path for folder in folders for path in islice(_yaml_files(folder), _MAX_FILES) if is_study(path)]
    if not studies:
        return ""
    names = [Path(os.path.relpath(path, here)).as_posix() for path in dict.fromkeys(studies)]
    more = f" and {len(names) - _MAX_NAMED} more" if names[_MAX_NAMED:] else ""
    found = "a study" if len(names) == 1 else f"{len(names)} studies"
    return (
        f"lpb: no scenario to run, but {found}: {', '.join(names[:_MAX_NAMED])}{more}; "
        f"a study is run by its name: pytest {names[0]}"
    )


def _yaml_files(folder: Path) -> Iterator[Path]:
    """YAML files below a folder, hidden folders and run folders left out."""
    for top, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if "run.json" in files:
            folders.clear()
            continue
        yield from (Path(top, name) for name in sorted(files) if name.endswith(SUFFIXES))
