"""Writes trials of `run_trial` into a run folder, which `load_run` and `lpb-report` read like any other."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from pytest_lpb.documents.atomic import write_once
from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.errors import RecordingError
from pytest_lpb.run.folder import RUN_FILE, RunFolder
from pytest_lpb.run.plugins import user_modules
from pytest_lpb.run.provenance import run_information
from pytest_lpb.study.family import FileFamily
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.assets import recorded_beside
from pytest_lpb.trial.files import read_metadata, trial_path, write_trial
from pytest_lpb.trial.specification import TrialSpecification


class Recorder:
    """A run folder that is ready for a trial.

    Args:
        folder: the run folder, made if it is not there.
        specification: the trial.
        problem_hash: of its problem.
        source: its scenario file; None for a concrete problem.

    Raises RecordingError, before anything is run, when the trial cannot be written there.
    """

    def __init__(self, folder: Path, specification: TrialSpecification, problem_hash: str, source: Path | None) -> None:
        self._specification = specification
        planner, key = specification.planner, specification.scenario
        families = {} if source is None else {key: FileFamily(key, source)}
        if not (folder / RUN_FILE).is_file():
            _check_new(folder)
            options: dict[str, Any] = {"workers": 1, "plugins": user_modules(), "invocation": str(Path.cwd())}
            information = run_information(sys.argv, [planner], families, options, Path.cwd())
            self._run = RunFolder.create(folder.absolute(), information, [planner], latest=False)
        else:
            self._run = RunFolder.open(folder)
            self._check_planner(problem_hash)
            self._run.add(planner, {name: family.description() for name, family in families.items()})

    @property
    def _path(self) -> Path:
        trial = self._specification
        return trial_path(self._run.path, trial.scenario, trial.planner.name, trial.seed)

    def _check_planner(self, problem_hash: str) -> None:
        """Trials under one name are of one planner; one that is there already is of the same problem."""
        planner = self._specification.planner
        recorded = self._run.info().get("planners", {}).get(planner.name, {})
        if recorded and recorded.get("parameters_hash") != planner.parameters_hash:
            raise RecordingError(
                f"{self._run.path} holds trials of {planner.name!r} with other parameters; "
                "give the planner another name (NAME=PATH), or choose another folder"
            )
        if self._path.is_file() and read_metadata(self._path).get("problem_hash") != problem_hash:
            raise RecordingError(f"{self._path} holds another problem of this seed; choose another folder")

    def write(self, trajectory: Trajectory) -> None:
        """Write the trial; the same trial that is there already stays. Raises RecordingError."""
        problem = recorded_beside(self._specification.problem, self._run.path, self._path.parent)
        content = dump_yaml({**problem, "source": self._specification.node_id}).encode()
        write_once(self._path.with_suffix(".yaml"), content)
        write_trial(self._run.path, trajectory)


def _check_new(folder: Path) -> None:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise RecordingError(f"{folder} is there and is no run folder: it has no {RUN_FILE}; choose another")
