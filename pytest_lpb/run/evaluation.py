"""Evaluates raw data: one row per trial, with every KPI. Nothing is run, nothing is changed."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import pandas as pd

from pytest_lpb.errors import LpbError, RecordingError
from pytest_lpb.kpis.registry import Kpi, default_registry, evaluate_kpis
from pytest_lpb.names import listed, suggestion
from pytest_lpb.problem.problem import Problem
from pytest_lpb.run.contention import CONTENDED_KPIS, joined
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.missing import missing_trials
from pytest_lpb.run.plan import DAMAGED, TrialKey
from pytest_lpb.run.run_file import robot_warnings
from pytest_lpb.run.skipped import skipped_trials
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.files import read_trial, trial_path
from pytest_lpb.trial.units import unit_of

# Columns of trials.csv before the KPIs.
TRIAL_COLUMNS = (
    "node_id",
    "scenario",
    "planner",
    "seed",
    "outcome",
    "success",
    "failed_criteria",
    "steps",
    "problem_hash",
    "trajectory_hash",
    "wall_s",
    "attempt",
    "timing_contended",
)
# Those, and what reports need, that trial files hold as they are.
COMPUTED = ("steps", "timing_contended")
RECORDED = (*(name for name in TRIAL_COLUMNS if name not in COMPUTED), "message", "command")
# What tables and reports need besides; not part of trials.csv.
HIDDEN_COLUMNS = ("duration_s", "control", "message", "command", "known_failure", "file")


@dataclass(frozen=True)
class Selection:
    """Trials to evaluate; None: all."""

    planners: Collection[str] | None = None
    scenarios: Collection[str] | None = None
    node_id: str | None = None

    def holds(self, row: Mapping[Any, Any]) -> bool:
        """Whether a trial is selected."""
        return (
            (self.planners is None or row["planner"] in self.planners)
            and (self.scenarios is None or row["scenario"] in self.scenarios)
            and (self.node_id is None or row["node_id"] == self.node_id)
        )

    def check(self, trials: pd.DataFrame) -> None:
        """Check that what is asked for is in the run. Raises LpbError with what there is."""
        asked = (("planner", self.planners), ("scenario", self.scenarios), ("node_id", [self.node_id]))
        for column, names in asked:
            known = set(trials[column].tolist())
            for name in names or ():
                if name is not None and name not in known:
                    raise LpbError(
                        f"no {column.replace('_', ' ')} {name!r} in this run{suggestion(name, known)}; "
                        f"there are {listed(known) if len(known) <= 20 else f'{len(known)} of them'}"
                    )


class RunSource(Protocol):
    """What trials are from: a run folder, or several."""

    @property
    def name(self) -> str:
        """The run folder's name."""

    def info(self) -> Mapping[str, Any]:
        """What run.json says."""


@dataclass(frozen=True)
class Evaluation:
    """Trials of a run with their KPIs.

    Attributes:
        run: where they are from.
        trials: one row per trial: TRIAL_COLUMNS, HIDDEN_COLUMNS, a column per KPI, then CONTENDED_KPIS.
        kpis: what was evaluated.
        warnings: KPIs that raised, files that could not be read.
        missing: trials that the run was to have, and that are not among `trials`.
        selection: which of the run's trials these are.
        skipped: trials that their planners do not support, with the reason.
    """

    run: RunSource
    trials: pd.DataFrame
    kpis: Sequence[Kpi]
    warnings: list[str]
    missing: Sequence[TrialKey] = ()
    selection: Selection = Selection()
    skipped: Mapping[TrialKey, str] = field(default_factory=dict)

    def info(self) -> dict[str, Any]:
        """What run.json says; of the planners and scenarios that are selected only."""
        chosen = (("planners", self.selection.planners), ("scenarios", self.selection.scenarios))
        info = dict(self.run.info())
        for key, names in chosen:
            if names is not None:
                info[key] = {name: entry for name, entry in info.get(key, {}).items() if name in names}
        return info

    def trajectory_of(self, node_id: str) -> Trajectory:
        """Raw data of a trial."""
        row = self.trials.loc[self.trials["node_id"] == node_id].iloc[0]
        return read_trial(Path(row["file"]))

    def selected(self, selection: Selection) -> Evaluation:
        """The same for some of the trials. Raises LpbError for names that are not there."""
        selection.check(self.trials)
        kept = [selection.holds(row) for row in self.trials[["planner", "scenario", "node_id"]].to_dict("records")]
        missing = [trial for trial in self.missing if selection.holds({**trial._asdict(), "node_id": None})]
        skipped = {
            trial: why for trial, why in self.skipped.items() if selection.holds({**trial._asdict(), "node_id": None})
        }
        trials = self.trials[kept].reset_index(drop=True)
        return replace(self, trials=trials, missing=missing, skipped=skipped, selection=selection)

    def table(self) -> pd.DataFrame:
        """The content of trials.csv."""
        return self.trials[[*TRIAL_COLUMNS, *(kpi.name for kpi in self.kpis), CONTENDED_KPIS]]


