"""Headings of KPIs: which quantity it is where a KPI has two, and whether its timing was disturbed."""

from __future__ import annotations

from pytest_lpb.report.data import ReportData, ReportedKpi
from pytest_lpb.report.numbers import kpi_title
from pytest_lpb.run.contention import contended
from pytest_lpb.run.problems import KpiColumn

MARK = "†"
REACHED = "if reached"
RESTRICTED = "failures count the duration"


def value_title(kpi: ReportedKpi) -> str:
    """A KPI's values as trials have them: `time to goal if reached [s]`, of the trials that have one."""
    return _with(kpi, f" {REACHED}") if kpi.restricted_to_duration else kpi_title(kpi.name, kpi.unit)


def compared_title(kpi: ReportedKpi) -> str:
    """A KPI as planners are compared by it: `time to goal, failures count the duration [s]`, of all trials."""
    return _with(kpi, f", {RESTRICTED}") if kpi.restricted_to_duration else kpi_title(kpi.name, kpi.unit)


def compared_name(kpi: KpiColumn) -> str:
    """The same in the plain text of terminals and comments, by the KPI's name."""
    return f"{kpi.name}, {RESTRICTED}" if kpi.restricted_to_duration else kpi.name


def timing_mark(kpi: KpiColumn, data: ReportData) -> str:
    """` †` for timing that other work disturbed in a trial of the run, else nothing."""
    return f" {MARK}" if is_contended(kpi, data) else ""


def is_contended(kpi: KpiColumn, data: ReportData, planner: str | None = None) -> bool:
    """Whether a KPI was disturbed in a trial of the run, or of one planner."""
    return contended_trials(kpi, data, planner) > 0


def contended_trials(kpi: KpiColumn, data: ReportData, planner: str | None = None) -> int:
    """In how many trials a KPI was disturbed."""
    if not kpi.timing or data.trials.empty:
        return 0
    trials = data.trials if planner is None else data.trials[data.trials["planner"] == planner]
    return int(contended(trials, kpi).sum())


def _with(kpi: ReportedKpi, words: str) -> str:
    title = kpi_title(kpi.name, kpi.unit)
    name, bracket, unit = title.partition(" [")
    return f"{name}{words}{bracket}{unit}"
