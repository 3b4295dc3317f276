import math

import numpy as np
import pytest

from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.trajectory import Trajectory

from .trials import make_problem, make_trial

NAN = math.nan


def called(wall_ms: list[float], **metadata: float | None) -> Trajectory:
    columns = {"solver_wall_ms": np.array(wall_ms), "solver_cpu_ms": np.array(wall_ms)}
    trial = make_trial(make_problem(), np.zeros((len(wall_ms), 2)), columns=columns)
    trial.metadata = {**trial.metadata, **metadata}
    return trial


def value(name: str, trajectory: Trajectory) -> float:
    (entry,) = load_builtin().select([name])
    return float(entry(trajectory))


def test_rows_without_a_call_do_not_count() -> None:
    trial = called([50.0, NAN, 2.0, NAN, 4.0, NAN])
    assert value("first_call_ms", trial) == 50.0
    assert value("solver_time_mean_ms", trial) == 3.0
    assert value("solver_time_max_ms", trial) == 4.0


def test_one_call_has_no_steady_state() -> None:
    trial = called([50.0, NAN])
    assert value("first_call_ms", trial) == 50.0
    assert math.isnan(value("solver_time_p99_ms", trial))
    assert math.isnan(value("solver_cpu_p50_ms", trial))
    assert value("deadline_miss_rate", trial) == 0.0


@pytest.mark.parametrize(
    ("wall_ms", "burst"),
    [
        ([1.0, 1.0, NAN], 0),
        ([9.0, 9.0, 9.0, NAN], 3),
        ([9.0, 1.0, 9.0, NAN, 9.0, 1.0, NAN], 2),  # consecutive calls, whatever rows lie between
        ([5.0, NAN], 0),  # exactly the period is in time
    ],
)
def test_bursts_of_missed_deadlines(wall_ms: list[float], burst: int) -> None:
    assert value("longest_miss_burst", called(wall_ms, period_s=0.005)) == burst


@pytest.mark.parametrize("name", ["setup_ms", "real_time_factor", "deadline_miss_rate", "longest_miss_burst"])
def test_what_was_not_measured_is_nan(name: str) -> None:
    assert math.isnan(value(name, called([1.0, NAN], setup_ms=None, wall_s=None, period_s=None)))


@pytest.mark.parametrize("name", ["setup_ms", "real_time_factor", "deadline_miss_rate"])
def test_missing_metadata_is_a_fault(name: str) -> None:
    trial = called([1.0, NAN])
    trial.metadata = {}
    with pytest.raises(KeyError):
        value(name, trial)


def contended_kpis(wall_ms: list[float], cpu_ms: list[float], *, workers: int = 1, cores: int = 2) -> set[str]:
    """Timing KPIs that say of themselves that they were contended."""
    columns = {"solver_wall_ms": np.array([*wall_ms, NAN]), "solver_cpu_ms": np.array([*cpu_ms, NAN])}
    trial = make_trial(make_problem(), np.zeros((len(wall_ms) + 1, 2)), columns=columns)
    trial.metadata = {**trial.metadata, "workers": workers, "cores": cores, "period_s": 0.008}
    return {kpi.name for kpi in load_builtin() if kpi.is_contended(trial)}


CPU = {"solver_cpu_p50_ms", "solver_cpu_p95_ms", "solver_cpu_p99_ms"}
TIMING = {kpi.name for kpi in load_builtin() if kpi.timing}


def test_each_timing_kpi_is_judged_by_its_own_percentile() -> None:
    """20 calls of 1.5 ms CPU, of which two waited until 9 ms: the median is clean, the tail is not."""
    cpu = [1.5] * 21
    assert contended_kpis(cpu, cpu) == set()
    tail = {"solver_time_p95_ms", "solver_time_p99_ms", "solver_time_max_ms"}
    late = {"deadline_miss_rate", "longest_miss_burst"}  # 9 ms of a period of 8 ms
    # The mean is (18 * 1.5 + 2 * 9) / 20 = 2.25 ms, 1.5 times that of CPU; the loop's time goes by it.
    mean = {"solver_time_mean_ms", "real_time_factor"}
    assert contended_kpis([1.5] * 19 + [9.0, 9.0], cpu) == tail | late | mean
    assert contended_kpis([9.0] + [1.5] * 20, cpu) == {"first_call_ms", *late}
    # A maximum of 1.2 times the CPU's is within what counts as undisturbed.
    assert contended_kpis([1.5] * 20 + [1.79], cpu) == set()
    # What took as long on the processor is the planner's own.
    assert contended_kpis([1.5] * 19 + [9.0, 9.0], [1.5] * 19 + [9.0, 9.0]) == set()


def test_cpu_time_stands_mild_contention() -> None:
    """As many workers as cores disturb wall times; CPU times are disturbed where calls wait or cores are shared."""
    cpu = [1.5] * 21
    assert contended_kpis(cpu, cpu, workers=2) == TIMING - CPU
    assert contended_kpis(cpu, cpu, workers=3) == TIMING
    assert contended_kpis([2.0] * 21, cpu) == TIMING
