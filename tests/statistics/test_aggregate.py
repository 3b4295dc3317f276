import math

import numpy as np
import pytest

from pytest_lpb.statistics import interquartile_mean, performance_profile, stratified_interval


def test_interquartile_mean_leaves_out_both_quarters() -> None:
    assert interquartile_mean([1, 2, 3, 4, 5, 6, 7, 1e9]) == pytest.approx(4.5)
    assert interquartile_mean([math.nan, 3.0]) == 3.0
    assert math.isnan(interquartile_mean([math.nan]))


def test_stratified_interval_keeps_the_strata() -> None:
    rng = np.random.default_rng(0)
    assert stratified_interval([np.zeros(4), np.ones(4)], np.mean, rng) == (0.5, 0.5)
    assert all(map(math.isnan, stratified_interval([[math.nan]], np.mean, rng)))


def test_stratified_interval_covers_the_interquartile_mean() -> None:
    rng = np.random.default_rng(1)
    covered = 0
    for _ in range(60):
        strata = [rng.normal(size=20), rng.normal(size=30)]
        low, high = stratified_interval(strata, interquartile_mean, rng, resamples=200)
        covered += low <= 0 <= high
    assert covered >= 51


def test_performance_profile_counts_the_unsolved() -> None:
    shares = performance_profile([1.0, 2.0, math.nan, 2.0], [0.5, 1.0, 2.0, 9.0])
    assert shares.tolist() == [0.0, 0.25, 0.75, 0.75]
    assert np.isnan(performance_profile([], [1.0])).all()
