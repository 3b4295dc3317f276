"""Losses and their bounds: hand-computed values, coverage, and what one flipped problem may do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from pytest_lpb.statistics import (
    decided,
    deciding_pairs,
    loss_of_means,
    loss_of_rates,
    newcombe_paired_interval,
    wilcoxon_p,
)
from pytest_lpb.statistics.loss import MeanLoss


def rates(pairs: int, lost: int, gained: int = 0, unsolved: int = 0) -> tuple[list[float], list[float]]:
    """Success of a baseline and a planner on so many problems."""
    both = pairs - lost - gained - unsolved
    return (
        [1.0] * (both + lost) + [0.0] * (gained + unsolved),
        [1.0] * both + [0.0] * lost + [1.0] * gained + [0.0] * unsolved,
    )


def test_a_mean_by_hand() -> None:
    loss = loss_of_means([1, 2, 3, 4], [2, 2, 5, 5], "lower", relative=False)
    # Losses 1, 0, 2, 1: mean 1, variance 2/3; t(3) at 95 % is 2.3534.
    assert (loss.pairs, loss.estimate) == (4, 1.0)
    assert loss.deviation == pytest.approx(math.sqrt(2 / 3))
    assert loss.bounds() == pytest.approx((1 - 2.35336 * math.sqrt(1 / 6), 1 + 2.35336 * math.sqrt(1 / 6)), abs=1e-5)


def test_bounds_of_a_mean_are_those_of_scipys_one_sided_t_tests() -> None:
    rng = np.random.default_rng(0)
    a = rng.normal(size=30)
    b = a + rng.normal(0.1, 0.5, 30)
    low, high = loss_of_means(a, b, "lower", relative=False).bounds()
    greater, less = (stats.ttest_rel(b, a, alternative=side) for side in ("greater", "less"))
    assert low == pytest.approx(greater.confidence_interval(0.95).low)
    assert high == pytest.approx(less.confidence_interval(0.95).high)


def test_bounds_of_a_mean_repeat_students_own_example() -> None:
    """Two soporifics, hours of sleep gained by ten patients (Student 1908): 1.58 h more, standard deviation 1.23 h."""
    first = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
    second = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]
    loss = loss_of_means(first, second, "lower", relative=False)
    assert loss.estimate == pytest.approx(1.58)
    assert loss.deviation == pytest.approx(1.23, abs=5e-4)
    assert loss.bounds() == pytest.approx((0.8670, 2.2930), abs=5e-5)
    # All nine differences that are not zero have one sign: 2 of 2^9 assignments are as far.
    assert wilcoxon_p(np.subtract(second, first)) == 2 / 2**9


def test_higher_is_better_turns_the_sign() -> None:
    assert loss_of_means([0.3, 0.5], [0.2, 0.2], "higher", relative=False).estimate == pytest.approx(0.2)


@pytest.mark.parametrize(("sign", "direction"), [(1.0, "lower"), (-1.0, "higher")])
def test_a_relative_loss_by_hand(sign: float, direction: str) -> None:
    a, b = sign * np.array([2.0, 4.0, 6.0]), sign * np.array([2.0, 6.0, 7.0])
    loss = loss_of_means(a, b, direction, relative=True)
    # 3 lost of 12. Residuals d - a / 4: -1/2, 1, -1/2; over the mean 4: standard deviation sqrt(0.75) / 4.
    assert loss.estimate == pytest.approx(0.25)
    assert loss.deviation == pytest.approx(math.sqrt(0.75) / 4)


def test_the_same_share_lost_everywhere_is_known_exactly() -> None:
    a = np.array([1.0, 5.0, 20.0, 3.0])
    loss = loss_of_means(a, 1.1 * a, "lower", relative=True)
    assert loss.bounds() == pytest.approx((0.1, 0.1))
    assert decided(loss, 0.1) is False
    assert decided(loss, 0.09) is True


def test_there_is_no_share_of_nothing() -> None:
    with pytest.raises(ZeroDivisionError, match="mean is 0"):
        loss_of_means([-1.0, 1.0], [0.0, 1.0], "lower", relative=True)
    assert loss_of_means([0.0, 0.0], [0.0, 0.0], "lower", relative=True).bounds() == (0.0, 0.0)


def test_relative_bounds_cover_the_true_loss_nominally() -> None:
    rng = np.random.default_rng(1)
    below = above = 0
    for _ in range(2000):
        a = rng.lognormal(1.0, 0.4, 40)
        b = a * rng.normal(1.08, 0.2, 40)
        low, high = loss_of_means(a, b, "lower", relative=True).bounds()
        below += low > 0.08
        above += high < 0.08
    assert 0.03 <= below / 2000 <= 0.07
    assert 0.03 <= above / 2000 <= 0.07


def test_bounds_of_a_rate_are_newcombes() -> None:
    a, b = rates(100, lost=12, gained=3, unsolved=5)
    loss = loss_of_rates(a, b)
    low, high = newcombe_paired_interval(a, b, 0.9)
    assert loss.estimate == pytest.approx(0.09)
    assert loss.bounds() == (-high, -low)


def test_nothing_changed_is_no_loss() -> None:
    a, b = rates(20, lost=0, unsolved=7)
    assert loss_of_rates(a, b).bounds() == (0.0, 0.0)
    assert decided(loss_of_rates(a, b), 0.0) is False


@pytest.mark.parametrize("pairs", [20, 21, 50, 200, 1000])
@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.9])
def test_one_flipped_problem_closes_no_gate(pairs: int, share: float) -> None:
    flipped = loss_of_rates(*rates(pairs, lost=1, unsolved=int(share * pairs)))
    assert flipped.estimate == pytest.approx(1 / pairs)
    assert decided(flipped, 0.0) is not True


@given(st.integers(20, 300), st.floats(1e-6, 1e6))
def test_one_worse_problem_closes_no_gate(pairs: int, worse: float) -> None:
    b = np.ones(pairs)
    b[0] += worse
    for relative in (False, True):
        assert decided(loss_of_means(np.ones(pairs), b, "lower", relative=relative), 0.0) is not True


def test_rates_that_lose_exactly_the_margin_are_rarely_called_regressed_or_fine() -> None:
    """True loss 5 %, margin 5 %: each wrong verdict in about 5 % of studies at most."""
    rng = np.random.default_rng(2)
    verdicts = []
    for _ in range(1500):
        a = rng.random(100) < 0.9
        b = np.where(a, rng.random(100) < 0.9, rng.random(100) < 0.4)  # loses 9 %, gains 4 %
        verdicts.append(decided(loss_of_rates(a, b), 0.05))
    assert verdicts.count(True) / 1500 <= 0.07
    assert verdicts.count(False) / 1500 <= 0.07


def test_the_number_of_pairs_that_decides_does() -> None:
    loss = MeanLoss(pairs=30, estimate=0.02, deviation=0.2)
    assert decided(loss, 0.05) is None
    needed = deciding_pairs(loss, 0.05, 20)
    assert needed is not None
    assert decided(loss, 0.05, needed) is False
    assert decided(loss, 0.05, needed - 1) is None
    assert needed == pytest.approx((1.645 * 0.2 / 0.03) ** 2, rel=0.03)
    worse = MeanLoss(pairs=30, estimate=0.08, deviation=0.2)
    assert deciding_pairs(worse, 0.05, 20) == needed  # as far from the margin, on the other side


def test_pairs_of_rates_that_decide() -> None:
    loss = loss_of_rates(*rates(50, lost=1))
    needed = deciding_pairs(loss, 0.05, 20)
    assert needed is not None
    assert needed > 50
    assert decided(loss, 0.05, needed) is False
    assert decided(loss, 0.05, needed - 1) is None


def test_no_number_of_pairs_decides_at_the_margin() -> None:
    assert deciding_pairs(MeanLoss(pairs=30, estimate=0.05, deviation=0.2), 0.05, 20) is None
    assert deciding_pairs(MeanLoss(pairs=1, estimate=0.5, deviation=math.nan), 0.05, 20) is None
    assert MeanLoss(1, 0.5, math.nan).bounds() == (-math.inf, math.inf)
