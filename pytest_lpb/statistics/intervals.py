"""Confidence intervals of success rates and of the difference of two paired success rates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri


def wilson_interval(successes: float, trials: float, confidence: float = 0.95) -> tuple[float, float]:
    """Score interval of a success rate (Wilson 1927); SciPy's `proportion_ci` takes whole numbers only.

    Neither number has to be whole: repeats of one problem are averaged, so a problem may be half solved, and
    `trials` is the number of distinct problems (or an `effective_size`).

    Returns:
        The lower and upper end, within [0, 1]; both NaN when `trials` is 0 or an argument is NaN.

    Raises:
        ValueError: `successes` is outside [0, trials] or `confidence` outside (0, 1).
    """
    _check_confidence(confidence)
    if math.isnan(successes) or math.isnan(trials) or trials == 0:
        return math.nan, math.nan
    if not 0 <= successes <= trials:
        raise ValueError(f"successes: {successes} is outside [0, {trials}]")
    z2 = float(ndtri((1 + confidence) / 2)) ** 2
    rate = successes / trials
    centre = (rate + z2 / (2 * trials)) / (1 + z2 / trials)
    half = math.sqrt(z2 * (rate * (1 - rate) / trials + z2 / (4 * trials**2))) / (1 + z2 / trials)
    low = 0.0 if successes == 0 else max(0.0, centre - half)
    high = 1.0 if successes == trials else min(1.0, centre + half)
    return low, high


def effective_size(sizes: Sequence[float]) -> float:
    """Effective number of problems behind a mean over strata of `sizes` problems each (Kish 1965).

    A mean over S strata weighs each of the n_s problems of stratum s by 1 / (S n_s), and Kish's
    (sum w)^2 / sum w^2 is then S^2 / sum(1 / n_s). Equal strata give the number of problems itself; a stratum
    of one problem pulls it down. It depends on the design alone: finite even when every rate is 0 or 1.

    Returns:
        The effective size; NaN without strata or when one is empty.
    """
    if len(sizes) == 0 or min(sizes) <= 0:
        return math.nan
    if len(sizes) == 1:
        return float(sizes[0])
    return len(sizes) ** 2 / math.fsum(1 / size for size in sizes)


@dataclass(frozen=True)
class PairedRates:
    """Two success rates on the same problems, and how far they go together."""

    pairs: int
    rate_a: float
    rate_b: float
    covariance: float
    spread: float  # product of both standard deviations

    @classmethod
    def of(cls, a: ArrayLike, b: ArrayLike) -> PairedRates:
        """Rates of a and b, (n,) each, n >= 1: 0 or 1 for each problem, or between for averaged repeats; no NaN."""
        x, y = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
        covariance = float(np.mean((x - x.mean()) * (y - y.mean())))
        return cls(len(x), float(x.mean()), float(y.mean()), covariance, float(x.std() * y.std()))

    def interval(self, confidence: float = 0.95, pairs: int | None = None) -> tuple[float, float]:
        """Newcombe's interval of rate_b - rate_a; with `pairs`, as it would be with so many like these.

        Wilson's intervals of both rates are combined by "square and add" with the correlation of the pairs: the
        interval never has zero width, as a bootstrap of few discordant pairs can have.
        """
        n = self.pairs if pairs is None else pairs
        low_a, high_a = wilson_interval(self.rate_a * n, n, confidence)
        low_b, high_b = wilson_interval(self.rate_b * n, n, confidence)
        phi = self._correlation(n)
        difference = self.rate_b - self.rate_a
        below = _square_and_add(self.rate_b - low_b, high_a - self.rate_a, phi)
        above = _square_and_add(high_b - self.rate_b, self.rate_a - low_a, phi)
        return max(-1.0, difference - below), min(1.0, difference + above)

    def _correlation(self, n: int) -> float:
        """Phi of the pairs, positive ones corrected for continuity; 0 when a rate is 0 or 1."""
        if self.spread == 0:
            return 0.0
        covariance = self.covariance
        if covariance > 0:
            covariance = max(covariance - 1 / (2 * n), 0.0)
        return covariance / self.spread


def newcombe_paired_interval(a: ArrayLike, b: ArrayLike, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of the difference of two paired success rates, mean(b) - mean(a) (Newcombe 1998, method 10).

    Args:
        a: success of planner a on each problem, (n,), 0 or 1, or between for averaged repeats; no NaN.
        b: the same of planner b, (n,).
        confidence: of the two-sided interval.

    Returns:
        The lower and upper end, within [-1, 1]; both NaN without pairs.
    """
    if len(np.asarray(a)) == 0:
        return math.nan, math.nan
    return PairedRates.of(a, b).interval(confidence)


def _square_and_add(first: float, second: float, phi: float) -> float:
    return math.sqrt(max(0.0, first**2 - 2 * phi * first * second + second**2))


def _check_confidence(confidence: float) -> None:
    if not 0 < confidence < 1:
        raise ValueError(f"confidence: {confidence} is outside (0, 1)")
