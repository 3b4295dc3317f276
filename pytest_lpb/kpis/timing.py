"""KPIs about computation time. They depend on the machine and its load, so they never gate contended runs.

Each says for itself whether other work on the same cores disturbed it: a wall-time figure that is above 1.2 of the
same figure of CPU time did (its median may be clean while its tail waited), and all of them where `timing_contended`
is true. CPU time does not run while a call waits, so it stands mild contention: a core for each worker, and a median
call that did not wait.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.kpis.derived import measured, once
from pytest_lpb.kpis.registry import kpi
from pytest_lpb.trajectory import MAX_WALL_PER_CPU, FloatArray, Trajectory

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


def _waited(wall: float, cpu: float) -> bool:
    """Whether a wall time [ms] is more than contention-free calls of this CPU time [ms] take; False without either."""
    return cpu > 0.0 and wall > MAX_WALL_PER_CPU * cpu


def _wall_contended(trajectory: Trajectory, statistic: str) -> bool:
    wall, cpu = (statistics(trajectory)[statistic] for statistics in (_wall_statistics, _cpu_statistics))
    return trajectory.timing_contended or _waited(wall, cpu)


def _cpu_contended(trajectory: Trajectory) -> bool:
    """Whether contention was more than mild: fewer cores than workers, or a median call that waited for one."""
    return bool(trajectory.metadata["workers"] > trajectory.metadata["cores"]) or trajectory.calls_waited


def _define(
    prefix: str,
    statistic: str,
    statistics: Callable[[Trajectory], dict[str, float]],
    contention: Callable[[Trajectory], bool],
) -> None:
    """Register one KPI of a family over all calls but the first, which pays for compilation and caches."""

    @kpi(f"{prefix}_{statistic}_ms", "ms", "lower", "all", group="timing", timing=True, contention=contention)
    def member(trajectory: Trajectory) -> float:
        return statistics(trajectory)[statistic]


for _statistic in ("mean", *PERCENTILES, "max"):
    _define("solver_time", _statistic, _wall_statistics, partial(_wall_contended, statistic=_statistic))
for _statistic in PERCENTILES:
    _define("solver_cpu", _statistic, _cpu_statistics, _cpu_contended)


def _first_contended(trajectory: Trajectory) -> bool:
    wall, cpu = _wall_ms(trajectory), _cpu_ms(trajectory)
    waited = bool(len(wall) and len(cpu)) and _waited(float(wall[0]), float(cpu[0]))
    return trajectory.timing_contended or waited


@kpi("first_call_ms", "ms", "lower", "all", group="timing", timing=True, contention=_first_contended)
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
    return _late(trajectory, _wall_ms(trajectory))


def _late(trajectory: Trajectory, times: FloatArray) -> NDArray[np.bool_]:
    period_ms = 1000.0 * _recorded(trajectory, "period_s")
    return times > period_ms if math.isfinite(period_ms) else np.zeros(0, dtype=np.bool_)


def _misses_contended(trajectory: Trajectory) -> bool:
    """Whether there are calls that missed the deadline because they waited: by CPU time, fewer did."""
    by_cpu = _late(trajectory, _cpu_ms(trajectory))
    measured_both = len(by_cpu) == len(_missed(trajectory))
    return trajectory.timing_contended or (measured_both and bool(_missed(trajectory).sum() > by_cpu.sum()))


@kpi("deadline_miss_rate", "1", "lower", "all", group="timing", timing=True, contention=_misses_contended)
def deadline_miss_rate(trajectory: Trajectory) -> float:
    """Share of calls, the first included, that took longer than the control period."""
    missed = _missed(trajectory)
    return float(missed.mean()) if len(missed) else math.nan


@kpi("longest_miss_burst", "calls", "lower", "all", group="timing", timing=True, contention=_misses_contended)
def longest_miss_burst(trajectory: Trajectory) -> float:
    """Most consecutive calls, the first included, that took longer than the control period."""
    missed = _missed(trajectory)
    if not len(missed):
        return math.nan
    kept = np.flatnonzero(np.concatenate(([True], ~missed, [True])))
    return float(np.diff(kept).max() - 1)


_mean_contended = partial(_wall_contended, statistic="mean")  # as good as the loop's, which has no CPU time


@kpi("real_time_factor", "1", "higher", "all", group="timing", timing=True, contention=_mean_contended)
def real_time_factor(trajectory: Trajectory) -> float:
    """Simulated time over the wall time of the trial's loop; NaN without a measured wall time."""
    wall_s = _recorded(trajectory, "wall_s")
    return float(trajectory.t[-1] - trajectory.t[0]) / wall_s if wall_s > 0.0 else math.nan


def _recorded(trajectory: Trajectory, key: str) -> float:
    """A number of the metadata; NaN when the trial ended before it was measured."""
    value = trajectory.metadata[key]
    return math.nan if value is None else float(value)
