import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_lpb.run.comparisons import COLUMNS, comparisons_table
from pytest_lpb.statistics import holm, newcombe_paired_interval, wilcoxon_p
from tests.run.trial_frames import ACTION, CLEARANCE, KPIS, LENGTH, SOLVER, TIME, Column, random_trials, trial

MIRROR = {"better": "worse", "worse": "better"}


def _row(table: pd.DataFrame, kpi: str, scenario: str = "s", pair: str = "ab") -> dict[str, Any]:
    chosen = table[(table["kpi"] == kpi) & (table["scenario"] == scenario)]
    chosen = chosen[(chosen["planner_a"] == pair[0]) & (chosen["planner_b"] == pair[1])]
    assert len(chosen) == 1
    return {str(name): value for name, value in chosen.iloc[0].items()}


def _two(a: Sequence[float], b: Sequence[float], kpi: Column = CLEARANCE, **columns: object) -> list[dict[str, object]]:
    """Rows of planners a and b with these values on problems 0, 1, ..."""
    return [
        trial("s", planner, seed, **{kpi.name: value}, **columns)  # type: ignore[arg-type]
        for planner, values in (("a", a), ("b", b))
        for seed, value in enumerate(values)
    ]


def _compare(rows: list[dict[str, object]], kpi: Column = CLEARANCE) -> dict[str, Any]:
    return _row(comparisons_table(pd.DataFrame(rows), [kpi]), kpi.name)


def _success(rows: list[dict[str, object]]) -> dict[str, Any]:
    return _row(comparisons_table(pd.DataFrame(rows), []), "success")


def test_columns_and_rows_stand_in_the_contracts_order() -> None:
    table = comparisons_table(random_trials(("c", "a", "b"), ("s2", "s1"), 4), [LENGTH, TIME])
    assert list(table.columns) == COLUMNS
    keys = list(zip(table["planner_a"], table["planner_b"], table["scenario"], table["kpi"], strict=True))
    kpis = ("success", "path_length_m", "time_to_goal_s")
    pairs = [("a", "b"), ("a", "c"), ("b", "c")]
    assert keys == [(*pair, s, kpi) for pair in pairs for s in ("s1", "s2", "all") for kpi in kpis]
    assert set(zip(table["kpi"], table["over"], strict=True)) == {
        *(("success", "all"), ("path_length_m", "solved"), ("time_to_goal_s", "all"))
    }


def test_a_kpi_by_hand() -> None:
    row = _compare(_two([1, 2, 3, 4, 5, 6], [1.5, 2.25, 3, 4.75, 6, 7.25]))
    assert (row["pairs"], row["median_a"], row["median_b"]) == (6, 3.5, 3.875)
    assert row["difference"] == 0.625  # the median of 0, 1/4, 1/2, 3/4, 1, 5/4; the medians differ by 3/8
    assert row["ratio"] == pytest.approx(3.875 / 3.5)
    assert row["p"] == row["p_adjusted"] == pytest.approx(2 / 2**5)
    assert row["improvement_probability"] == pytest.approx(5.5 / 6)
    assert 0 <= row["difference_low"] < 0.625 < row["difference_high"] <= 1.25
    assert row["verdict"] == "inconclusive"


def test_success_by_hand() -> None:
    a, b = [1.0] * 9 + [0.0], [0.0] * 8 + [1.0, 0.0]
    rows = _two(a, b)
    for row in rows:
        row["success"] = row[CLEARANCE.name] == 1.0
    row = _success(rows)
    assert (row["pairs"], row["median_a"], row["median_b"]) == (10, 0.9, 0.1)
    assert row["difference"] == pytest.approx(-0.8)
    assert (row["difference_low"], row["difference_high"]) == pytest.approx(newcombe_paired_interval(a, b))
    assert row["p"] == pytest.approx(2 / 2**8)
    assert row["improvement_probability"] == pytest.approx(0.1)
    assert (row["over"], row["verdict"]) == ("all", "worse")


