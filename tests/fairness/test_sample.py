"""Which trials are run again."""

from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.fairness.sample import spread
from pytest_lpb.run.plan import TrialKey


def trials(count: int) -> list[TrialKey]:
    return [TrialKey("x", "pd", seed) for seed in range(count)]


def test_spread() -> None:
    assert [trial.seed for trial in spread(trials(10), 3)] == [3, 6, 9]
    assert [trial.seed for trial in spread(trials(3), 3)] == [0, 1, 2]
    assert [trial.seed for trial in spread(trials(2), 5)] == [0, 1]
    assert spread([], 3) == []


@given(st.integers(1, 60), st.integers(1, 80))
def test_spread_is_even(count: int, wanted: int) -> None:
    places = [trial.seed for trial in spread(trials(count), wanted)]
    assert len(places) == min(count, wanted) == len(set(places))
    assert places[-1] == count - 1
    gaps = {after - before for before, after in zip([-1, *places], places, strict=False)}
    assert max(gaps) - min(gaps) <= 1
