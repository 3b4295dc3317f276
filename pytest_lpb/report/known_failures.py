"""Failures that scenario or planner files expect (xfail): how many there are of each, and why."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.view import KnownFailure, PlannerStyle


def reasons(trials: pd.DataFrame) -> pd.Series[str]:
    """Why each trial was known to fail; empty for trials that were not."""
    if "known_failure" not in trials:
        return pd.Series("", index=trials.index, dtype=object)
    return trials["known_failure"].fillna("").astype(str)


def known_failures(data: ReportData, styles: Mapping[str, PlannerStyle]) -> list[KnownFailure] | None:
    """Known failures by scenario, planner and reason; None where there are none."""
    why = reasons(data.trials)
    marked = data.trials.assign(known_failure=why)[why.ne("")]
    ran = data.trials.groupby(["scenario", "planner"]).size()
    groups = marked.groupby(["scenario", "planner", "known_failure"], sort=False).size().reset_index(name="failed")
    return [
        KnownFailure(
            scenario=str(row["scenario"]),
            style=styles[str(row["planner"])],
            reason=str(row["known_failure"]),
            failed=int(row["failed"]),
            trials=int(ran[row["scenario"], row["planner"]]),
        )
        for row in groups.to_dict("records")
    ] or None