def test_over_solved_compares_problems_both_solved() -> None:
    rows = _two([1.0] * 10, [2.0] * 10, LENGTH)
    for row in rows:
        row["success"] = row["seed"] != (2 if row["planner"] == "a" else 3)
    assert _compare(rows, LENGTH)["pairs"] == 8


def test_a_planner_that_crashes_early_does_not_look_short() -> None:
    rows = _two([10.0] * 8, [10.0, 10.0, 10.0, 10.0, 10.0, 0.1, 0.1, 0.1], LENGTH)
    for row in rows:
        row["success"] = row[LENGTH.name] == 10.0
    row = _compare(rows, LENGTH)
    assert (row["pairs"], row["difference"], row["verdict"]) == (5, 0.0, "same")


def test_a_failed_trial_counts_the_duration_in_time_to_goal() -> None:
    rows = _two([5.0] * 8, [5.0, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, np.nan], TIME)
    for row in rows:
        row["success"] = not math.isnan(row[TIME.name])  # type: ignore[arg-type]
    row = _compare(rows, TIME)
    assert (row["pairs"], row["median_b"], row["difference"], row["verdict"]) == (8, 25.0, 20.0, "worse")


def test_repeats_are_averaged_to_distinct_problems() -> None:
    rows = _two([1.0] * 40, [2.0, 4.0] * 20)
    for row in rows:
        row["problem_hash"] = "fixed"
    row = _compare(rows)
    assert (row["pairs"], row["median_b"], row["p"], row["verdict"]) == (1, 3.0, 1.0, "inconclusive")


def test_only_trials_of_the_same_scenario_seed_and_problem_are_paired() -> None:
    rows = _two([1.0] * 9, [2.0] * 7)
    rows[0]["problem_hash"] = "drawn before the scenario was changed"
    assert _compare(rows)["pairs"] == 6


def test_a_crashed_worker_fails_the_problem_of_its_seed() -> None:
    rows = _two([1.0] * 8, [1.0] * 8)
    rows[-1] |= {"success": False, "problem_hash": "", CLEARANCE.name: np.nan}
    assert _compare(rows)["pairs"] == 7
    row = _success(rows)
    assert (row["pairs"], row["median_b"]) == (8, 7 / 8)


@pytest.mark.parametrize(
    ("kpi", "verdict"), [(LENGTH, "worse"), (CLEARANCE, "better"), (SOLVER, "worse"), (ACTION, "")]
)
def test_a_clear_difference_is_judged_by_the_kpis_direction(kpi: Column, verdict: str) -> None:
    a = np.linspace(1, 2, 20)
    row = _compare(_two(a.tolist(), (a + 0.3).tolist(), kpi), kpi)
    assert row["verdict"] == verdict
    assert row["difference"] == pytest.approx(0.3)
    assert row["p"] < 1e-4
    expected = {"lower": 0.0, "higher": 1.0, "none": math.nan}[kpi.direction]
    assert row["improvement_probability"] == pytest.approx(expected, nan_ok=True)


def test_contended_timing_decides_nothing() -> None:
    rows = _two([1.0] * 20, [2.0] * 20, SOLVER)
    rows[7]["timing_contended"] = True
    assert _compare(rows, SOLVER)["verdict"] == "inconclusive"
    assert _compare([row | {CLEARANCE.name: row[SOLVER.name]} for row in rows])["verdict"] == "better"


def test_a_tail_that_was_contended_decides_nothing_of_itself_alone() -> None:
    tail = Column("solver_time_p95_ms", unit="ms", timing=True)
    rows = [
        trial(planner=planner, seed=seed, solver_time_p50_ms=value, solver_time_p95_ms=value)
        for planner, value in (("a", 1.0), ("b", 2.0))
        for seed in range(12)
    ]
    trials = pd.DataFrame(rows).assign(contended_kpis=["solver_time_p95_ms", *[""] * 23])
    table = comparisons_table(trials, [SOLVER, tail]).set_index(["scenario", "kpi"])["verdict"]
    assert table["s", "solver_time_p50_ms"] == table["all", "solver_time_p50_ms"] == "worse"
    assert table["s", "solver_time_p95_ms"] == table["all", "solver_time_p95_ms"] == "inconclusive"


