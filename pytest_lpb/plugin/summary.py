"""The section that a run prints at its end."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import numpy as np
import pandas as pd
import pytest

from pytest_lpb.names import count
from pytest_lpb.plugin.rates import RateVerdict
from pytest_lpb.plugin.session import LpbSession
from pytest_lpb.report.build import REPORT_FILE
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.fault_text import fault_lines
from pytest_lpb.report.gate_text import conclusion, gate_lines
from pytest_lpb.report.text import planner_notes, planner_table, title_lines
from pytest_lpb.run.faults import FAULTS
from pytest_lpb.run.gate import GateResult

TrialKey = tuple[str, str, int]  # scenario, planner, seed
MAX_FAILURES = 40  # lines of failed trials; the report has them all


def write_summary(
    reporter: pytest.TerminalReporter,
    data: ReportData | None,
    rates: Sequence[RateVerdict],
    gate: GateResult | None,
    faults: Sequence[str],
    session: LpbSession,
    known: Collection[TrialKey],
    unreported: Sequence[str] = (),
) -> None:
    """Print the planners' table, faults and failed trials, rates, warnings, and the report's path.

    Args:
        reporter: pytest's terminal reporter.
        data: tables; None when there are none.
        rates: verdicts of `--lpb-assert=rate`.
        gate: verdicts of the regression gate; None without a baseline.
        faults: what went wrong besides.
        session: knows the run folder, and how to make its report.
        known: trials that failed as expected; they are counted, not listed.
        unreported: what is known without tables.
    """
    reporter.section("local planner benchmark", sep="=")
    if data is not None:
        for line in title_lines(data):
            reporter.write_line(line, bold=True)
        for line in planner_table(data) if len(data.trials) else planner_notes(data):
            reporter.write_line(line)
        for line in failure_lines(data.trials, known):
            reporter.write_line(line)
    for line in unreported:
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
    if session.reported and (session.run / REPORT_FILE).is_file():
        reporter.write_line(f"report: {session.shown_run / REPORT_FILE}")
    else:
        reporter.write_line(f"raw data: {session.shown_run}; tables and report: {session.report_command}")


def failure_lines(trials: pd.DataFrame, known: Collection[TrialKey]) -> Iterable[str]:
    """Faults, equal ones as one; then outcome and message of each trial that was no success and not known to fail."""
    unsolved = trials[~trials["success"].astype(bool)]
    keys = zip(unsolved["scenario"], unsolved["planner"], unsolved["seed"], strict=True)
    # An array: an empty list would be taken for no columns.
    failed = unsolved[np.array([key not in known for key in keys], dtype=bool)]
    if len(unsolved):
        yield ""
    yield from fault_lines(failed.to_dict("records"))
    others = failed[~failed["outcome"].isin(FAULTS)]
    for _, row in others.head(MAX_FAILURES).iterrows():
        outcome = "criteria_failed" if row["failed_criteria"] else row["outcome"]
        yield f"{row['scenario']} :: {row['planner']} :: seed{row['seed']}  {outcome}: {row['message']}"
    if len(failed) < len(unsolved):
        yield f"{count(len(unsolved) - len(failed), 'trial')} failed as expected (xfail); the report lists them"
    if len(others) > MAX_FAILURES:
        yield f"... and {len(others) - MAX_FAILURES} more; the report lists them all"
