"""Where things lie: what is relative to the invocation directory, the ini file, the rootdir."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from pytest_lpb.plugin.options import is_worker
from pytest_lpb.plugin.session import WORKER_ROOT, WORKER_RUN
from pytest_lpb.run.folder import RunFolder, check_writable, new_run_folder


def ini_folder(config: pytest.Config) -> Path:
    """What paths in the ini file are relative to."""
    folder: Path = config.inipath.parent if config.inipath else config.rootpath
    return folder


def planner_folders(config: pytest.Config) -> list[Path]:
    """Where planner files are looked up by name, the first first."""
    given = config.getini("lpb_planners_dir")
    if given:
        return [ini_folder(config) / given]
    return list(dict.fromkeys([config.invocation_params.dir / "planners", config.rootpath / "planners"]))


def reports_folder(config: pytest.Config) -> Path:
    """The parent of run folders."""
    option, ini = config.getoption("lpb_reports"), config.getini("lpb_reports")
    folder, given = (ini_folder(config), ini) if ini and not option else (config.invocation_params.dir, option)
    # The same folder must have the same path wherever it is met: `..` is taken out.
    return Path(os.path.normpath(folder / (given or "reports")))


def run_path(config: pytest.Config, reports: Path, resumed: RunFolder | None) -> Path:
    """The run folder: a new one, the one to finish, or in workers what the controller said."""
    if is_worker(config):
        return Path(config.workerinput[WORKER_RUN])  # type: ignore[attr-defined] # xdist adds it
    if resumed is not None:
        return resumed.path
    if not config.option.collectonly:
        check_writable(reports)
    return new_run_folder(reports)


def rootdir_of(config: pytest.Config) -> Path:
    """The controller's rootdir: workers, which see the arguments only, may find another."""
    root: Path | str = config.workerinput[WORKER_ROOT] if is_worker(config) else config.rootpath  # type: ignore[attr-defined] # xdist adds it
    return Path(root)


def extend_search_path(config: pytest.Config) -> None:
    """Look modules up in the invocation directory and the rootdir: scenarios elsewhere move that, not the planners."""
    for folder in (config.invocation_params.dir, config.rootpath):
        if str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