@pytest.mark.parametrize(("pairs", "known"), [(1, False), (2, True)])
def test_one_pair_has_no_interval(pairs: int, known: bool) -> None:
    """One problem says nothing of others, neither of a KPI nor of success."""
    rows = [
        trial(planner=planner, seed=seed, success=planner == "a", clearance_min_m=value + seed)
        for planner, value in (("a", 1.0), ("b", 2.0))
        for seed in range(pairs)
    ]
    table = comparisons_table(pd.DataFrame(rows), [CLEARANCE])
    assert table["pairs"].tolist() == [pairs] * 4
    assert table["difference"].notna().all()
    assert table[["difference_low", "difference_high"]].notna().to_numpy().tolist() == [[known, known]] * 4


@pytest.mark.parametrize(("pairs", "verdict"), [(4, "inconclusive"), (5, "same"), (50, "same")])
def test_identical_planners_are_the_same_from_five_pairs_on(pairs: int, verdict: str) -> None:
    values = np.linspace(0.1, 2, pairs)
    row = _compare(_two(values.tolist(), (values * (1 + 1e-12)).tolist()))
    assert (row["verdict"], row["p"], row["difference"]) == (verdict, 1.0, 0.0)
    assert row["improvement_probability"] == 0.5


def test_five_clear_pairs_are_too_few() -> None:
    assert _compare(_two([1.0] * 5, [9.0] * 5))["verdict"] == "inconclusive"
    assert _compare(_two([1.0] * 6, [9.0] * 6))["verdict"] == "better"


def test_within_one_percent_is_the_same_unless_the_test_resolves_it() -> None:
    noise = np.tile([-0.004, 0.004, 0.001, -0.001], 10)
    assert _compare(_two([1.0] * 40, (1 + noise).tolist()))["verdict"] == "same"
    assert _compare(_two([1.0] * 40, (1 + 10 * noise).tolist()))["verdict"] == "inconclusive"
    assert _compare(_two([1.0] * 40, (1.005 + noise / 10).tolist()))["verdict"] == "better"


def test_a_median_of_zero_with_a_clear_test_is_not_the_same() -> None:
    row = _compare(_two([1.0] * 40, [1.0] * 30 + [2.0] * 10))
    assert (row["difference_low"], row["difference_high"]) == (0.0, 0.0)
    assert row["p"] < 0.01
    assert row["verdict"] == "inconclusive"


def test_a_kpi_without_values_has_no_figures() -> None:
    row = _compare(_two([np.nan] * 8, [1.0] * 8))
    assert (row["pairs"], row["verdict"]) == (0, "inconclusive")
    assert all(math.isnan(row[name]) for name in ("median_a", "difference", "p", "p_adjusted", "ratio"))


def test_holm_runs_over_the_planner_pairs_of_a_kpi_and_scenario() -> None:
    table = comparisons_table(random_trials("abc", seeds=15), KPIS)
    for _, family in table.groupby(["kpi", "scenario"]):
        assert len(family) == 3
        assert family["p_adjusted"].tolist() == holm(family["p"]).tolist()


def test_all_is_the_mean_over_scenarios_of_the_pooled_pairs() -> None:
    trials = random_trials(scenarios=("s1", "s2", "s3"), seeds=15)
    table = comparisons_table(trials, KPIS)
    parts, whole = table[table["scenario"] != "all"], table[table["scenario"] == "all"].set_index("kpi")
    for kpi, part in parts.groupby("kpi"):
        row = whole.loc[str(kpi)]
        assert row["pairs"] == part["pairs"].sum()
        for name in ("median_a", "median_b", "difference", "improvement_probability"):
            assert row[name] == pytest.approx(part[name].mean(), nan_ok=True)
        assert row["difference_low"] <= row["difference"] <= row["difference_high"]
    values = trials.pivot_table(index=["scenario", "seed"], columns="planner", values=CLEARANCE.name)
    assert whole.loc[CLEARANCE.name, "p"] == pytest.approx(wilcoxon_p(values["b"] - values["a"]))


