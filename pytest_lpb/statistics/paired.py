"""Tests and effect sizes of paired samples: planner a and planner b on the same problems."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

FloatArray = NDArray[np.float64]

EXACT_PAIRS = 50
"""Up to so many nonzero differences the signed-rank test is exact (SciPy's own limit without ties)."""

IDENTICAL = 1e-9
"""Two values that differ by no more than this share of the larger one are equal but for rounding."""


def paired_difference(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Differences b - a, (n,), of two samples (n,) of the same problems; rounding errors become 0."""
    x, y = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    difference = y - x
    difference[np.abs(difference) <= IDENTICAL * np.maximum(np.abs(x), np.abs(y))] = 0.0
    return difference


def discordant_counts(difference: ArrayLike) -> tuple[int, int]:
    """How many differences (n,) of successes are below and above 0: a, or b, solved that more often."""
    d = np.asarray(difference, dtype=np.float64)
    return int(np.sum(d < 0)), int(np.sum(d > 0))


def mcnemar_p(only_a: int, only_b: int) -> float:
    """Exact two-sided p of McNemar's test (McNemar 1947) from its discordant counts.

    Under the null hypothesis each discordant problem is as likely to be a's as b's: a binomial test with 1/2.
    With repeats averaged, discordant means "solved more often": the exact sign test over problems.

    Returns:
        p; 1.0 without discordant problems.
    """
    discordant = only_a + only_b
    if discordant == 0:
        return 1.0
    return float(stats.binomtest(only_a, discordant, 0.5).pvalue)


def wilcoxon_p(difference: ArrayLike) -> float:
    """Two-sided p of the signed-rank test that differences are symmetric about 0 (Wilcoxon 1945).

    Zeros are dropped (Wilcoxon's own rule) and NaN is ignored. Up to `EXACT_PAIRS` nonzero differences the
    null distribution is counted exactly, ties included (SciPy permutes 2^n signs for that: a second for 13
    tied pairs, and none beyond); above, SciPy's normal approximation, corrected for ties.

    Args:
        difference: (n,), in one unit.

    Returns:
        p; 1.0 when every difference is 0, NaN when there is none at all.
    """
    d = np.asarray(difference, dtype=np.float64)
    d = d[~np.isnan(d)]
    if len(d) == 0:
        return math.nan
    d = d[d != 0]
    if len(d) == 0:
        return 1.0
    if len(d) > EXACT_PAIRS:
        return float(stats.wilcoxon(d).pvalue)
    return _exact_signed_rank_p(d)


def _exact_signed_rank_p(d: FloatArray) -> float:
    """Exact p: the distribution of the sum of positive ranks, one rank after the other, in half ranks."""
    ranks = np.rint(2 * stats.rankdata(np.abs(d))).astype(np.int64)
    probability = np.zeros(int(ranks.sum()) + 1)
    probability[0] = 1.0
    for rank in ranks.tolist():
        shifted = np.zeros_like(probability)
        shifted[rank:] = probability[:-rank]
        probability = (probability + shifted) / 2
    positive = int(ranks[d > 0].sum())
    statistic = min(positive, int(ranks.sum()) - positive)
    return min(1.0, 2 * float(probability[: statistic + 1].sum()))


def improvement_probability(difference: ArrayLike, direction: str) -> float:
    """Share of problems on which b is better than a, ties counted half (Agarwal et al. 2021, here of pairs).

    Args:
        difference: b - a on each problem, (n,); NaN is ignored.
        direction: which values are better, "lower" or "higher".

    Returns:
        A number in [0, 1], 0.5 for equal planners; NaN without differences.

    Raises:
        ValueError: `direction` is neither.
    """
    if direction not in ("lower", "higher"):
        raise ValueError(f"direction: {direction!r} is not 'lower' or 'higher'")
    d = np.asarray(difference, dtype=np.float64)
    d = d[~np.isnan(d)]
    if len(d) == 0:
        return math.nan
    better = d < 0 if direction == "lower" else d > 0
    return float((np.sum(better) + np.sum(d == 0) / 2) / len(d))


def ratio(a: float, b: float) -> float:
    """b / a of two medians; NaN where it says nothing: a is 0, either is NaN, or they differ in sign."""
    if math.isnan(a) or math.isnan(b) or a == 0 or a * b < 0:
        return math.nan
    return b / a
