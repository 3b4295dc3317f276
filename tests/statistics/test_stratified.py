"""Interquartile means and their stratified bootstrap, by hand and against SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from pytest_lpb.statistics import interquartile_interval, interquartile_mean, stratified_weights

NUMBERS = st.floats(-1e3, 1e3, allow_nan=False)
STRATA = st.lists(st.lists(NUMBERS, min_size=1, max_size=8), min_size=1, max_size=4)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([7.0], 7.0),
        ([1.0, 3.0], 2.0),
        ([0.0, 1.0, 3.0, 100.0], 2.0),
        # Nine values: 2.25 are cut at each end, so 5 and 13 count with 3/4: (0.75 * 5 + 7 + 9 + 11 + 0.75 * 13) / 4.5.
        ([1.0, 3.0, 5.0, 7.0, 9.0, 11.0, 13.0, 15.0, 17.0], 9.0),
        # Five: 1.25 are cut; (0.75 * 1 + 2 + 0.75 * 6) / 2.5.
        ([50.0, 6.0, 2.0, 1.0, 0.0], 2.9),
    ],
)
def test_by_hand(values: list[float], expected: float) -> None:
    assert interquartile_mean(values) == pytest.approx(expected)


@pytest.mark.parametrize("size", [4, 8, 20, 400])
def test_it_is_scipys_trimmed_mean(size: int) -> None:
    values = rng(size).lognormal(size=size)
    assert interquartile_mean(values) == pytest.approx(stats.trim_mean(values, 0.25))


def test_a_weight_is_so_many_values() -> None:
    assert interquartile_mean([1.0, 5.0, 2.0], [3.0, 1.0, 4.0]) == pytest.approx(
        stats.trim_mean([1] * 3 + [5] + [2] * 4, 0.25)
    )
    assert math.isnan(interquartile_mean([]))


def test_strata_weigh_the_same() -> None:
    assert stratified_weights([1, 2, 4]).tolist() == pytest.approx([1 / 3, 1 / 6, 1 / 6, *[1 / 12] * 4])
    # Half of the weight is one value of 10, the rest ten values of 0.
    assert interquartile_mean([10.0, *[0.0] * 10], stratified_weights([1, 10])) == pytest.approx(5.0)


@given(st.lists(NUMBERS, min_size=1, max_size=30), st.floats(0.01, 10), NUMBERS)
def test_it_moves_and_scales_with_the_values(values: list[float], scale: float, shift: float) -> None:
    moved = [scale * value + shift for value in values]
    assert interquartile_mean(moved) == pytest.approx(scale * interquartile_mean(values) + shift, rel=1e-9, abs=1e-6)
    assert min(values) - 1e-9 <= interquartile_mean(values) <= max(values) + 1e-9


def test_the_interval_is_that_of_resampling() -> None:
    strata = [rng(1).normal(size=8), rng(2).normal(2.0, size=8), rng(3).normal(size=8)]
    draws = rng(4).integers(8, size=(3, 20_000, 8))
    drawn = np.concatenate([values[picks] for values, picks in zip(strata, draws, strict=True)], axis=1)
    expected = np.quantile(stats.trim_mean(drawn, 0.25, axis=1), [0.025, 0.975])
    assert interquartile_interval(strata, rng(5), 20_000) == pytest.approx(expected.tolist(), abs=0.03)


def test_unequal_strata_are_resampled_each_in_its_size() -> None:
    strata = [rng(1).normal(size=3), rng(2).normal(3.0, size=10)]
    weights = stratified_weights([3, 10])
    resampled = [
        interquartile_mean(
            np.concatenate([values[generator.integers(len(values), size=len(values))] for values in strata]), weights
        )
        for generator in map(rng, range(4000))
    ]
    expected = np.quantile(resampled, [0.025, 0.975])
    assert interquartile_interval(strata, rng(6), 20_000) == pytest.approx(expected.tolist(), abs=0.08)


def test_it_covers_the_true_value() -> None:
    """Of studies with 5 scenarios of 20 problems, 95 % intervals hold the true value nearly that often."""
    means = np.array([0.0, 0.2, -0.1, 0.1, -0.2])
    truth = interquartile_mean(rng(0).normal(size=(400_000, 5)).ravel() + np.tile(means, 400_000))
    held = []
    for study in range(300):
        strata = list((rng(study + 1).normal(size=(20, 5)) + means).T)
        low, high = interquartile_interval(strata, rng(study + 1000), 400)
        held.append(low <= truth <= high)
    assert 0.90 <= np.mean(held) <= 0.98


@given(STRATA, st.integers(0, 5))
def test_negated_values_give_the_negated_interval(strata: list[list[float]], seed: int) -> None:
    low, high = interquartile_interval(strata, rng(seed), 100)
    negated_low, negated_high = interquartile_interval([[-x for x in values] for values in strata], rng(seed), 100)
    assert (negated_low, negated_high) == pytest.approx((-high, -low), abs=1e-9)
    assert low <= high


@given(STRATA, st.randoms(use_true_random=False))
def test_the_order_of_the_values_changes_nothing(strata: list[list[float]], random: object) -> None:
    shuffled = [sorted(values, key=lambda _: random.random()) for values in strata]  # type: ignore[attr-defined]
    assert interquartile_interval(shuffled, rng(), 100) == interquartile_interval(strata, rng(), 100)


def test_equal_values_have_no_width() -> None:
    assert interquartile_interval([[2.0] * 5, [2.0] * 3], rng(), 100) == pytest.approx((2.0, 2.0))
    assert all(map(math.isnan, interquartile_interval([], rng())))
