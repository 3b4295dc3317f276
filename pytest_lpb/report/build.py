"""Writes what a run is read by: trials.csv, summary.csv, comparisons.csv, aggregates.csv and report.html."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd

from pytest_lpb.errors import RecordingError
from pytest_lpb.fairness.result import read_fairness
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.report import write_report
from pytest_lpb.retime.result import RETIMED_FILE, Retimed, read_retimed
from pytest_lpb.run.evaluation import Evaluation
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.gate import GateResult
from pytest_lpb.run.missing import MISSING_FILE, missing_table, resume_command
from pytest_lpb.run.skipped import SKIPPED_FILE, skipped_table
from pytest_lpb.run.tables import aggregates_table, comparisons_table, summary_table, write_csv

REPORT_FILE = "report.html"


def report_data(evaluation: Evaluation, pair: tuple[str, str] | None = None, folder: Path | None = None) -> ReportData:
    """Tables and raw data of an evaluated run.

    Args:
        evaluation: the trials.
        pair: the two planners to compare; None: every pair.
        folder: where the report will lie; None: the run folder. Calls timed again are looked up there first.
    """
    trials = evaluation.trials
    compared = trials if pair is None else trials[trials["planner"].isin(pair)]
    retimed, faults = _retimed(evaluation, folder)
    unfair, notes = _fairness(evaluation)
    info = evaluation.info()
    comparisons: pd.DataFrame = comparisons_table(compared, evaluation.kpis)
    return ReportData(
        trials=trials,
        summary=summary_table(trials, evaluation.kpis),
        comparisons=comparisons,
        kpis=evaluation.kpis,
        run_info={**info, "notes": [*info.get("notes", ()), *notes]},
        trajectory_of=evaluation.trajectory_of,
        warnings=[*evaluation.warnings, *faults, *unfair],
        aggregates=aggregates_table(trials, evaluation.kpis),
        retimed=retimed,
        title=evaluation.run.name,
        folder=folder,
        missing=evaluation.missing,
        skipped=evaluation.skipped,
        resume=_resume(evaluation),
    )


def _resume(evaluation: Evaluation) -> str:
    """The command that runs what is missing; empty for several runs in one."""
    run = evaluation.run
    return resume_command(run.path, run.info()) if isinstance(run, RunFolder) else ""


def _retimed(evaluation: Evaluation, folder: Path | None) -> tuple[Retimed | None, list[str]]:
    """Calls of these trials timed again, if they were; a warning where the file cannot be read."""
    keys = set(zip(evaluation.trials["scenario"], evaluation.trials["planner"], strict=True))
    own = [evaluation.run.path] if isinstance(evaluation.run, RunFolder) else []
    for place in [*([] if folder is None else [folder]), *own]:
        try:
            retimed = read_retimed(place / RETIMED_FILE)
        except RecordingError as error:
            return None, [str(error)]
        if retimed is not None:
            return retimed.selected(keys), []
    return None, []


def _fairness(evaluation: Evaluation) -> tuple[list[str], list[str]]:
    """Faults and notes of the check of isolation, if the run had one."""
    if not isinstance(evaluation.run, RunFolder):
        return [], []
    try:
        fairness = read_fairness(evaluation.run.path)
    except RecordingError as error:
        return [str(error)], []
    return ([], []) if fairness is None else (list(fairness.faults()), list(fairness.notes()))


def write_results(
    evaluation: Evaluation, folder: Path, pair: tuple[str, str] | None = None, gate: GateResult | None = None
) -> ReportData:
    """Write tables and report of an evaluated run into a folder. Same raw data, same bytes."""
    data = replace(report_data(evaluation, pair, folder), gate=gate)
    write_tables(data, evaluation.table(), folder)
    write_report(folder / REPORT_FILE, data)
    return data


def write_tables(data: ReportData, trials: pd.DataFrame, folder: Path) -> None:
    """Write the tables alone, missing.csv and skipped.csv only where trials are. Raises RecordingError and OSError.

    Args:
        data: what the other tables hold.
        trials: the content of trials.csv.
        folder: where to write.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(trials, folder / "trials.csv")
    write_csv(data.summary, folder / "summary.csv")
    write_csv(data.comparisons, folder / "comparisons.csv")
    write_csv(data.aggregates, folder / "aggregates.csv")
    if data.missing:
        write_csv(missing_table(data.missing), folder / MISSING_FILE)
    else:
        (folder / MISSING_FILE).unlink(missing_ok=True)
    if data.skipped:
        write_csv(skipped_table(data.skipped), folder / SKIPPED_FILE)
    else:
        (folder / SKIPPED_FILE).unlink(missing_ok=True)
