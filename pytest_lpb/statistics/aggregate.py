"""Aggregates over several scenarios (Agarwal et al. 2021, "Deep reinforcement learning at the edge")."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from pytest_lpb.statistics.bootstrap import RESAMPLES, percentile_interval

FloatArray = NDArray[np.float64]


def interquartile_mean(values: ArrayLike) -> float:
    """Mean of the middle half of `values`, (n,); NaN is ignored, NaN without values."""
    x = np.asarray(values, dtype=np.float64).ravel()
    x = x[~np.isnan(x)]
    return float(stats.trim_mean(x, 0.25)) if len(x) else math.nan


def stratified_interval(
    strata: Sequence[ArrayLike],
    statistic: Callable[[FloatArray], float],
    rng: np.random.Generator,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
) -> tuple[float, float]:
    """Percentile interval of a statistic of all values together, problems resampled within each stratum.

    Args:
        strata: values of each scenario, (n_s,); NaN is ignored.
        statistic: of all values, (sum of n_s,), for instance `interquartile_mean`.
        rng: where all randomness comes from.
        confidence: of the two-sided interval.
        resamples: number of bootstrap samples.

    Returns:
        The lower and upper end; both NaN without values.
    """
    arrays = [np.asarray(values, dtype=np.float64) for values in strata]
    kept = [x[~np.isnan(x)] for x in arrays]
    kept = [x for x in kept if len(x)]
    if not kept:
        return math.nan, math.nan
    resampled = np.hstack([x[rng.integers(len(x), size=(resamples, len(x)))] for x in kept])
    return percentile_interval([statistic(row) for row in resampled], confidence)


def performance_profile(values: ArrayLike, thresholds: ArrayLike) -> FloatArray:
    """Share of problems whose value is at most each threshold (Dolan & More 2002; Agarwal et al. 2021).

    Args:
        values: one per problem, (n,), lower is better; NaN (not solved) counts and is below no threshold.
        thresholds: (m,).

    Returns:
        Shares in [0, 1], (m,); NaN without problems.
    """
    x = np.asarray(values, dtype=np.float64)
    tau = np.asarray(thresholds, dtype=np.float64)
    if len(x) == 0:
        return np.full(tau.shape, np.nan)
    below = np.searchsorted(np.sort(x[~np.isnan(x)]), tau, side="right")
    return np.asarray(below / len(x), dtype=np.float64)
