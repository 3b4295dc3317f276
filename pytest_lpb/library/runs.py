"""A finished run: its table of trials and its raw data."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_lpb.library.evaluate import registered_kpis
from pytest_lpb.run.evaluation import Evaluation, evaluate
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.lookup import find_trial
from pytest_lpb.run.plugins import load_user_modules
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.files import read_trial

if TYPE_CHECKING:
    import pandas as pd


class Run:
    """A run folder, read when asked. Nothing is run, and nothing is written.

    Attributes:
        path: the run folder.
        info: what run.json says: command, seeds, planners, scenarios, versions, machine.
    """

    def __init__(self, folder: RunFolder, kpis: Sequence[str] | None) -> None:
        self._folder = folder
        self._kpis = kpis
        self._loaded = False
        self.path = folder.path
        self.info: dict[str, Any] = folder.info()

    def __repr__(self) -> str:
        return f"<Run {self.path}>"

    @cached_property
    def _evaluation(self) -> Evaluation:
        registry = registered_kpis()
        self._load_modules()
        names = self.info.get("kpis") if self._kpis is None else self._kpis
        registry.select(names)
        evaluation = evaluate(self._folder, names)
        for problem in evaluation.warnings:
            warnings.warn(problem, stacklevel=4)
        return evaluation

    def _load_modules(self) -> None:
        """Load what defines KPIs, robots, shapes and the like, once."""
        if not self._loaded:
            for problem in load_user_modules(self.info.get("plugins", []), self.path):
                warnings.warn(problem, stacklevel=4)
            self._loaded = True

    @property
    def trials(self) -> pd.DataFrame:
        """One row per trial, evaluated from the raw data: the columns of trials.csv.

        `node_id`, `scenario`, `planner`, `seed`, `outcome`, `success`, ..., then one column per KPI, whose name ends
        with its unit. Files that cannot be read, and KPIs that raise, are named in warnings.
        """
        return self._evaluation.table()

    def trajectory(self, node_id: str) -> Trajectory:
        """Raw data of one trial, by its node id as in `trials`. Raises LpbError for one that is not in the run."""
        self._load_modules()
        return read_trial(find_trial(self._folder, node_id))

    def trajectories(self) -> Iterator[Trajectory]:
        """Raw data of all trials, one after the other, in the order of their files."""
        self._load_modules()
        return (read_trial(path) for path in self._folder.trial_files())


def load_run(path: str | Path, kpis: Sequence[str] | None = None) -> Run:
    """A run by its folder, such as `reports/latest`.

    Args:
        path: the run folder.
        kpis: KPIs that `trials` has; None: those of the run, by default all. Modules of KPIs that the run recorded are
            loaded again, as `lpb-report` does; no code that lies in the run folder is.

    Raises RecordingError when there is no run folder, or its run.json cannot be read.
    """
    return Run(RunFolder.open(Path(path)), kpis)
