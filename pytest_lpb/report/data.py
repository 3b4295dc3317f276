"""What a report is made from."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from pytest_lpb.run.plan import TrialKey
from pytest_lpb.run.problems import KpiColumn

if TYPE_CHECKING:
    import pandas as pd

    from pytest_lpb.retime.result import Retimed
    from pytest_lpb.run.gate import GateResult
    from pytest_lpb.trajectory import Trajectory


class ReportedKpi(KpiColumn, Protocol):
    """What a report needs to know of a KPI: what tables do, and its heading."""

    @property
    def group(self) -> str:
        """`goal`, `path`, `safety`, `smoothness`, `solver`, `timing` or `user`."""


@dataclass(frozen=True)
class ReportData:
    """An evaluated run: everything `write_report` and `write_plots` need."""

    trials: pd.DataFrame  # one row per trial: columns of trials.csv, duration_s, control, message, command
    summary: pd.DataFrame  # columns of summary.csv; scenario `all` is the mean over scenarios
    comparisons: pd.DataFrame  # columns of comparisons.csv
    aggregates: pd.DataFrame  # columns of aggregates.csv
    kpis: Sequence[ReportedKpi]
    run_info: Mapping[str, Any]  # run.json
    trajectory_of: Callable[[str], Trajectory]  # raw data of the trial with this node id
    warnings: Sequence[str] = ()
    retimed: Retimed | None = None  # calls timed again by `lpb-report --retime`
    gate: GateResult | None = None  # verdicts against a baseline
    title: str = ""  # the run folder's name
    folder: Path | None = None  # where the report will lie; None: in the run folder
    missing: Sequence[TrialKey] = ()  # planned trials that are not among `trials`
    skipped: Mapping[TrialKey, str] = field(default_factory=dict)  # trials that planners do not support, and why
    resume: str = ""  # the command that runs them; empty: none does
