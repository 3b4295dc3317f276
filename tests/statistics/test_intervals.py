import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from pytest_lpb.statistics import effective_size, newcombe_paired_interval, wilson_interval


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_wilson_repeats_the_published_examples(successes: int, trials: int, low: float, high: float) -> None:
    """Newcombe 1998, "Two-sided confidence intervals for the single proportion", table I, method 3."""
    assert wilson_interval(successes, trials) == pytest.approx((low, high), abs=5e-5)


@given(st.integers(1, 500), st.floats(0, 1), st.sampled_from([0.8, 0.95, 0.99]))
def test_wilson_equals_scipy_for_whole_numbers(trials: int, share: float, confidence: float) -> None:
    successes = round(share * trials)
    interval = stats.binomtest(successes, trials).proportion_ci(confidence, method="wilson")
    expected = (float(interval.low), float(interval.high))
    assert wilson_interval(successes, trials, confidence) == pytest.approx(expected, abs=1e-12)


@given(st.floats(0, 1), st.floats(0.5, 1000))
def test_wilson_takes_fractions_and_holds_the_rate(rate: float, trials: float) -> None:
    low, high = wilson_interval(rate * trials, trials)
    assert 0 <= low <= rate + 1e-12
    assert rate - 1e-12 <= high <= 1
    mirrored = wilson_interval(trials - rate * trials, trials)
    assert mirrored == pytest.approx((1 - high, 1 - low), abs=1e-9)


def test_wilson_ends_are_exact_when_all_or_none_succeed() -> None:
    assert wilson_interval(0, 7)[0] == 0.0
    assert wilson_interval(7, 7)[1] == 1.0


def test_wilson_without_problems_is_unknown() -> None:
    assert all(map(math.isnan, wilson_interval(0, 0)))
    assert all(map(math.isnan, wilson_interval(math.nan, 3)))


@pytest.mark.parametrize(
    ("successes", "trials", "confidence"), [(-0.1, 3, 0.95), (3.1, 3, 0.95), (1, 3, 1.0), (1, 3, 0.0)]
)
def test_wilson_refuses_impossible_numbers(successes: float, trials: float, confidence: float) -> None:
    with pytest.raises(ValueError, match="outside"):
        wilson_interval(successes, trials, confidence)


@pytest.mark.parametrize("trials", [10, 30, 100])
def test_wilson_covers_the_rate_nominally_on_average(trials: int) -> None:
    """The coverage over all rates is summed exactly from the binomial distribution, not simulated."""
    intervals = np.array([wilson_interval(k, trials) for k in range(trials + 1)])
    rates = np.linspace(0.005, 0.995, 199)
    inside = (intervals[:, 0] <= rates[:, None]) & (rates[:, None] <= intervals[:, 1])
    probability = stats.binom.pmf(np.arange(trials + 1), trials, rates[:, None])
    coverage = np.sum(inside * probability, axis=1)
    assert coverage.mean() == pytest.approx(0.95, abs=0.01)
    assert coverage.min() > 0.83


def test_effective_size_of_equal_scenarios_is_their_number_of_problems() -> None:
    assert effective_size([10, 10, 10]) == pytest.approx(30)
    assert effective_size([49]) == 49.0


def test_effective_size_by_hand_and_its_bounds() -> None:
    assert effective_size([1, 100]) == pytest.approx(4 / 1.01)
    assert math.isnan(effective_size([]))
    assert math.isnan(effective_size([5, 0]))


def test_effective_size_gives_the_variance_of_a_mean_over_scenarios() -> None:
    rng = np.random.default_rng(1)
    sizes, rate = [4, 20, 50], 0.6
    means = np.mean([rng.binomial(size, rate, 100_000) / size for size in sizes], axis=0)
    assert means.var() == pytest.approx(rate * (1 - rate) / effective_size(sizes), rel=0.03)


def _pairs(both: int, only_a: int, only_b: int, neither: int) -> tuple[np.ndarray, np.ndarray]:
    a = np.repeat([1.0, 1.0, 0.0, 0.0], [both, only_a, only_b, neither])
    b = np.repeat([1.0, 0.0, 1.0, 0.0], [both, only_a, only_b, neither])
    return a, b


def test_newcombe_repeats_the_published_example() -> None:
    """Newcombe 1998, "based on paired data", 36, 12, 2, 0 by method 10: 0.0569 to 0.3404."""
    a, b = _pairs(36, 12, 2, 0)
    assert newcombe_paired_interval(b, a) == pytest.approx((0.0569, 0.3404), abs=5e-5)


@given(*[st.integers(0, 30)] * 4)
def test_newcombe_holds_the_difference_and_mirrors(both: int, only_a: int, only_b: int, neither: int) -> None:
    a, b = _pairs(both, only_a, only_b, neither)
    low, high = newcombe_paired_interval(a, b)
    if len(a) == 0:
        assert math.isnan(low)
        assert math.isnan(high)
        return
    assert -1 <= low <= b.mean() - a.mean() + 1e-12
    assert b.mean() - a.mean() - 1e-12 <= high <= 1
    assert low < high
    assert newcombe_paired_interval(b, a) == pytest.approx((-high, -low), abs=1e-12)


def test_newcombe_covers_the_difference_nominally() -> None:
    rng = np.random.default_rng(2)
    truth, covered, studies = 0.6 - 0.7, 0, 400
    for _ in range(studies):
        difficulty = rng.random(40)
        a = np.where(rng.random(40) < 0.5, difficulty, rng.random(40)) < 0.7
        b = np.where(rng.random(40) < 0.5, difficulty, rng.random(40)) < 0.6
        low, high = newcombe_paired_interval(a, b)
        covered += low <= truth <= high
    assert 0.92 <= covered / studies <= 0.985
