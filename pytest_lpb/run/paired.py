"""The figures of one comparison: two planners, one measure, the problems they share."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.run.problems import KpiColumn, restricted_column, unit_depends_on_control
from pytest_lpb.statistics import (
    bootstrap_means,
    bootstrap_medians,
    discordant_counts,
    improvement_probability,
    mcnemar_p,
    newcombe_paired_interval,
    paired_difference,
    percentile_interval,
    ratio,
    wilcoxon_p,
)

FloatArray = NDArray[np.float64]
Sample = tuple[FloatArray, FloatArray]
"""Values of planner a and of planner b on the same problems of one scenario, each (n,)."""


@dataclass(frozen=True)
class Measure:
    """What is compared: success, or a KPI."""

    name: str
    direction: str
    over: str
    column: str
    timing: bool = False
    is_rate: bool = False
    by_control: bool = False  # its unit depends on the control mode

    @classmethod
    def of(cls, kpi: KpiColumn) -> Measure:
        """The measure of a KPI; a failed trial counts the duration where the KPI is restricted to it."""
        column = restricted_column(kpi) if kpi.restricted_to_duration else kpi.name
        return cls(kpi.name, kpi.direction, kpi.over, column, kpi.timing, by_control=unit_depends_on_control(kpi))


SUCCESS = Measure("success", "higher", "all", "success", is_rate=True)


@dataclass(frozen=True)
class Figures:
    """Figures of one comparison; for success the medians are rates. NaN without pairs; no interval of one pair."""

    pairs: int
    median_a: float = math.nan
    median_b: float = math.nan
    difference: float = math.nan
    difference_low: float = math.nan
    difference_high: float = math.nan
    ratio: float = math.nan
    p: float = math.nan
    improvement_probability: float = math.nan
    identical: bool = False


def compare(samples: Sequence[Sample], measure: Measure, rng: np.random.Generator) -> Figures:
    """Compare two planners on the problems of one scenario, or of several: then figures are means over them.

    Args:
        samples: one per scenario; problems where either value is NaN are left out.
        measure: what the values are.
        rng: for the bootstrap.
    """
    kept = [both for both in map(_complete, samples) if len(both[0])]
    if not kept:
        return Figures(pairs=0)
    centre = np.mean if measure.is_rate else np.median
    differences = [paired_difference(a, b) for a, b in kept]
    pooled = np.concatenate(differences)
    median_a = float(np.mean([centre(a) for a, _ in kept]))
    median_b = float(np.mean([centre(b) for _, b in kept]))
    low, high = _interval(kept, differences, measure, rng) if len(pooled) > 1 else (math.nan, math.nan)
    improvement = math.nan
    if measure.direction != "none":
        improvement = float(np.mean([improvement_probability(d, measure.direction) for d in differences]))
    return Figures(
        pairs=len(pooled),
        median_a=median_a,
        median_b=median_b,
        difference=float(np.mean([centre(d) for d in differences])),
        difference_low=low,
        difference_high=high,
        ratio=ratio(median_a, median_b),
        p=mcnemar_p(*discordant_counts(pooled)) if measure.is_rate else wilcoxon_p(pooled),
        improvement_probability=improvement,
        identical=not np.any(pooled),
    )


def generator(*key: str | int) -> np.random.Generator:
    """A generator that depends on `key` alone: the same comparison always draws the same resamples."""
    digest = hashlib.sha256(json.dumps(key).encode()).digest()
    return np.random.default_rng(int.from_bytes(digest[:16], "big"))


def _complete(sample: Sample) -> Sample:
    a, b = sample
    both = ~(np.isnan(a) | np.isnan(b))
    return a[both], b[both]


def _interval(
    samples: Sequence[Sample], differences: Sequence[FloatArray], measure: Measure, rng: np.random.Generator
) -> tuple[float, float]:
    if measure.is_rate and len(samples) == 1:
        return newcombe_paired_interval(*samples[0])
    first = float(differences[0][0])
    if all(np.all(d == first) for d in differences):
        return first, first
    bootstrap = bootstrap_means if measure.is_rate else bootstrap_medians
    return percentile_interval(bootstrap(differences, rng))
