"""Trials that a run was to have."""

from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.run.plan import TrialKey, as_ranges, from_ranges, planned, trials_of


def test_ranges_in_short() -> None:
    assert as_ranges([3, 1, 2, 7, 9, 10]) == "1-3,7,9-10"
    assert as_ranges([]) == ""


@given(st.sets(st.integers(0, 60)))
def test_ranges_come_back(numbers: set[int]) -> None:
    assert set(from_ranges(as_ranges(numbers))) == numbers


def test_a_plan_comes_back() -> None:
    trials = {TrialKey("a/b", "pd", seed) for seed in (0, 1, 5)} | {TrialKey("a/b", "mpc", 0), TrialKey("c", "pd", 2)}
    plan = planned(trials)
    assert plan == {"a/b": {"mpc": "0", "pd": "0-1,5"}, "c": {"pd": "2"}}
    assert trials_of(plan) == trials
