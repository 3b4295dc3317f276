"""Figures of calls timed again: percentiles, deadline misses, and how far two passes of the same calls differ."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from pytest_lpb.kpis.timing import PERCENTILES
from pytest_lpb.trajectory import MAX_WALL_PER_CPU, FloatArray

NOISE_OF = ("p50", "p95")  # figures whose noise floor is measured
FLOOR_PERCENT = 95.0  # of rows whose noise is at most the floor


@dataclass(frozen=True)
class RetimedRow:
    """The timing of one planner in one scenario, over all passes and trials; the first call of a trial is apart."""

    scenario: str
    planner: str
    trials: int
    different_trials: int  # whose actions were not the recorded ones
    passes: int
    calls: int  # timed calls, the first of each trial not among them
    p50_ms: float
    p95_ms: float
    p99_ms: float
    max_ms: float
    mean_ms: float
    first_call_ms: float  # median over trials and passes
    first_call_max_ms: float
    period_ms: float  # control period
    deadline_misses: int  # calls longer than the control period, the first ones included
    deadline_calls: int  # of so many
    noise_p50: float  # relative difference of two passes, the largest; NaN with one pass
    noise_p95: float
    wall_per_cpu: float  # median over calls

    @property
    def contended(self) -> bool:
        """Whether the calls had to wait for a processor."""
        return self.wall_per_cpu > MAX_WALL_PER_CPU

    def to_dict(self) -> dict[str, Any]:
        """As JSON takes it: None for NaN."""
        items = asdict(self).items()
        return {key: None if isinstance(value, float) and math.isnan(value) else value for key, value in items}

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> RetimedRow:
        """The row in such a dictionary; further keys are allowed. Raises KeyError for one that is missing."""
        values: dict[str, Any] = {}
        for column in fields(cls):
            value = entry[column.name]
            values[column.name] = math.nan if value is None else value
        return cls(**values)


@dataclass(frozen=True)
class PassTimes:
    """What one pass measured [ms]."""

    calls: Sequence[float]
    first_calls: Sequence[float]
    wall_per_cpu: float


def row_of(
    scenario: str, planner: str, passes: Sequence[PassTimes], cold_ms: Sequence[float], period_ms: float, different: int
) -> RetimedRow:
    """The figures of one planner in one scenario.

    Args:
        scenario: its key.
        planner: its name.
        passes: at least one; each with one first call per trial, and with one further call or more.
        cold_ms: first calls of the pass before the timed ones.
        period_ms: the control period.
        different: trials whose actions were not the recorded ones.
    """
    calls = np.concatenate([measured.calls for measured in passes])
    first = np.concatenate([measured.first_calls for measured in passes])
    p50, p95, p99 = _percentiles(calls)
    by_pass = [_percentiles(np.array(measured.calls)) for measured in passes]
    return RetimedRow(
        scenario=scenario,
        planner=planner,
        trials=len(passes[0].first_calls),
        different_trials=different,
        passes=len(passes),
        calls=len(calls),
        p50_ms=p50,
        p95_ms=p95,
        p99_ms=p99,
        max_ms=float(calls.max()),
        mean_ms=float(calls.mean()),
        first_call_ms=float(np.median(first)),
        first_call_max_ms=float(max(*first, *cold_ms, 0.0)),
        period_ms=period_ms,
        deadline_misses=int((calls > period_ms).sum() + (first > period_ms).sum()),
        deadline_calls=len(calls) + len(first),
        noise_p50=spread([median for median, _, _ in by_pass]),
        noise_p95=spread([tail for _, tail, _ in by_pass]),
        wall_per_cpu=float(np.median([measured.wall_per_cpu for measured in passes])),
    )


def _percentiles(times: FloatArray) -> list[float]:
    """NumPy's `linear` 50th, 95th and 99th percentile, as in the KPIs of solver times."""
    percentiles: list[float] = np.percentile(times, list(PERCENTILES.values()), method="linear").tolist()
    return percentiles


def spread(values: Sequence[float]) -> float:
    """Largest relative difference of any two positive values, of the smaller; NaN for fewer than two."""
    return max(values) / min(values) - 1.0 if len(values) > 1 and min(values) > 0.0 else math.nan


def noise_floor(rows: Sequence[RetimedRow], figure: str) -> float:
    """What two passes of the same calls differ by in a figure, at most, in 95 % of the rows; NaN without passes.

    Up to 20 rows that is the largest of all; of many rows, a few that were disturbed do not speak for the rest.
    """
    known = [noise for row in rows if not math.isnan(noise := getattr(row, f"noise_{figure}"))]
    return float(np.percentile(known, FLOOR_PERCENT, method="higher")) if known else math.nan


def against(row: RetimedRow, rows: Sequence[RetimedRow]) -> str:
    """How a row's median compares with the fastest in its scenario: `fastest`, `noise`, or how much slower it is.

    A difference below the noise floor of all rows, or below the noise of one of the two, is noise.
    """
    rivals = [other for other in rows if other.scenario == row.scenario]
    fastest = min(rivals, key=lambda other: other.p50_ms)
    if row == fastest:
        return "fastest" if len(rivals) > 1 else ""
    difference = row.p50_ms / fastest.p50_ms - 1.0
    if difference < np.nanmax([noise_floor(rows, "p50"), row.noise_p50, fastest.noise_p50, 0.0]):
        return f"noise ({100.0 * difference:+.1f} %)"
    return f"{100.0 * difference:+.0f} %" if difference < 1.0 else f"{1.0 + difference:.3g} x"