def test_an_effect_in_one_of_two_scenarios_does_not_carry_over_to_all() -> None:
    rows = [
        trial(scenario, planner, seed, clearance_min_m=1.0 + (planner == "b") * (scenario == "s1"))
        for scenario in ("s1", "s2")
        for planner in "ab"
        for seed in range(30)
    ]
    table = comparisons_table(pd.DataFrame(rows), [CLEARANCE])
    verdicts = [_row(table, CLEARANCE.name, scenario)["verdict"] for scenario in ("s1", "s2", "all")]
    assert verdicts == ["better", "same", "inconclusive"]


def test_with_one_scenario_all_equals_it() -> None:
    table = comparisons_table(random_trials(scenarios=("s",), seeds=9), KPIS)
    one, every = (table[table["scenario"] == s].drop(columns="scenario") for s in ("s", "all"))
    pd.testing.assert_frame_equal(one, every.set_index(one.index), check_exact=True)


def test_planners_without_a_common_scenario_are_not_compared() -> None:
    rows = [trial("s1", "a", seed) for seed in range(3)] + [trial("s2", "b", seed) for seed in range(3)]
    assert comparisons_table(pd.DataFrame(rows), []).empty
    assert list(comparisons_table(pd.DataFrame(rows[:3]), []).columns) == COLUMNS
    assert list(comparisons_table(pd.DataFrame(rows)[:0], []).columns) == COLUMNS


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_row_order_and_index_change_nothing(seed: int) -> None:
    trials = random_trials(seeds=7)
    shuffled = trials.sample(frac=1, random_state=seed)
    expected = comparisons_table(trials, KPIS)
    pd.testing.assert_frame_equal(comparisons_table(shuffled, KPIS), expected, check_exact=True)


def test_another_planner_or_kpi_changes_no_other_interval() -> None:
    trials = random_trials("abc", seeds=9)
    every = comparisons_table(trials, KPIS)
    two = comparisons_table(trials[trials["planner"] != "c"], [CLEARANCE])
    row, same = _row(every, CLEARANCE.name, "s1"), _row(two, CLEARANCE.name, "s1")
    assert row["difference_low"] == same["difference_low"]
    assert row["p"] == same["p"]


def test_the_seed_moves_intervals_only() -> None:
    trials = random_trials(seeds=30)
    first, second = (comparisons_table(trials, [CLEARANCE], rng_seed=seed) for seed in (0, 1))
    ends = ["difference_low", "difference_high"]
    assert not first[ends].equals(second[ends])
    others = [name for name in COLUMNS if name not in (*ends, "verdict")]
    pd.testing.assert_frame_equal(first[others], second[others])


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10_000), st.floats(-1, 1))
def test_swapping_the_planners_mirrors_the_comparison(seed: int, effect: float) -> None:
    trials = random_trials(seeds=25, rng_seed=seed)
    trials.loc[trials["planner"] == "b", CLEARANCE.name] += effect
    swapped = trials.assign(planner=trials["planner"].map({"a": "b", "b": "a"}))
    table, mirror = comparisons_table(trials, KPIS), comparisons_table(swapped, KPIS)
    assert mirror["difference"].tolist() == pytest.approx((-table["difference"]).tolist())
    assert mirror["difference_low"].tolist() == pytest.approx((-table["difference_high"]).tolist())
    assert mirror["p"].tolist() == pytest.approx(table["p"].tolist())
    assert mirror["median_a"].tolist() == table["median_b"].tolist()
    assert mirror["ratio"].tolist() == pytest.approx((1 / table["ratio"]).tolist(), nan_ok=True)
    total = mirror["improvement_probability"] + table["improvement_probability"]
    assert total.dropna().tolist() == pytest.approx([1.0] * len(total.dropna()))
    assert mirror["verdict"].tolist() == [MIRROR.get(v, v) for v in table["verdict"]]


