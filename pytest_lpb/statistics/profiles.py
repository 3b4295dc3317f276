"""Profiles: which share of problems a planner does within what, as a curve instead of one figure.

Two kinds share the name *performance profile*. Dolan & Moré 2002 plot the share of problems whose cost is within a
factor of the best solver's on the same problem; Agarwal et al. 2021 plot the share of runs with a score above a bound,
a score distribution. Both are means of indicators, with pointwise intervals from the stratified bootstrap.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pytest_lpb.statistics.bootstrap import RESAMPLES
from pytest_lpb.statistics.stratified import resampled_weights

FloatArray = NDArray[np.float64]


def performance_ratios(costs: ArrayLike) -> FloatArray:
    """Costs over the least on the same problem (Dolan & Moré 2002).

    Args:
        costs: (problems, solvers), not negative, lower is better; NaN or inf: not solved.

    Returns:
        Ratios, (problems, solvers), at least 1; inf where not solved, and where the best is 0 and this one is not.

    Raises:
        ValueError: a cost is negative.
    """
    cost = np.array(costs, dtype=np.float64)
    cost[np.isnan(cost)] = np.inf
    if np.any(cost < 0):
        raise ValueError(f"costs: {cost[cost < 0][0]} is negative; ratios to the best need costs from 0 up")
    best = cost.min(axis=1, keepdims=True) if cost.size else cost[:, :1]
    ratios = np.full(cost.shape, np.inf)
    solved = np.isfinite(cost)
    equal = solved & (cost == best)
    np.divide(cost, best, out=ratios, where=solved & (best > 0))
    ratios[equal] = 1.0
    return ratios


def shares_within(strata: Sequence[ArrayLike], bounds: ArrayLike) -> FloatArray:
    """Share of values at or below each bound (m,), as the mean over strata of the share within each: (m,).

    Args:
        strata: values of each stratum, (n_s,), n_s >= 1, no NaN; inf is below no bound.
        bounds: (m,).
    """
    limits = np.asarray(bounds, dtype=np.float64)
    shares = [_share(values, limits) for values in strata]
    mean: FloatArray = np.mean(shares, axis=0) if shares else np.full(len(limits), np.nan)
    return mean


def _share(values: ArrayLike, bounds: FloatArray) -> FloatArray:
    ordered = np.sort(np.asarray(values, dtype=np.float64))
    share: FloatArray = np.searchsorted(ordered, bounds, side="right") / len(ordered)
    return share


def pointwise_band(
    strata: Sequence[ArrayLike],
    bounds: ArrayLike,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
    confidence: float = 0.95,
) -> tuple[FloatArray, FloatArray]:
    """Percentile interval of `shares_within` at each bound by the stratified bootstrap: lower, upper ends, (m,) each.

    Pointwise: at each bound 95 % of such bands hold the share, not the whole curve.
    """
    limits = np.asarray(bounds, dtype=np.float64)
    if not strata:
        return np.full(len(limits), np.nan), np.full(len(limits), np.nan)
    ordered, weights = resampled_weights(strata, rng, resamples)
    shares = np.zeros((len(ordered) + 1, weights.shape[1]))  # of the least 0, 1, .. n values
    np.cumsum(weights, axis=0, out=shares[1:])
    within, places = np.unique(np.searchsorted(ordered, limits, side="right"), return_inverse=True)
    low, high = np.quantile(shares[within], [(1 - confidence) / 2, (1 + confidence) / 2], axis=1)
    return low[places], high[places]
