import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from pytest_lpb.statistics import (
    discordant_counts,
    improvement_probability,
    mcnemar_p,
    paired_difference,
    ratio,
    wilcoxon_p,
)

INTEGERS = st.lists(st.integers(-5, 5), max_size=60)


def test_mcnemar_by_hand() -> None:
    assert mcnemar_p(1, 5) == pytest.approx(2 * (1 + 6) / 2**6)
    assert mcnemar_p(0, 6) == pytest.approx(2 / 2**6)
    assert mcnemar_p(4, 4) == 1.0
    assert mcnemar_p(0, 0) == 1.0


@given(st.integers(0, 40), st.integers(0, 40))
def test_mcnemar_does_not_know_which_planner_is_which(only_a: int, only_b: int) -> None:
    assert mcnemar_p(only_a, only_b) == pytest.approx(mcnemar_p(only_b, only_a))


def test_discordant_counts_ignore_ties_and_nan() -> None:
    assert discordant_counts([-1, -0.5, 0, math.nan, 1]) == (2, 1)


def test_wilcoxon_repeats_the_example_of_scipy() -> None:
    """Darwin's maize, the example of scipy.stats.wilcoxon."""
    maize = [6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75]
    assert wilcoxon_p(maize) == pytest.approx(0.041259765625, abs=1e-12)


@given(st.integers(1, 50), st.integers(0, 2**32 - 1))
def test_wilcoxon_equals_the_exact_test_of_scipy_without_ties(size: int, seed: int) -> None:
    difference = np.random.default_rng(seed).normal(0.2, size=size)
    assert wilcoxon_p(difference) == pytest.approx(float(stats.wilcoxon(difference, method="exact").pvalue))


@settings(max_examples=15, deadline=None)
@given(st.lists(st.integers(-3, 3).filter(bool), min_size=2, max_size=7))
def test_wilcoxon_with_ties_equals_scipys_permutation_of_signs(difference: list[int]) -> None:
    values = np.array(difference, dtype=float)
    assert wilcoxon_p(values) == pytest.approx(float(stats.wilcoxon(values, method=stats.PermutationMethod()).pvalue))


def test_wilcoxon_of_many_pairs_is_scipys_approximation_and_near_the_exact_test() -> None:
    difference = np.random.default_rng(3).normal(0.3, size=51)
    assert wilcoxon_p(difference) == pytest.approx(float(stats.wilcoxon(difference).pvalue))
    assert wilcoxon_p(difference) == pytest.approx(wilcoxon_p(difference[:50]), abs=0.05)


def test_wilcoxon_of_nothing_and_of_zeros() -> None:
    assert math.isnan(wilcoxon_p([]))
    assert math.isnan(wilcoxon_p([math.nan, math.nan]))
    assert wilcoxon_p([0.0, 0.0, math.nan]) == 1.0
    assert wilcoxon_p([0.3, 0.0]) == 1.0
    assert wilcoxon_p([1.0] * 6) == pytest.approx(2 / 2**6)


@given(INTEGERS)
def test_wilcoxon_is_symmetric_and_ignores_order_and_nan(difference: list[int]) -> None:
    values = np.array(difference, dtype=float)
    p = wilcoxon_p(values)
    assert wilcoxon_p(-values) == pytest.approx(p, nan_ok=True)
    assert wilcoxon_p(np.append(values[::-1], math.nan)) == pytest.approx(p, nan_ok=True)
    assert wilcoxon_p(values * 1000) == pytest.approx(p, nan_ok=True)


def test_improvement_probability_by_hand() -> None:
    difference = [-1, -2, 0, 3, math.nan]
    assert improvement_probability(difference, "lower") == pytest.approx((2 + 0.5) / 4)
    assert improvement_probability(difference, "higher") == pytest.approx((1 + 0.5) / 4)
    assert math.isnan(improvement_probability([math.nan], "lower"))
    with pytest.raises(ValueError, match="'none'"):
        improvement_probability(difference, "none")


@given(INTEGERS.filter(len))
def test_improvement_probabilities_of_both_sides_add_to_one(difference: list[int]) -> None:
    values = np.array(difference, dtype=float)
    total = improvement_probability(values, "lower") + improvement_probability(-values, "lower")
    assert total == pytest.approx(1)


def test_rounding_is_no_difference() -> None:
    difference = paired_difference([0.1 + 0.2, 1.0, 1e300, 0.0, math.nan], [0.3, 1.1, 1e300, 1e-12, 1.0])
    assert difference[[0, 2]].tolist() == [0.0, 0.0]
    assert difference[1] == pytest.approx(0.1)
    assert difference[3] == 1e-12
    assert math.isnan(difference[4])


def test_ratio_is_unknown_where_it_says_nothing() -> None:
    assert ratio(2.0, 3.0) == 1.5
    assert ratio(-2.0, -3.0) == 1.5
    assert ratio(2.0, 0.0) == 0.0
    assert all(math.isnan(ratio(a, b)) for a, b in [(0.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (1.0, math.nan)])
