"""Performance profiles, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.statistics import performance_ratios, pointwise_band, shares_within

COSTS = st.lists(st.tuples(*[st.floats(0.01, 100) | st.just(math.inf)] * 3), min_size=1, max_size=8)


def test_ratios_by_hand() -> None:
    costs = [[2.0, 4.0, math.nan], [3.0, 1.0, 1.0], [math.inf, math.inf, math.nan], [0.0, 0.0, 5.0]]
    ratios = performance_ratios(costs)
    inf = math.inf
    assert ratios.tolist() == [[1.0, 2.0, inf], [3.0, 1.0, 1.0], [inf, inf, inf], [1.0, 1.0, inf]]
    # Solver 0 is best, or as good, on 2 of 4 problems; within a factor of 3 on 3; of the last nobody is within any.
    assert shares_within([ratios[:, 0]], [0.5, 1.0, 2.9, 3.0, 1e9]).tolist() == [0.0, 0.5, 0.5, 0.75, 0.75]


def test_negative_costs_have_no_ratio() -> None:
    with pytest.raises(ValueError, match=r"-1\.0 is negative"):
        performance_ratios([[1.0, -1.0]])
    assert performance_ratios(np.empty((0, 2))).shape == (0, 2)


@given(COSTS, st.floats(0.1, 10))
def test_ratios_do_not_know_the_unit(costs: list[tuple[float, ...]], factor: float) -> None:
    ratios = performance_ratios(costs)
    assert performance_ratios(factor * np.array(costs)) == pytest.approx(ratios, rel=1e-9)
    assert np.all(ratios >= 1.0)
    solved = np.isfinite(costs).any(axis=1)
    assert np.all(ratios.min(axis=1)[solved] == 1.0)


def test_strata_weigh_the_same() -> None:
    # One of one, and one of four: (1 + 1/4) / 2.
    assert shares_within([[1.0], [1.0, 2.0, 3.0, math.inf]], [1.0]).tolist() == [0.625]
    assert math.isnan(shares_within([], [1.0])[0])


@given(st.lists(st.lists(st.floats(0, 10), min_size=1, max_size=6), min_size=1, max_size=3))
def test_shares_only_rise(strata: list[list[float]]) -> None:
    shares = shares_within(strata, np.linspace(-1, 11, 25))
    assert np.all(np.diff(shares) >= 0)
    assert (shares[0], shares[-1]) == (0.0, pytest.approx(1.0))


def test_the_band_is_that_of_resampling() -> None:
    rng = np.random.default_rng(0)
    strata = [rng.exponential(size=12), rng.exponential(2.0, size=12)]
    bounds = [0.3, 1.0, 2.5]
    drawn = [shares_within([values[rng.integers(12, size=12)] for values in strata], bounds) for _ in range(4000)]
    expected = np.quantile(drawn, [0.025, 0.975], axis=0)
    low, high = pointwise_band(strata, bounds, rng, 20_000)
    assert low == pytest.approx(expected[0], abs=0.045)
    assert high == pytest.approx(expected[1], abs=0.045)


def test_where_all_agree_the_band_has_no_width() -> None:
    low, high = pointwise_band([[1.0, 1.0], [1.0]], [0.5, 1.0], np.random.default_rng(0))
    assert low == pytest.approx([0.0, 1.0])
    assert high == pytest.approx([0.0, 1.0])
    assert np.isnan(pointwise_band([], [1.0], np.random.default_rng(0))[0]).all()
