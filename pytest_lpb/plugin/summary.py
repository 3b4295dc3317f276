"""The section that a run prints at its end."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

import pandas as pd
import pytest

from pytest_lpb.names import count
from pytest_lpb.plugin.rates import RateVerdict
from pytest_lpb.report.build import REPORT_FILE
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.gate_text import conclusion, gate_lines
from pytest_lpb.report.text import planner_notes, planner_table, title_lines
from pytest_lpb.run.gate import GateResult

TrialKey = tuple[str, str, int]  # scenario, planner, seed
MAX_FAILURES = 40  # lines of failed trials; the report has them all


def write_summary(
    reporter: pytest.TerminalReporter,
    data: ReportData | None,
    rates: Sequence[RateVerdict],
    gate: GateResult | None,
    faults: Sequence[str],
    folder: Path,
    known: Collection[TrialKey],
) -> None:
    """Print the planners' table, one line per failed trial, rates, warnings, and the report's path.

    Args:
        reporter: pytest's terminal reporter.
        data: tables; None when there are none.
        rates: verdicts of `--lpb-assert=rate`.
        gate: verdicts of the regression gate; None without a baseline.
        faults: what went wrong besides.
        folder: the run folder.
        known: trials that failed as expected; they are counted, not listed.
    """
    reporter.section("local planner benchmark", sep="=")
    if data is not None:
        for line in title_lines(data):
            reporter.write_line(line, bold=True)
        for line in planner_table(data) if len(data.trials) else planner_notes(data):
            reporter.write_line(line)
        for line in failure_lines(data.trials, known):
            reporter.write_line(line)
    for verdict in rates:
        reporter.write_line(f"{'met' if verdict.met else 'FAILED'}: {verdict.text}", red=not verdict.met)
    if gate is not None:
        reporter.write_line("")
        for line in gate_lines(gate):
            reporter.write_line(line)
        reporter.write_line(conclusion(gate), red=gate.closed, yellow=not gate.sure, bold=True)
    for fault in faults:
        reporter.write_line(f"warning: {fault}", yellow=True)
    if (folder / REPORT_FILE).is_file():
        reporter.write_line(f"report: {folder / REPORT_FILE}")
    else:
        reporter.write_line(f"raw data: {folder}")


def failure_lines(trials: pd.DataFrame, known: Collection[TrialKey]) -> Iterable[str]:
    """Outcome and message of each trial that was no success and not known to fail; how many were."""
    unsolved = trials[~trials["success"].astype(bool)]
    keys = zip(unsolved["scenario"], unsolved["planner"], unsolved["seed"], strict=True)
    failed = unsolved[[key not in known for key in keys]]
    if len(unsolved):
        yield ""
    for _, row in failed.head(MAX_FAILURES).iterrows():
        outcome = "criteria_failed" if row["failed_criteria"] else row["outcome"]
        yield f"{row['scenario']} :: {row['planner']} :: seed{row['seed']}  {outcome}: {row['message']}"
    if len(failed) < len(unsolved):
        yield f"{count(len(unsolved) - len(failed), 'trial')} failed as expected (xfail); the report lists them"
    if len(failed) > MAX_FAILURES:
        yield f"... and {len(failed) - MAX_FAILURES} more; the report lists them all"
