import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.statistics import holm


def test_holm_by_hand() -> None:
    assert holm([0.01, 0.04, 0.03, 0.005]).tolist() == pytest.approx([0.03, 0.06, 0.06, 0.02])


def test_nan_is_no_test() -> None:
    assert holm([math.nan, 0.02, 0.03]).tolist()[1:] == pytest.approx([0.04, 0.04])
    assert np.isnan(holm([math.nan, math.nan])).all()
    assert holm([]).tolist() == []


@given(st.lists(st.floats(0, 1), min_size=1, max_size=10), st.randoms(use_true_random=False))
def test_holm_bounds_order_and_permutation(p: list[float], random: object) -> None:
    values = np.array(p)
    adjusted = holm(values)
    assert np.all(adjusted >= values)
    assert np.all(adjusted <= np.minimum(1.0, values * len(values)))
    order = np.argsort(values, kind="stable")
    assert np.all(np.diff(adjusted[order]) >= 0)
    assert holm(values[::-1]).tolist() == adjusted[::-1].tolist()


def test_holm_keeps_the_family_wise_error() -> None:
    rng = np.random.default_rng(0)
    wrong = np.mean([holm(rng.random(6)).min() < 0.05 for _ in range(4000)])
    assert wrong == pytest.approx(0.05, abs=0.011)
