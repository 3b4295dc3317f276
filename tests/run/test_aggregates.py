"""aggregates.csv and profiles, by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from pytest_lpb.kpis.units import BY_CONTROL_MODE
from pytest_lpb.run.aggregates import COLUMNS, aggregates_table
from pytest_lpb.run.profiles import RATIO, VALUE, kpi_profile
from tests.run.trial_frames import ACTION, CLEARANCE, KPIS, LENGTH, SOLVER, TIME, random_trials, trial


def row(table: pd.DataFrame, planner: str, kpi: str) -> dict[str, float]:
    found = table[(table["planner"] == planner) & (table["kpi"] == kpi)]
    assert len(found) == 1
    return {str(name): value for name, value in found.iloc[0].items()}


def test_columns_and_rows() -> None:
    table = aggregates_table(random_trials(("b", "a")), [TIME, LENGTH])
    assert list(table.columns) == COLUMNS
    keys = list(zip(table["kpi"], table["planner"], table["over"], strict=True))
    assert keys == [
        ("time_to_goal_s", "a", "all"),
        ("time_to_goal_s", "b", "all"),
        ("path_length_m", "a", "solved"),
        ("path_length_m", "b", "solved"),
    ]


def test_one_planner_by_hand() -> None:
    values = {"s1": [1.0, 2.0, 4.0, 9.0], "s2": [3.0, 5.0, 6.0, 50.0]}
    rows = [trial(s, seed=k, clearance_min_m=v) for s, each in values.items() for k, v in enumerate(each)]
    found = row(aggregates_table(pd.DataFrame(rows), [CLEARANCE]), "a", "clearance_min_m")
    assert (found["scenarios"], found["problems"]) == (2, 8)
    assert found["mean_of_scenarios"] == (4.0 + 16.0) / 2
    pool = [value for each in values.values() for value in each]
    assert found["iqm"] == pytest.approx(stats.trim_mean(pool, 0.25)) == 4.5
    assert found["iqm_low"] < 4.5 < found["iqm_high"]


def test_solved_kpis_are_of_the_problems_that_all_solved() -> None:
    """b solves only the short one; its mean must not look shorter than that of a, which solves both."""
    rows = [
        trial(planner=p, seed=k, success=s, path_length_m=v)
        for p, k, s, v in (("a", 0, True, 2.0), ("a", 1, True, 9.0), ("b", 0, True, 2.5), ("b", 1, False, 0.1))
    ]
    table = aggregates_table(pd.DataFrame(rows), [LENGTH])
    assert [row(table, p, "path_length_m")["problems"] for p in "ab"] == [1, 1]
    assert [row(table, p, "path_length_m")["iqm"] for p in "ab"] == [2.0, 2.5]


def test_a_planner_that_solves_nothing_leaves_the_others_theirs() -> None:
    rows = [trial(planner=p, seed=k, success=p != "c", path_length_m=k + 1.0) for p in "abc" for k in range(4)]
    table = aggregates_table(pd.DataFrame(rows), [LENGTH])
    assert [row(table, p, "path_length_m")["problems"] for p in "abc"] == [4, 4, 0]
    assert math.isnan(row(table, "c", "path_length_m")["iqm"])


def test_a_failed_trial_counts_its_duration() -> None:
    rows = [trial(seed=k, success=k > 0, time_to_goal_s=5.0 if k else math.nan) for k in range(2)]
    found = row(aggregates_table(pd.DataFrame(rows), [TIME]), "a", "time_to_goal_s")
    assert found["mean_of_scenarios"] == (25.0 + 5.0) / 2


def test_repeats_of_a_problem_are_one() -> None:
    rows = [trial(seed=k, problem_hash="same", clearance_min_m=float(k)) for k in range(5)]
    found = row(aggregates_table(pd.DataFrame(rows), [CLEARANCE]), "a", "clearance_min_m")
    assert (found["problems"], found["iqm"]) == (1, 2.0)
    # Nothing says how another problem would do.
    assert math.isnan(found["iqm_low"])
    assert math.isnan(found["iqm_high"])


def test_control_modes_do_not_mix() -> None:
    kpi = replace(ACTION, unit=BY_CONTROL_MODE, direction="lower")
    rows = [trial(s, control=s, action_total_variation=1.0) for s in ("acceleration", "velocity")]
    both, one = pd.DataFrame(rows), pd.DataFrame(rows[:1])
    assert row(aggregates_table(both, [kpi]), "a", kpi.name)["problems"] == 0
    assert row(aggregates_table(one, [kpi]), "a", kpi.name)["problems"] == 1
    assert kpi_profile(both, kpi) is None
    assert kpi_profile(one, kpi) is not None


def test_the_order_of_trials_and_other_kpis_change_nothing() -> None:
    trials = random_trials(seeds=8)
    table = aggregates_table(trials, KPIS)
    shuffled = trials.sample(frac=1.0, random_state=1)
    pd.testing.assert_frame_equal(aggregates_table(shuffled, KPIS), table)
    alone = aggregates_table(trials, [CLEARANCE])
    pd.testing.assert_frame_equal(alone, table[table["kpi"] == CLEARANCE.name].reset_index(drop=True))
    assert not aggregates_table(trials, KPIS, rng_seed=1).equals(table)


def test_no_trials() -> None:
    assert list(aggregates_table(random_trials().iloc[:0], KPIS).columns) == COLUMNS
    assert kpi_profile(random_trials().iloc[:0], TIME) is None


def test_ratios_to_the_best_planner() -> None:
    """Times of a: 2, 6, never; of b: 4, 3, 5. Ratios of a: 1, 2, never; of b: 2, 1, 1."""
    times = {"a": [2.0, 6.0, math.nan], "b": [4.0, 3.0, 5.0]}
    rows = [
        trial(planner=p, seed=k, success=not math.isnan(t), time_to_goal_s=t)
        for p, each in times.items()
        for k, t in enumerate(each)
    ]
    profile = kpi_profile(pd.DataFrame(rows), TIME)
    assert profile is not None
    assert (profile.kind, profile.problems, profile.scenarios) == (RATIO, 3, 1)
    assert profile.bounds[0] == 1.0
    below = profile.bounds < 2.0
    for planner, first, last in (("a", 1 / 3, 2 / 3), ("b", 2 / 3, 1.0)):
        share = profile.curves[planner].share
        assert share[below] == pytest.approx(first)
        assert share[-1] == pytest.approx(last)
        assert np.all(profile.curves[planner].low <= share + 1e-9)
        assert np.all(share <= profile.curves[planner].high + 1e-9)


def test_higher_is_better_counts_from_the_bound_up() -> None:
    rows = [
        trial(planner=p, seed=k, clearance_min_m=v)
        for p, each in {"a": [-1.0, 3.0], "b": [1.0, 3.0]}.items()
        for k, v in enumerate(each)
    ]
    profile = kpi_profile(pd.DataFrame(rows), CLEARANCE)
    assert profile is not None
    assert (profile.kind, profile.at_least) == (VALUE, True)
    assert np.all(np.diff(profile.bounds) < 0)
    at = {
        planner: float(np.interp(2.0, profile.bounds[::-1], curve.share[::-1]))
        for planner, curve in profile.curves.items()
    }
    assert at == {"a": pytest.approx(0.5), "b": pytest.approx(0.5)}
    at = {
        planner: float(np.interp(0.5, profile.bounds[::-1], curve.share[::-1]))
        for planner, curve in profile.curves.items()
    }
    assert at == {"a": pytest.approx(0.5), "b": pytest.approx(1.0)}


@pytest.mark.parametrize(
    ("lengths", "planners", "kind"), [((1.0, 2.0), "ab", RATIO), ((0.0, 2.0), "ab", VALUE), ((1.0, 2.0), "a", VALUE)]
)
def test_what_is_seen_as_ratios(lengths: tuple[float, ...], planners: str, kind: str) -> None:
    rows = [trial(planner=p, seed=k, path_length_m=v) for p in planners for k, v in enumerate(lengths)]
    profile = kpi_profile(pd.DataFrame(rows), LENGTH)
    assert profile is not None
    assert profile.kind == kind


def test_a_problem_solved_once_of_twice_is_not_solved() -> None:
    rows = [
        trial(planner=p, seed=k, problem_hash="same", success=p == "a" or k == 0, path_length_m=1.0)
        for p in "ab"
        for k in range(2)
    ]
    profile = kpi_profile(pd.DataFrame(rows), LENGTH)
    assert profile is not None
    assert (profile.curves["a"].share[-1], profile.curves["b"].share[-1]) == (1.0, 0.0)


def test_only_problems_that_all_were_given() -> None:
    rows = [trial(planner=p, seed=k, solver_time_p50_ms=1.0) for p, seeds in (("a", 4), ("b", 2)) for k in range(seeds)]
    profile = kpi_profile(pd.DataFrame(rows), SOLVER)
    assert profile is not None
    assert profile.problems == 2


def test_no_direction_no_profile() -> None:
    assert kpi_profile(random_trials(), ACTION) is None
