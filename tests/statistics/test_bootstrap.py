import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from scipy import stats

from pytest_lpb.statistics import bootstrap_means, bootstrap_medians, percentile_interval

Bootstrap = Callable[[Sequence[np.ndarray], np.random.Generator, int], np.ndarray]


def _rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("size", [1, 3, 9])
def test_medians_follow_their_exact_distribution(size: int) -> None:
    """Efron 1979: the median of an odd resample is at most x_(k) with P(Bin(n, k / n) >= (n + 1) / 2)."""
    medians = bootstrap_medians([np.arange(size, dtype=float)], _rng(), 100_000)
    at_most = np.asarray(stats.binom.sf((size + 1) // 2 - 1, size, np.arange(1, size + 1) / size))
    observed = [np.mean(medians <= k) for k in range(size)]
    assert observed == pytest.approx(at_most.tolist(), abs=0.006)


@pytest.mark.parametrize("size", [2, 4, 7, 10, 25])
def test_medians_are_those_of_resampling(size: int) -> None:
    values = _rng(1).normal(size=size)
    resampled = np.median(values[_rng(2).integers(size, size=(100_000, size))], axis=1)
    medians = bootstrap_medians([values], _rng(3), 100_000)
    points = np.unique(resampled)[:: max(1, len(np.unique(resampled)) // 20)]
    assert [np.mean(medians <= x + 1e-12) for x in points] == pytest.approx(
        [np.mean(resampled <= x + 1e-12) for x in points], abs=0.01
    )


def test_interval_is_scipys_percentile_interval() -> None:
    values = _rng(4).lognormal(size=40)
    expected = stats.bootstrap(
        (values,), np.median, n_resamples=20_000, method="percentile", vectorized=True, rng=_rng(5)
    ).confidence_interval
    interval = percentile_interval(bootstrap_medians([values], _rng(6), 20_000))
    assert interval == pytest.approx((float(expected.low), float(expected.high)), abs=0.03)


def test_means_are_those_of_resampling() -> None:
    values = np.array([0.0, 0.0, 1.0, -1.0, 1.0, 0.5, 0.5, 0.0])
    resampled = values[_rng(7).integers(8, size=(50_000, 8))].mean(axis=1)
    means = bootstrap_means([values], _rng(8), 50_000)
    assert means.mean() == pytest.approx(values.mean(), abs=0.005)
    assert means.std() == pytest.approx(resampled.std(), rel=0.02)


@pytest.mark.parametrize("bootstrap", [bootstrap_medians, bootstrap_means])
def test_clusters_are_resampled_too(bootstrap: Bootstrap) -> None:
    """Two constant clusters: only the choice of clusters varies, 0 (1/4), 1/2 (1/2), 1 (1/4)."""
    drawn = bootstrap([np.zeros(5), np.ones(8)], _rng(9), 40_000)
    values, counts = np.unique(drawn, return_counts=True)
    assert values.tolist() == [0.0, 0.5, 1.0]
    assert (counts / 40_000).tolist() == pytest.approx([0.25, 0.5, 0.25], abs=0.01)


def test_problems_within_clusters_are_resampled_independently() -> None:
    """Two-stage variance: that between cluster medians, plus that within, over the number of clusters."""
    clusters = [_rng(seed).normal(seed, 1, size=15) for seed in range(6)]
    drawn = bootstrap_medians(clusters, _rng(10), 40_000)
    singles = [bootstrap_medians([cluster], _rng(11), 20_000) for cluster in clusters]
    means = np.array([single.mean() for single in singles])
    within = np.mean([single.var() for single in singles])
    assert drawn.var() == pytest.approx((means.var() + within) / 6, rel=0.03)


def test_a_generator_decides_everything_and_shifts_go_through() -> None:
    clusters = [_rng(12).normal(size=n) for n in (4, 9)]
    first = bootstrap_medians(clusters, _rng(13))
    assert np.array_equal(first, bootstrap_medians([c[::-1] for c in clusters], _rng(13)))
    assert bootstrap_medians([c + 5 for c in clusters], _rng(13)) == pytest.approx(first + 5)
    assert bootstrap_medians([c * 1000 for c in clusters], _rng(13)) == pytest.approx(first * 1000)


def test_percentiles_by_hand_and_of_nothing() -> None:
    assert percentile_interval(np.arange(101.0), 0.9) == pytest.approx((5.0, 95.0))
    assert all(map(math.isnan, percentile_interval([])))


@pytest.mark.parametrize("size", [12, 30])
def test_interval_covers_the_median_about_nominally(size: int) -> None:
    """A skewed distribution, 500 studies; the interval of a median is a little wide rather than narrow."""
    rng = _rng(14)
    truth, covered = math.log(2), 0
    for _ in range(500):
        low, high = percentile_interval(bootstrap_medians([rng.exponential(size=size)], rng, 500))
        covered += low <= truth <= high
    assert 0.91 <= covered / 500 <= 0.985
