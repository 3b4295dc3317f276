"""Which run each trial of a report is from: commands on its page name the folder of that run, wherever it lies."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from pytest_lpb.report.data import ReportData
from pytest_lpb.trial.files import trial_path

OWN = "."


def origins(data: ReportData, trials: Sequence[dict[Any, Any]]) -> tuple[list[list[str]], list[list[Any]]]:
    """Runs, and of each trial the place of its run, with the node id it has there where that is another.

    Returns:
        runs: name of the folder, and its address relative to the report's, so that both can be moved together.
        trials: place of the run, and node id or None, in the order of `trials`.
    """
    runs: dict[Path | None, None] = {}
    found = []
    for trial in trials:
        file = trial.get("file")
        node_id = str(trial["node_id"])
        run, own = (None, node_id) if file is None else _origin(Path(str(file)), trial, node_id)
        runs.setdefault(run)
        found.append([list(runs).index(run), None if own == node_id else own])
    return [[data.title, OWN] if run is None else [run.name, _address(run, data.folder)] for run in runs], found


def _origin(file: Path, trial: dict[Any, Any], node_id: str) -> tuple[Path, str]:
    """The run folder of a trial file, and the trial's node id there: merged runs may have renamed planners."""
    planner = file.parent.name
    depth = len(trial_path(Path(), str(trial["scenario"]), planner, int(trial["seed"])).parts)
    above, _, seed = node_id.rpartition("::")
    return file.parents[depth - 1], f"{above.rpartition('::')[0]}::{planner}::{seed}"


def _address(run: Path, folder: Path | None) -> str:
    """Address of a run folder from the report's; the whole one where they share no drive."""
    try:
        relative = os.path.relpath(run, run if folder is None else folder)
    except ValueError:
        return run.absolute().as_uri()
    return quote(os.fsencode(Path(relative).as_posix()))
