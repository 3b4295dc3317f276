"""The planners of a run, loaded again from what run.json says of them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from getopt import GetoptError
from pathlib import Path
from typing import Any

from pytest_lpb.errors import ConfigurationError, LpbError
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import recorded_isolation
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.own_planners import own_isolation
from pytest_lpb.run.plugins import load_user_modules

FOLDERS = ("invocation", "rootdir")  # of run.json, where the run looked modules up


def recorded_planners(
    run: RunFolder, names: Iterable[str], *, trusted: bool
) -> tuple[dict[str, PlannerConfiguration], list[str]]:
    """Configurations of planners by name, with their classes loaded; warnings where their code has changed.

    Modules are looked up where the run did, then in the current folder; never in the run folder, which may come from
    anybody. Programs, interpreters and hosts must be the user's own, unless the run is trusted. Raises
    ConfigurationError with what is missing.
    """
    info = run.info()
    _extend_path(info, run.path)
    load_user_modules(info.get("plugins", []), run.path)
    planners: dict[str, PlannerConfiguration] = {}
    warnings = []
    for name in names:
        entry = info["planners"].get(name)
        if entry is None:
            raise ConfigurationError(f"run.json says nothing of planner {name!r}, so it cannot be loaded again")
        planners[name] = configuration = _loaded(name, entry, run, trusted)
        if entry["source_hash"] and configuration.source_hash != entry["source_hash"]:
            warnings.append(f"planner {name!r} has changed since the run: its source is another")
    return planners, warnings


def _extend_path(info: Mapping[str, Any], run: Path) -> None:
    recorded = [Path(info[key]) for key in FOLDERS if info.get(key)]
    for folder in (*recorded, Path.cwd()):
        outside = folder.is_absolute() and folder.is_dir() and not folder.resolve().is_relative_to(run)
        if outside and str(folder) not in sys.path:
            sys.path.append(str(folder))


def _loaded(name: str, entry: Mapping[str, Any], run: RunFolder, trusted: bool) -> PlannerConfiguration:
    try:
        recorded = recorded_isolation(entry.get("isolation", {}), run.path)
    except (ConfigurationError, LookupError, ValueError, GetoptError) as error:
        raise ConfigurationError(f"run.json: planner {name!r}: isolation: {error}") from None
    configuration = PlannerConfiguration(
        name=name,
        planner=entry["planner"],
        parameters=entry["parameters"],
        per_robot=entry["per_robot"],
        period=entry["period"],
        delay=entry["delay"],
        isolation=own_isolation(run, name, entry["planner"], recorded, trusted=trusted),
    )
    try:
        configuration.definition  # noqa: B018 - imports its class
    except ConfigurationError:
        # A class that a conftest.py registers, or one in a module that only pytest's settings lead to.
        _load_source(entry, run)
    try:
        configuration.check()
    except LpbError as error:
        file = (entry.get("source") or {}).get("file")
        ran_from = f"; the run had it from {file}" if file else ""
        raise ConfigurationError(f"planner {name!r} of this run cannot be loaded again: {error}{ran_from}") from error
    return configuration


def _load_source(entry: Mapping[str, Any], run: RunFolder) -> None:
    """Load the module that a run recorded, if there is one; a second look for the class tells what is missing."""
    source = entry.get("source")
    if source:
        load_user_modules([source], run.path)
