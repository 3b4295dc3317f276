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
    look_up_as_the_run_did(info, run.path)
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


def look_up_as_the_run_did(info: Mapping[str, Any], run: Path) -> None:
    """Have modules found where the run looked them up, then below the current folder; never in the run folder.

    Folders of the ini value `pythonpath` that lay below the run's start are looked up below the current one, too.
    """
    recorded = [Path(info[key]) for key in FOLDERS if info.get(key)]
    further = [Path(folder) for folder in info.get("pythonpath", ())]
    here = [moved for folder in further if (moved := _moved(folder, info)) is not None]
    for folder in (*recorded, *further, Path.cwd(), *here):
        outside = folder.is_absolute() and folder.is_dir() and not folder.resolve().is_relative_to(run)
        if outside and str(folder) not in sys.path:
            sys.path.append(str(folder))


def _moved(path: Path, info: Mapping[str, Any]) -> Path | None:
    """A path below a run's start as one below the current folder: the user's files may have been moved."""
    start = info.get("invocation")
    return Path.cwd() / path.relative_to(start) if start and path.is_relative_to(start) else None


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
    load_class(configuration, entry, run)
    try:
        configuration.check()
    except LpbError as error:
        file = (entry.get("source") or {}).get("file")
        ran_from = f"; the run had it from {file}" if file else ""
        raise ConfigurationError(f"planner {name!r} of this run cannot be loaded again: {error}{ran_from}") from error
    return configuration


def load_class(configuration: PlannerConfiguration, entry: Mapping[str, Any], run: RunFolder) -> None:
    """Import a planner's class, from the file that the run had it from where its name alone does not lead to it.

    Such a class is one that a conftest.py registers, or one in a module that only pytest's settings lead to. When it
    cannot be found, the next look for it says what is missing.
    """
    try:
        configuration.definition  # noqa: B018 - imports its class
    except ConfigurationError:
        source = entry.get("source")
        if source:
            moved = _moved(Path(source["file"]), run.info())
            gone = moved is not None and not Path(source["file"]).is_file()
            load_user_modules([{**source, "file": str(moved)} if gone else source], run.path)
