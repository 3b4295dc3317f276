"""KPIs about computation time. They depend on the machine and its load, so they never gate contended runs."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.kpis.derived import measured, once
from pytest_lpb.kpis.registry import kpi
from pytest_lpb.trajectory import FloatArray, Trajectory

PERCENTILES = {"p50": 50.0, "p95": 95.0, "p99": 99.0}


@once
def _wall_ms(trajectory: Trajectory) -> FloatArray:
    return _calls(trajectory.solver_wall_ms)


@once
def _cpu_ms(trajectory: Trajectory) -> FloatArray:
    return _calls(trajectory.solver_cpu_ms)


def _calls(column: FloatArray) -> FloatArray:
    """Times of the planner's calls in order; rows without a call are NaN."""
    times = measured(column)
    return times[np.isfinite(times)]


@once
def _wall_statistics(trajectory: Trajectory) -> dict[str, float]:
    return _statistics(_wall_ms(trajectory)[1:])


@once
def _cpu_statistics(trajectory: Trajectory) -> dict[str, float]:
    return _statistics(_cpu_ms(trajectory)[1:])


def _statistics(times: FloatArray) -> dict[str, float]:
    """Mean, NumPy's `linear` percentiles and maximum of times (n,); NaN without any."""
    if not len(times):
        return dict.fromkeys(("mean", *PERCENTILES, "max"), math.nan)
    percentiles = np.percentile(times, list(PERCENTILES.values()), method="linear")
    return {
        "mean": float(times.mean()),
        **dict(zip(PERCENTILES, percentiles.tolist(), strict=True)),
        "max": float(times.max()),
    }


def _define(prefix: str, statistic: str, statistics: Callable[[Trajectory], dict[str, float]]) -> None:
    """Register one KPI of a family over all calls but the first, which pays for compilation and caches."""

    @kpi(f"{prefix}_{statistic}_ms", "ms", "lower", "all", group="timing", timing=True)
    def member(trajectory: Trajectory) -> float:
        return statistics(trajectory)[statistic]


for _statistic in ("mean", *PERCENTILES, "max"):
    _define("solver_time", _statistic, _wall_statistics)
for _statistic in PERCENTILES:
    _define("solver_cpu", _statistic, _cpu_statistics)


@kpi("first_call_ms", "ms", "lower", "all", group="timing", timing=True)
def first_call(trajectory: Trajectory) -> float:
    """Wall time of the planner's first call [ms]; NaN when it was never called."""
    times = _wall_ms(trajectory)
    return float(times[0]) if len(times) else math.nan


@kpi("setup_ms", "ms", "lower", "all", group="timing", timing=True)
def setup(trajectory: Trajectory) -> float:
    """Wall time of the planner's setup [ms]; NaN when it was not measured."""
    return _recorded(trajectory, "setup_ms")


@once
def _missed(trajectory: Trajectory) -> NDArray[np.bool_]:
    """Which calls, the first included, took longer than the control period, (calls,)."""
    times = _wall_ms(trajectory)
    period_ms = 1000.0 * _recorded(trajectory, "period_s")
    return times > period_ms if math.isfinite(period_ms) else np.zeros(0, dtype=np.bool_)


@kpi("deadline_miss_rate", "1", "lower", "all", group="timing", timing=True)
def deadline_miss_rate(trajectory: Trajectory) -> float:
    """Share of calls, the first included, that took longer than the control period."""
    missed = _missed(trajectory)
    return float(missed.mean()) if len(missed) else math.nan


@kpi("longest_miss_burst", "calls", "lower", "all", group="timing", timing=True)
def longest_miss_burst(trajectory: Trajectory) -> float:
    """Most consecutive calls, the first included, that took longer than the control period."""
    missed = _missed(trajectory)
    if not len(missed):
        return math.nan
    kept = np.flatnonzero(np.concatenate(([True], ~missed, [True])))
    return float(np.diff(kept).max() - 1)


@kpi("real_time_factor", "1", "higher", "all", group="timing", timing=True)
def real_time_factor(trajectory: Trajectory) -> float:
    """Simulated time over the wall time of the trial's loop; NaN without a measured wall time."""
    wall_s = _recorded(trajectory, "wall_s")
    return float(trajectory.t[-1] - trajectory.t[0]) / wall_s if wall_s > 0.0 else math.nan


def _recorded(trajectory: Trajectory, key: str) -> float:
    """A number of the metadata; NaN when the trial ended before it was measured."""
    value = trajectory.metadata[key]
    return math.nan if value is None else float(value)