def evaluate(run: RunFolder, kpi_names: Sequence[str] | None = None) -> Evaluation:
    """Evaluate all trials of a run.

    Args:
        run: the run folder.
        kpi_names: KPIs to evaluate; None: all that are registered. Raises KpiError for unknown ones.
    """
    kpis = list(default_registry) if kpi_names is None else default_registry.select(kpi_names)
    rows: list[dict[str, Any]] = []
    warnings = robot_warnings(run.info())
    for path in run.trial_files():
        try:
            rows.append({**_row(_read(run, path), kpis, warnings), "file": str(path)})
        except RecordingError as error:
            # One line each: what Arrow says has several.
            warnings.append(f"{' '.join(str(error).split())}; {DAMAGED}")
    columns = [*TRIAL_COLUMNS, *HIDDEN_COLUMNS, *(kpi.name for kpi in kpis), CONTENDED_KPIS]
    trials = pd.DataFrame(rows, columns=columns)
    trials = trials.sort_values(["scenario", "planner", "seed"], ignore_index=True, kind="stable")
    skipped = skipped_trials(run.path)
    missing = [trial for trial in missing_trials(run.info(), trials) if trial not in skipped]
    return Evaluation(run, trials, kpis, warnings, missing, skipped=skipped)


def _read(run: RunFolder, path: Path) -> Trajectory:
    """A trial's raw data. Raises RecordingError when they are damaged, or those of another trial."""
    try:
        trajectory = read_trial(path)
        metadata = trajectory.metadata
        missing = [key for key in RECORDED if key not in metadata]
        if missing:
            raise RecordingError(f"cannot read {path}: its metadata lack {', '.join(missing)}")
        expected = trial_path(run.path, metadata["scenario"], metadata["planner"], metadata["seed"])
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        # Damage may leave a file that can be read but makes no sense.
        raise RecordingError(f"cannot read {path}: its content is damaged: {type(error).__name__}: {error}") from error
    if path != expected:
        raise RecordingError(f"{path} holds the data of another trial, {metadata['node_id']}")
    return trajectory


def _row(trajectory: Trajectory, kpis: Sequence[Kpi], warnings: list[str]) -> dict[str, Any]:
    metadata = trajectory.metadata
    values, faults = evaluate_kpis(trajectory, kpis)
    warnings += faults
    return {
        **{key: metadata[key] for key in RECORDED},
        "failed_criteria": "; ".join(metadata["failed_criteria"]),
        "steps": max(len(trajectory) - 1, 0),
        "timing_contended": trajectory.timing_contended,
        "duration_s": trajectory.problem.duration,
        "control": control_mode(trajectory.problem),
        "known_failure": str(metadata.get("known_failure") or ""),  # why it was expected to fail
        **values,
        CONTENDED_KPIS: joined(kpi.name for kpi in kpis if kpi.is_contended(trajectory)),
    }


def control_mode(problem: Problem) -> str:
    """Control mode with the units of actions, such as `velocity [m/s, rad/s]`: what can be pooled has the same."""
    units = (unit_of(f"action{index}", problem) for index in range(problem.robot.n_actions))
    return f"{problem.control} [{', '.join(dict.fromkeys(units))}]"
