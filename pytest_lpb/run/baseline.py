"""What a run is compared with: a baseline file, another run, or another planner of the same run."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.run.baseline_file import KEYS, baseline_frame, read_baseline
from pytest_lpb.run.folder import LATEST, RunFolder

if TYPE_CHECKING:
    import pandas as pd

PLANNER = "planner:"


class Baseline(Protocol):
    """Where old values come from."""

    @property
    def name(self) -> str:
        """As the user named it."""

    @property
    def kpis(self) -> Collection[str] | None:
        """KPIs that it has values of; None: any."""

    @property
    def machine(self) -> Mapping[str, Any] | None:
        """The machine it was measured on; None: the run's own."""

    @property
    def warnings(self) -> Sequence[str]:
        """What went wrong when it was evaluated."""

    def counterparts(self, planners: Sequence[str]) -> dict[str, str]:
        """For each planner of a run that is compared, the planner of the baseline that it is compared with.

        Raises ConfigurationError when there is none.
        """

    def trials(self, planner: str, own: pd.DataFrame, kpis: Sequence[str]) -> pd.DataFrame:
        """Trials of a planner of the baseline, with these KPIs; `own`: the trials of the run that is judged."""


class FileBaseline:
    """A file that `lpb-report --save-baseline` wrote. Raises RecordingError when it is none."""

    machine: Mapping[str, Any]
    warnings = ()

    def __init__(self, path: Path, name: str) -> None:
        self.name = name
        self._content = read_baseline(path)
        self.machine = self._content.get("machine") or {}

    @property
    def kpis(self) -> Collection[str]:
        """Columns of the file."""
        return [name for name in self._content["columns"] if name not in KEYS]

    def counterparts(self, planners: Sequence[str]) -> dict[str, str]:
        """Planners of the same name."""
        return _same_names(planners, self._content["planners"], self.name)

    def trials(self, planner: str, own: pd.DataFrame, kpis: Sequence[str]) -> pd.DataFrame:  # noqa: ARG002
        """Trials of the file."""
        return baseline_frame(self._content, planner)


class RunBaseline:
    """An earlier run, evaluated when it is needed."""

    kpis = None

    def __init__(self, run: RunFolder, name: str) -> None:
        self.name = name
        self.warnings: list[str] = []
        self._run = run
        self._evaluated: dict[tuple[str, ...], pd.DataFrame] = {}

    @cached_property
    def machine(self) -> Mapping[str, Any]:
        """As its run.json says."""
        return self._run.info().get("machine") or {}

    def counterparts(self, planners: Sequence[str]) -> dict[str, str]:
        """Planners of the same name."""
        return _same_names(planners, self._run.info().get("planners", {}), self.name)

    def trials(self, planner: str, own: pd.DataFrame, kpis: Sequence[str]) -> pd.DataFrame:  # noqa: ARG002
        """Trials of the run."""
        from pytest_lpb.run.evaluation import evaluate

        key = tuple(kpis)
        if key not in self._evaluated:
            evaluation = evaluate(self._run, kpis)
            self._evaluated[key] = evaluation.trials
            self.warnings += evaluation.warnings
        rows = self._evaluated[key]
        return rows[rows["planner"] == planner]


class PlannerBaseline:
    """Another planner of the run that is judged: same machine, same minute."""

    kpis = None
    machine = None
    warnings = ()

    def __init__(self, planner: str) -> None:
        self.name = f"{PLANNER}{planner}"
        self._planner = planner

    def counterparts(self, planners: Sequence[str]) -> dict[str, str]:
        """The one planner, for all others."""
        if self._planner not in planners:
            raise ConfigurationError(
                f"no planner {self._planner!r} in this run{suggestion(self._planner, planners)}; there are "
                f"{listed(planners)}"
            )
        others = [name for name in planners if name != self._planner]
        if not others:
            raise ConfigurationError(f"{self._planner} is the only planner of this run; nothing is compared with it")
        return dict.fromkeys(others, self._planner)

    def trials(self, planner: str, own: pd.DataFrame, kpis: Sequence[str]) -> pd.DataFrame:  # noqa: ARG002
        """Its trials in the run itself."""
        return own[own["planner"] == planner]


def _same_names(planners: Sequence[str], known: Collection[str], name: str) -> dict[str, str]:
    matched = {planner: planner for planner in planners if planner in known}
    if not matched:
        raise ConfigurationError(
            f"{name} has no planner of this run: it has {listed(known)}, the run {listed(planners)}; planners are "
            "compared under one name (NAME=PATH.yaml gives a planner file another name)"
        )
    return matched


def open_baseline(reference: str, folder: Path) -> Baseline:
    """A baseline by its name: `planner:NAME`, a run folder, or a baseline file.

    Args:
        reference: as the user wrote it.
        folder: what paths are relative to.

    Raises:
        ConfigurationError: there is no such thing.
        RecordingError: it cannot be read.
    """
    if reference.startswith(PLANNER):
        return PlannerBaseline(reference.removeprefix(PLANNER))
    path = folder / reference
    if path.is_dir() or path.name == LATEST:
        return RunBaseline(RunFolder.open(path), reference)
    if not path.is_file():
        raise ConfigurationError(
            f"found {reference!r}, and there is no {path}; allowed are a baseline file (written by lpb-report RUN "
            f"--save-baseline FILE), a run folder, or {PLANNER}NAME"
        )
    return FileBaseline(path, reference)
