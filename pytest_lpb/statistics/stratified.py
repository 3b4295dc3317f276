"""Figures over several strata (scenarios) that weigh the same, with bootstrap intervals (Agarwal et al. 2021).

Strata are fixed; within each, its values are drawn with replacement (the stratified bootstrap of Davison & Hinkley
1997, section 3.2). A sample is how often each value was drawn, and half of the samples mirror the ranks of the other
half, as in `bootstrap`: negated values give the negated interval.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pytest_lpb.statistics.bootstrap import RESAMPLES, percentile_interval

FloatArray = NDArray[np.float64]
LOWER, UPPER = 0.25, 0.75  # quartiles between which the mean is taken


def interquartile_mean(values: ArrayLike, weights: ArrayLike | None = None) -> float:
    """Mean of the middle half of the weight; values at the quartiles count with the share that lies between them.

    Equal weights and a number of values divisible by four: SciPy's `trim_mean(values, 0.25)`, which rliable uses. For
    other numbers that rounds the cut down to whole values; here exactly a quarter is cut at each end.

    Args:
        values: (n,), no NaN.
        weights: (n,), positive; None: all the same.

    Returns:
        NaN without values.
    """
    x = np.asarray(values, dtype=np.float64)
    if len(x) == 0:
        return float("nan")
    w = np.ones(len(x)) if weights is None else np.asarray(weights, dtype=np.float64)
    order = np.argsort(x, kind="stable")
    return float(_middle_means(x[order], w[order, None])[0])


def _middle_means(ordered: FloatArray, weights: FloatArray) -> FloatArray:
    """Interquartile means of values in order (n,) under several weights (n, R): (R,)."""
    ends = np.zeros((len(ordered) + 1, weights.shape[1]))
    np.cumsum(weights, axis=0, out=ends[1:])
    ends /= ends[-1].copy()
    np.clip(ends, LOWER, UPPER, out=ends)
    means: FloatArray = ordered @ (ends[1:] - ends[:-1]) / (UPPER - LOWER)
    return means


def stratified_weights(sizes: Sequence[int]) -> FloatArray:
    """Weights of the values of all strata, one after the other, (sum of sizes,): each stratum weighs the same."""
    return np.concatenate([np.full(size, 1.0 / (len(sizes) * size)) for size in sizes])


def interquartile_interval(
    strata: Sequence[ArrayLike], rng: np.random.Generator, resamples: int = RESAMPLES, confidence: float = 0.95
) -> tuple[float, float]:
    """Percentile interval of the interquartile mean over strata, by the stratified bootstrap.

    Args:
        strata: values of each stratum, (n_s,), n_s >= 1, no NaN.
        rng: where all randomness comes from.
        resamples: number of bootstrap samples, even.
        confidence: of the interval.

    Returns:
        The lower and upper end; both NaN without strata.
    """
    if not strata:
        return float("nan"), float("nan")
    return percentile_interval(_middle_means(*resampled_weights(strata, rng, resamples)), confidence)


def resampled_weights(
    strata: Sequence[ArrayLike], rng: np.random.Generator, resamples: int = RESAMPLES
) -> tuple[FloatArray, FloatArray]:
    """Samples of the stratified bootstrap: all values in order (n,), and their weights in each sample (n, R).

    Args:
        strata: values of each stratum, (n_s,), n_s >= 1, no NaN; at least one stratum.
        rng: where all randomness comes from.
        resamples: number R of samples, even.
    """
    pool = np.concatenate([np.sort(np.asarray(values, dtype=np.float64)) for values in strata])
    sizes = [len(np.asarray(values)) for values in strata]
    order = np.argsort(pool, kind="stable")
    return pool[order], _counts(sizes, order, rng, resamples) * stratified_weights(sizes)[order, None]


def _counts(
    sizes: Sequence[int], order: NDArray[np.intp], rng: np.random.Generator, resamples: int
) -> NDArray[np.int64]:
    """How often each value is drawn from its stratum, (n, resamples) in a given order of the n values of all strata.

    The second half mirrors the first: the least value of a stratum there has the count of its greatest here.
    """
    size = np.repeat(sizes, sizes)  # of each value's stratum
    start = np.repeat(np.cumsum(sizes) - sizes, sizes)
    half, n = resamples // 2, len(size)
    drawn = (rng.random((n, half)) * size[:, None]).astype(np.int64) + start[:, None]
    counts = np.bincount((drawn * half + np.arange(half)).ravel(), minlength=half * n).reshape(n, half)
    mirrored = 2 * start + size - 1 - np.arange(n)
    return np.concatenate([counts[order], counts[mirrored[order]]], axis=1)
