"""Several runs as one, so that their planners are compared."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd

from pytest_lpb.names import count
from pytest_lpb.run.contention import CONTENDED_KPIS, joined
from pytest_lpb.run.evaluation import Evaluation, RunSource
from pytest_lpb.run.plan import TrialKey
from pytest_lpb.run.title import joint_title

KEY = ["scenario", "planner", "seed"]
Version = tuple[str, str]  # hashes of a planner's parameters and source
ENDING = re.compile(r"-([0-9a-f]{6})$")  # of a run folder's name


class MergedRun:
    """What several runs are together: as one run folder, without a place of its own."""

    def __init__(self, name: str, info: Mapping[str, Any]) -> None:
        self.name = name
        self._info = info

    def info(self) -> Mapping[str, Any]:
        """As run.json, with `merged`: the runs, and `notes`: what there is to know of that."""
        return self._info


def merge(evaluations: Sequence[Evaluation]) -> Evaluation:
    """Several evaluated runs as one.

    Planners of one name with different parameters or code get the ending of the first run's name that has them, such
    as `mpc.74be96`. A trial that several runs have counts once, as in the first. Timing of different machines counts
    as contended.

    Args:
        evaluations: of the same KPIs.
    """
    names = _new_names(evaluations)
    warnings = [warning for evaluation in evaluations for warning in evaluation.warnings]
    frames = [_renamed(evaluation.trials, names[index]) for index, evaluation in enumerate(evaluations)]
    trials = pd.concat(frames, ignore_index=True)
    repeated = trials.duplicated(KEY)
    warnings += _differences(trials)
    notes = [f"{_trials_are(repeated)} in several of the runs; each counts once"] if repeated.any() else []
    machines = [evaluation.run.info()["machine"] for evaluation in evaluations]
    if any(machine != machines[0] for machine in machines):
        trials["timing_contended"] = True
        trials[CONTENDED_KPIS] = joined(kpi.name for kpi in evaluations[0].kpis if kpi.timing)
        notes.append("the runs were made on different machines: their times do not compare")
    trials = trials[~repeated].sort_values(KEY, ignore_index=True, kind="stable")
    missing = _missing(evaluations, names, trials)
    skipped = _skipped(evaluations, names, trials)
    missing = [trial for trial in missing if trial not in skipped]
    merged = _merged_run(evaluations, names, notes)
    return Evaluation(merged, trials, evaluations[0].kpis, warnings, missing, skipped=skipped)


def _missing(
    evaluations: Sequence[Evaluation], names: Sequence[Mapping[str, str]], trials: pd.DataFrame
) -> list[TrialKey]:
    """What one run lacks, and no other has."""
    lacking = {
        trial._replace(planner=new.get(trial.planner, trial.planner))
        for evaluation, new in zip(evaluations, names, strict=True)
        for trial in evaluation.missing
    }
    return sorted(lacking - set(trials[KEY].itertuples(index=False, name=None)))


def _skipped(
    evaluations: Sequence[Evaluation], names: Sequence[Mapping[str, str]], trials: pd.DataFrame
) -> dict[TrialKey, str]:
    """What planners do not support, and no run has."""
    skipped = {
        trial._replace(planner=new.get(trial.planner, trial.planner)): reason
        for evaluation, new in zip(evaluations, names, strict=True)
        for trial, reason in evaluation.skipped.items()
    }
    present = set(trials[KEY].itertuples(index=False, name=None))
    return {trial: reason for trial, reason in sorted(skipped.items()) if trial not in present}


def _differences(trials: pd.DataFrame) -> Iterator[str]:
    """What to warn of where runs have a trial of one planner, scenario and seed, but not the same one."""
    found = trials.groupby(KEY)[["problem_hash", "trajectory_hash"]].nunique().gt(1)
    changed = found["problem_hash"]
    kinds = (
        (changed, "of another problem there: the scenarios have changed"),
        (found["trajectory_hash"] & ~changed, "different there: something is not deterministic"),
    )
    for trials_found, what in kinds:
        if trials_found.any():
            yield f"{_trials_are(trials_found)} in several of the runs and {what}; each counts once, as in the first"


def _merged_run(
    evaluations: Sequence[Evaluation], names: Sequence[Mapping[str, str]], notes: Sequence[str]
) -> RunSource:
    infos = [evaluation.run.info() for evaluation in evaluations]
    runs = [evaluation.run.name for evaluation in evaluations]
    planners = {
        renamed[name]: planner
        for info, renamed in zip(infos, names, strict=True)
        for name, planner in info["planners"].items()
    }
    scenarios = {key: scenario for info in infos for key, scenario in info["scenarios"].items()}
    info = {**infos[0], "planners": planners, "scenarios": scenarios, "merged": runs, "notes": notes}
    info["title"] = joint_title(infos)
    return MergedRun(" + ".join(runs), info)


def _new_names(evaluations: Sequence[Evaluation]) -> list[dict[str, str]]:
    """By run, planner names -> names in the merged run."""
    ends = endings([evaluation.run for evaluation in evaluations])
    first: dict[str, dict[Version, str]] = defaultdict(dict)  # ending of the first run with a version, by planner
    for evaluation, end in zip(evaluations, ends, strict=True):
        for name, version in _versions(evaluation.run):
            first[name].setdefault(version, end)
    return [
        {
            name: name if len(first[name]) == 1 else f"{name}.{first[name][version]}"
            for name, version in _versions(evaluation.run)
        }
        for evaluation in evaluations
    ]


def _versions(run: RunSource) -> Iterator[tuple[str, Version]]:
    for name, planner in run.info()["planners"].items():
        yield name, (planner["parameters_hash"], planner["source_hash"])


def endings(runs: Sequence[RunSource]) -> list[str]:
    """The endings of the runs' names; those that several share are numbered, from the second on."""
    found = [ending(run) for run in runs]
    return [
        end if end not in found[:place] else f"{end}-{found[:place].count(end) + 1}" for place, end in enumerate(found)
    ]


def ending(run: RunSource) -> str:
    """The ending of a run folder's name, such as `74be96`; of a folder that was renamed, its whole name."""
    match = ENDING.search(run.name)
    return match[1] if match else re.sub(r"[^A-Za-z0-9_.-]", "-", run.name)


def _renamed(trials: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    renamed = trials.copy()
    new = [names.get(planner, planner) for planner in trials["planner"]]
    parts = [str(node_id).rpartition("::") for node_id in trials["node_id"]]
    renamed["node_id"] = [
        f"{above.rpartition('::')[0]}::{planner}::{seed}" for (above, _, seed), planner in zip(parts, new, strict=True)
    ]
    renamed["planner"] = new
    return renamed


def _trials_are(found: pd.Series[bool]) -> str:
    number = int(found.sum())
    return f"{count(number, 'trial')} {'is' if number == 1 else 'are'}"