@settings(max_examples=8, deadline=None)
@given(st.sampled_from([1e-3, 0.5, 1024.0]), st.sampled_from([0.0, 8.0, -512.0]))
def test_a_change_of_unit_or_origin_goes_through(scale: float, shift: float) -> None:
    trials = random_trials(seeds=25)
    trials.loc[trials["planner"] == "b", CLEARANCE.name] += 0.4
    moved = trials.assign(**{CLEARANCE.name: trials[CLEARANCE.name] * scale + shift})
    table, other = comparisons_table(trials, [CLEARANCE]), comparisons_table(moved, [CLEARANCE])
    kpi = (table["kpi"] == CLEARANCE.name).to_numpy()
    for name in ("difference", "difference_low", "difference_high"):
        assert other[kpi][name].tolist() == pytest.approx((table[kpi][name] * scale).tolist())
    assert other["p"].tolist() == pytest.approx(table["p"].tolist())
    decided = [["better", "worse"].count(verdict) for verdict in table["verdict"]]
    assert [["better", "worse"].count(verdict) for verdict in other["verdict"]] == decided
    if shift == 0:
        assert other["verdict"].tolist() == table["verdict"].tolist()


def test_a_planner_against_its_copy_differs_at_the_nominal_rate_only() -> None:
    """200 studies of 200 problems, one noisy planner twice: p < 0.05 in about 5 %, a verdict in no more."""
    kpis = [LENGTH, CLEARANCE]
    tables = [
        comparisons_table(random_trials(scenarios=("s",), seeds=200, kpis=kpis, rng_seed=study), kpis)
        for study in range(200)
    ]
    rows = pd.concat([table[table["scenario"] == "s"] for table in tables])
    measured = rows[rows["kpi"] != "success"]
    assert 0.025 <= (measured["p"] < 0.05).mean() <= 0.08
    assert 0.02 <= (measured["difference_low"] * measured["difference_high"] > 0).mean() <= 0.08
    assert (rows[rows["kpi"] == "success"]["p"] < 0.05).mean() <= 0.07
    decided = rows["verdict"].isin(["better", "worse"])
    assert 0.005 <= decided.mean() <= 0.06


def test_copies_over_several_scenarios_differ_rarely() -> None:
    scenarios = [f"s{index}" for index in range(6)]
    tables = [
        comparisons_table(random_trials("ab", scenarios, 15, [CLEARANCE], study), [CLEARANCE]) for study in range(100)
    ]
    rows = pd.concat(tables)
    rows = rows[rows["scenario"] == "all"]
    assert rows["verdict"].isin(["better", "worse"]).mean() <= 0.06


def test_a_real_difference_is_found_in_fifty_problems() -> None:
    found = 0
    for study in range(20):
        trials = random_trials(scenarios=("s",), seeds=50, kpis=[CLEARANCE], rng_seed=study)
        trials.loc[trials["planner"] == "b", CLEARANCE.name] *= 1.5
        found += _row(comparisons_table(trials, [CLEARANCE]), CLEARANCE.name)["verdict"] == "better"
    assert found >= 18


def test_units_that_depend_on_the_control_mode_are_never_pooled() -> None:
    effort = Column("effort", unit="by control mode")
    trials = random_trials(seeds=8, kpis=[effort, LENGTH], rate=1.0)
    one_mode = comparisons_table(trials.assign(control="velocity [m/s]"), [effort])
    assert one_mode.equals(comparisons_table(trials, [effort]))
    assert _row(one_mode, "effort", "all")["pairs"] == 16
    modes = trials["scenario"].map({"s1": "velocity [m/s]", "s2": "acceleration [m/s^2]"})
    table = comparisons_table(trials.assign(control=modes), [effort, LENGTH])
    mixed = _row(table, "effort", "all")
    assert (mixed["pairs"], mixed["verdict"]) == (0, "inconclusive")
    assert np.isnan([mixed[name] for name in ("median_a", "difference", "ratio", "p", "p_adjusted")]).all()
    assert _row(table, "effort", "s1")["pairs"] == 8
    assert _row(table, "path_length_m", "all")["pairs"] == 16
