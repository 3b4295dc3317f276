"""The loss of a planner against its baseline on the same problems, and how well it is known.

A loss is positive where the planner is worse. Its one-sided bounds decide a non-inferiority test: the planner is
no worse when the upper bound is within the margin, and worse when the lower bound is beyond it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtrit

from pytest_lpb.statistics.intervals import PairedRates
from pytest_lpb.statistics.paired import paired_difference

CONFIDENCE = 0.95
"""Of each one-sided bound."""

MAX_PAIRS = 100_000


class Loss(Protocol):
    """A loss that was estimated from pairs."""

    @property
    def pairs(self) -> int:
        """Number of problems both planners have a value on."""

    @property
    def estimate(self) -> float:
        """The loss that was seen."""

    def bounds(self, pairs: int | None = None) -> tuple[float, float]:
        """Lower and upper one-sided bound; with `pairs`, as they would be with so many like these."""


@dataclass(frozen=True)
class MeanLoss:
    """A mean of paired losses, with Student's t bounds (Student 1908)."""

    pairs: int
    estimate: float
    deviation: float  # standard deviation of the losses

    def bounds(self, pairs: int | None = None) -> tuple[float, float]:
        """The mean -+ t s / sqrt(n); without bounds for a single pair."""
        n = self.pairs if pairs is None else pairs
        if n < 2:
            return -math.inf, math.inf
        half = float(stdtrit(n - 1, CONFIDENCE)) * self.deviation / math.sqrt(n)
        return self.estimate - half, self.estimate + half


@dataclass(frozen=True)
class RateLoss:
    """A loss of a success rate, with the bounds of Newcombe 1998, method 10, for paired rates."""

    rates: PairedRates
    identical: bool  # every problem was solved as often as before

    @property
    def pairs(self) -> int:
        """Number of problems."""
        return self.rates.pairs

    @property
    def estimate(self) -> float:
        """How far the rate fell."""
        return self.rates.rate_a - self.rates.rate_b

    def bounds(self, pairs: int | None = None) -> tuple[float, float]:
        """Newcombe's bounds; (0, 0) when nothing changed on any problem."""
        if self.identical:
            return 0.0, 0.0
        low, high = self.rates.interval(2 * CONFIDENCE - 1, pairs)
        return -high, -low


def loss_of_rates(a: ArrayLike, b: ArrayLike) -> RateLoss:
    """Loss of a success rate.

    Args:
        a: success of the baseline on each problem, (n,), n >= 1: 0, 1, or between for averaged repeats.
        b: the same of the planner, (n,).
    """
    return RateLoss(PairedRates.of(a, b), not np.any(paired_difference(a, b)))


def loss_of_means(a: ArrayLike, b: ArrayLike, direction: str, *, relative: bool) -> MeanLoss:
    """Loss of a KPI's mean.

    Relative losses are the ratio of the mean loss to the size of the baseline's mean, R = mean(d) / |mean(a)|; its
    spread is that of d - R a (the linearised ratio estimator, Cochran 1977, section 6.4).

    Args:
        a: values of the baseline on each problem, (n,), n >= 1, no NaN.
        b: values of the planner, (n,).
        direction: which values are better, "lower" or "higher".
        relative: whether the loss is a share of the baseline's mean.

    Raises:
        ZeroDivisionError: a relative loss to a mean of 0, unless there is no difference at all.
    """
    x = np.asarray(a, dtype=np.float64)
    losses = paired_difference(a, b) * (1.0 if direction == "lower" else -1.0)
    estimate = float(losses.mean())
    if relative and np.any(losses):
        mean = float(x.mean())
        if mean == 0:
            raise ZeroDivisionError("the baseline's mean is 0")
        estimate /= abs(mean)
        losses = estimate + (losses - estimate * math.copysign(1.0, mean) * x) / abs(mean)
    deviation = float(losses.std(ddof=1)) if len(losses) > 1 else math.nan
    return MeanLoss(len(losses), estimate, deviation)


def decided(loss: Loss, margin: float, pairs: int | None = None) -> bool | None:
    """Whether the loss exceeds the margin: True or False when a bound says so, None when neither does."""
    low, high = loss.bounds(pairs)
    slack = 1e-9 * max(abs(margin), abs(low), abs(high)) if math.isfinite(high - low) else 0.0
    if high <= margin + slack:
        return False
    return True if low > margin + slack else None


def deciding_pairs(loss: Loss, margin: float, least: int) -> int | None:
    """The number of pairs, at least `least`, that would decide if further ones were like these.

    Returns:
        None when even `MAX_PAIRS` would not: the loss is too near to the margin.
    """
    low, high = max(least, loss.pairs), MAX_PAIRS
    if decided(loss, margin, high) is None:
        return None
    while low < high:
        middle = (low + high) // 2
        if decided(loss, margin, middle) is None:
            low = middle + 1
        else:
            high = middle
    return low
