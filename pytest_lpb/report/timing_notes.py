"""What a reader must know of timing: whether it was contended and what to do then, and planners that are too slow."""

from __future__ import annotations

from collections.abc import Container, Iterator
from typing import Any

import numpy as np
import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.numbers import count, percent
from pytest_lpb.report.titles import MARK, contended_trials

MOST = 0.5
"""Share of late calls above which a planner gets a warning."""

MISSES = "deadline_miss_rate"
CPU = "solver_cpu_"


def contention_notes(data: ReportData, shown: Container[str] | None = None) -> Iterator[str]:
    """What † means in this run and what to do about it; nothing where none of the KPIs shown bears it.

    Args:
        data: tables.
        shown: names of the KPIs that the reader sees; default all.
    """
    timing = (kpi for kpi in data.kpis if kpi.timing and (shown is None or kpi.name in shown))
    disturbed = {kpi.name: contended_trials(kpi, data) for kpi in timing}
    if not any(disturbed.values()):
        return
    whole = data.trials["timing_contended"].eq(True).sum()
    of = f"of {count(len(data.trials), 'trial')}"
    if whole:
        yield (
            f"{MARK} Timing was contended in {whole} {of}: {_reason(data)}. Do not compare planners by them. "
            f"{_remedy(data)}"
        )
    else:
        most = max(disturbed.values())
        yield (
            f"{MARK} Calls waited for a core in up to {most} {of}, and the marked figures include the wait (wall time "
            f"more than 1.2 times the CPU time). {_remedy(data)}"
        )
    cpu = [contended_trials(kpi, data) for kpi in data.kpis if kpi.timing and kpi.name.startswith(CPU)]
    if cpu and max(cpu) < len(data.trials):
        where = f", except in {count(max(cpu), 'trial')}" if max(cpu) else ""
        yield (
            f"CPU times can be compared{where}: a call that waits uses none, each worker had a core, and the median "
            "call did not wait."
        )


def _workers_and_cores(data: ReportData) -> tuple[int, int] | None:
    workers, machine = data.run_info.get("workers"), data.run_info.get("machine") or {}
    cores = machine.get("cores")
    return (workers, cores) if isinstance(workers, int) and isinstance(cores, int) else None


def _reason(data: ReportData) -> str:
    known = _workers_and_cores(data)
    if known is not None and "merged" not in data.run_info and known[0] > known[1] - 1:
        return f"{count(known[0], 'worker')} on {count(known[1], 'core')} leave no core to the rest of the system"
    return "other work ran on the same cores"


def _remedy(data: ReportData) -> str:
    if data.retimed is not None and data.retimed.rows:
        return "Compare the calls that were timed again (Retimed)."
    known = _workers_and_cores(data)
    fewer = f", or run with -n {known[1] - 1}" if known is not None and known[0] > known[1] - 1 > 0 else ""
    return f"Time the calls again with `lpb-report RUN --retime`{fewer}."


def deadline_warnings(data: ReportData) -> Iterator[str]:
    """Planners whose calls take longer than the control period most of the time, where they do."""
    if MISSES not in data.trials:
        return
    rates = data.trials.assign(rate=pd.to_numeric(data.trials[MISSES]).astype(np.float64)).dropna(subset=["rate"])
    kpi = next((kpi for kpi in data.kpis if kpi.name == MISSES), None)
    for planner, rows in rates.groupby("planner", sort=True):
        means = rows.groupby("scenario")["rate"].mean()
        late = means[means > MOST].sort_values(ascending=False, kind="stable")
        if len(late):
            mark = f" {MARK}" if kpi is not None and contended_trials(kpi, data, str(planner)) else ""
            yield _late(str(planner), late, len(means)) + mark


def _late(planner: str, late: pd.Series[Any], scenarios: int) -> str:
    worst = f"{percent(late.iloc[0])} of its calls in {late.index[0]}"
    where = f"in {len(late)} of {count(scenarios, 'scenario')}: {worst}" if scenarios > 1 else f": {worst}"
    return (
        f"{planner} misses most of its deadlines{' ' * (scenarios > 1)}{where} took longer than the control period. "
        "The simulation waited for it; a robot would not"
    )
