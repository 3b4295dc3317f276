"""Writes what a run is read by: trials.csv, summary.csv, comparisons.csv and report.html."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.report import write_report
from pytest_lpb.run.evaluation import Evaluation
from pytest_lpb.run.tables import comparisons_table, summary_table, write_csv

REPORT_FILE = "report.html"


def report_data(evaluation: Evaluation, pair: tuple[str, str] | None = None) -> ReportData:
    """Tables and raw data of an evaluated run.

    Args:
        evaluation: the trials.
        pair: the two planners to compare; None: every pair.
    """
    trials = evaluation.trials
    compared = trials if pair is None else trials[trials["planner"].isin(pair)]
    comparisons: pd.DataFrame = comparisons_table(compared, evaluation.kpis)
    return ReportData(
        trials=trials,
        summary=summary_table(trials, evaluation.kpis),
        comparisons=comparisons,
        kpis=evaluation.kpis,
        run_info=evaluation.run.info(),
        trajectory_of=evaluation.trajectory_of,
        warnings=evaluation.warnings,
        title=evaluation.run.path.name,
    )


def write_results(evaluation: Evaluation, folder: Path, pair: tuple[str, str] | None = None) -> ReportData:
    """Write tables and report of an evaluated run into a folder. Same raw data, same bytes."""
    data = write_tables(evaluation, folder, pair)
    write_report(folder / REPORT_FILE, data)
    return data


def write_tables(evaluation: Evaluation, folder: Path, pair: tuple[str, str] | None = None) -> ReportData:
    """Write the tables alone; what they hold, for a report."""
    data = report_data(evaluation, pair)
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(evaluation.table(), folder / "trials.csv")
    write_csv(data.summary, folder / "summary.csv")
    write_csv(data.comparisons, folder / "comparisons.csv")
    return data
