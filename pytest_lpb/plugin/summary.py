"""The section that a run prints at its end."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import pandas as pd
import pytest

from pytest_lpb.plugin.rates import RateVerdict
from pytest_lpb.report.build import REPORT_FILE
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.text import planner_table

MAX_FAILURES = 40  # lines of failed trials; the report has them all


def write_summary(
    reporter: pytest.TerminalReporter,
    data: ReportData | None,
    rates: Sequence[RateVerdict],
    faults: Sequence[str],
    folder: Path,
) -> None:
    """Print the planners' table, one line per failed trial, rates, warnings, and the report's path."""
    reporter.section("local planner benchmark", sep="=")
    if data is not None:
        for line in planner_table(data):
            reporter.write_line(line)
        for line in failure_lines(data.trials):
            reporter.write_line(line)
    for verdict in rates:
        reporter.write_line(f"{'met' if verdict.met else 'FAILED'}: {verdict.text}", red=not verdict.met)
    for fault in faults:
        reporter.write_line(f"warning: {fault}", yellow=True)
    if (folder / REPORT_FILE).is_file():
        reporter.write_line(f"report: {folder / REPORT_FILE}")
    else:
        reporter.write_line(f"raw data: {folder}")


def failure_lines(trials: pd.DataFrame) -> Iterable[str]:
    """Outcome and message of each trial that was no success."""
    failed = trials[~trials["success"].astype(bool)]
    if len(failed):
        yield ""
    for row in failed.head(MAX_FAILURES).itertuples():
        yield f"{row.scenario} :: {row.planner} :: seed{row.seed}  {row.outcome}: {row.message}"
    if len(failed) > MAX_FAILURES:
        yield f"... and {len(failed) - MAX_FAILURES} more; the report lists them all"
