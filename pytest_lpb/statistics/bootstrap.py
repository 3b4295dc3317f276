"""Bootstrap distributions of medians and means, clustered by scenario where there are several.

Resampling clusters, then problems within each drawn cluster, is the two-stage bootstrap of Davison & Hinkley
1997, section 3.8; with one cluster it is the plain bootstrap of Efron & Tibshirani 1993. Half of the samples
are drawn, the other half takes the same ranks from above instead of from below (antithetic resampling, Hall
1989): so negated values give exactly the negated distribution, and swapped planners the mirrored interval.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

RESAMPLES = 2000


def bootstrap_medians(
    clusters: Sequence[ArrayLike], rng: np.random.Generator, resamples: int = RESAMPLES
) -> FloatArray:
    """Bootstrap distribution of the mean over clusters of the median within each.

    A median of n values drawn with replacement is x[floor(n U)] of the sorted x, with U the middle order
    statistic of n uniform numbers, and that follows a beta distribution: one draw replaces n.

    Args:
        clusters: values of each cluster, (n_s,), n_s >= 1, no NaN.
        rng: where all randomness comes from.
        resamples: number of bootstrap samples R, even.

    Returns:
        One statistic per bootstrap sample, (R,); the second half mirrors the ranks drawn in the first.
    """
    sorted_values = [np.sort(np.asarray(values, dtype=np.float64)) for values in clusters]
    lengths = np.array([len(values) for values in sorted_values])
    pool = np.concatenate(sorted_values)
    starts = np.concatenate([[0], np.cumsum(lengths)[:-1]])
    picks = _picks(len(lengths), rng, resamples // 2)
    n, start = lengths[picks], starts[picks]
    middle = (n + 1) // 2
    lower = rng.beta(middle, n - middle + 1)
    # The next order statistic is the least of the n - middle uniform numbers above `lower`; odd n have one.
    above = np.maximum(n - middle, 1)
    upper = np.where(n % 2 == 0, 1 - (1 - lower) * rng.random(n.shape) ** (1 / above), lower)
    ranks = [np.minimum((end * n).astype(np.int64), n - 1) for end in (lower, upper)]
    halves = []
    for low, high in (ranks, [n - 1 - rank for rank in ranks]):
        halves.append(np.mean((pool[start + low] + pool[start + high]) / 2, axis=1))
    return np.concatenate(halves)


def bootstrap_means(clusters: Sequence[ArrayLike], rng: np.random.Generator, resamples: int = RESAMPLES) -> FloatArray:
    """Bootstrap distribution of the mean over clusters of the mean within each.

    Args:
        clusters: values of each cluster, (n_s,), n_s >= 1, no NaN.
        rng: where all randomness comes from.
        resamples: number of bootstrap samples R, even.

    Returns:
        One statistic per bootstrap sample, (R,); the second half mirrors the ranks drawn in the first.
    """
    picks = _picks(len(clusters), rng, resamples // 2)
    means = np.empty((2, *picks.shape))
    for index, values in enumerate(clusters):
        ordered = np.sort(np.asarray(values, dtype=np.float64))
        chosen = picks == index
        ranks = rng.integers(len(ordered), size=(int(chosen.sum()), len(ordered)))
        means[0, chosen] = ordered[ranks].mean(axis=1)
        means[1, chosen] = ordered[::-1][ranks].mean(axis=1)
    drawn: FloatArray = np.mean(means, axis=2).ravel()
    return drawn


def percentile_interval(distribution: ArrayLike, confidence: float = 0.95) -> tuple[float, float]:
    """Percentile interval of a bootstrap distribution (R,) (Efron & Tibshirani 1993, chapter 13).

    Percentile, not BCa: the jackknife that BCa takes its acceleration from does not work for medians.

    Returns:
        The lower and upper end; both NaN for an empty distribution.
    """
    values = np.asarray(distribution, dtype=np.float64)
    if len(values) == 0:
        return math.nan, math.nan
    low, high = np.quantile(values, [(1 - confidence) / 2, (1 + confidence) / 2])
    return float(low), float(high)


def _picks(clusters: int, rng: np.random.Generator, resamples: int) -> NDArray[np.int64]:
    """Clusters drawn with replacement, (resamples, clusters)."""
    if clusters == 1:
        return np.zeros((resamples, 1), dtype=np.int64)
    return rng.integers(clusters, size=(resamples, clusters))
