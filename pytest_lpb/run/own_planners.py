"""What a run folder would have started must be the user's own: anybody may have written a run folder."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pytest_lpb.documents.recognition import SUFFIXES
from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import read_planner
from pytest_lpb.run.folder import RUN_FILE, RunFolder

FOLDER = "planners"  # below the current folder: the planner files of whoever asks
STARTED = ("python", "ssh", "command", "environment", "working_dir")  # keys that decide which code runs


def own_isolation(
    run: RunFolder, name: str, planner: str, recorded: Isolation | None, *, trusted: bool
) -> Isolation | None:
    """Where a planner of a run may be started.

    Args:
        run: the run folder.
        name: of the planner.
        planner: its class, as recorded.
        recorded: where the run had it.
        trusted: whether whatever is recorded may be started.

    Raises ConfigurationError when it names programs, interpreters or hosts that the user's planner file does not.
    """
    if recorded is None or trusted or not _started(recorded):
        return recorded
    own = _own(run, name)
    if own is None or own.isolation is None or own.planner != planner or _started(own.isolation) != _started(recorded):
        told = shlex.join(f"{key}={_shown(value)}" for key, value in _started(recorded).items())
        raise ConfigurationError(
            f"planner {name!r} would be started with {told}: the run folder, which may come from anybody, says so, and "
            f"no {FOLDER}/{name}.yaml in the current folder says the same; call it where yours is, or add --trust-run"
        )
    limits = {key: value for key, value in vars(recorded).items() if key not in STARTED}
    return replace(own.isolation, **limits)


def _own(run: RunFolder, name: str) -> PlannerConfiguration | None:
    """The user's configuration of that name; run folders have none."""
    here = Path.cwd()
    if (here / RUN_FILE).exists():
        return None
    files = (here / FOLDER / f"{name}{suffix}" for suffix in SUFFIXES)
    path = next((path for path in files if path.is_file() and not path.resolve().is_relative_to(run.path)), None)
    return None if path is None else read_planner(path, name)


def _started(isolation: Isolation) -> Mapping[str, Any]:
    """What decides which code runs, with its paths in one spelling."""
    values = isolation.to_dict()
    return {key: _spelled(values[key]) for key in STARTED if key in values}


def _spelled(value: Any) -> Any:
    if isinstance(value, list):
        return [_spelled(word) for word in value]
    return os.path.normpath(value) if isinstance(value, str) and value.startswith("/") else value


def _shown(value: Any) -> str:
    return shlex.join(value) if isinstance(value, list) else str(value)
