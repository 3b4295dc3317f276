from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_lpb.run.summary import summary_table
from pytest_lpb.statistics import wilson_interval
from tests.run.trial_frames import ACTION, CLEARANCE, KPIS, LENGTH, SOLVER, TIME, Column, random_trials, trial


def _row(table: pd.DataFrame, scenario: str, planner: str) -> Any:
    rows = table[(table["scenario"] == scenario) & (table["planner"] == planner)]
    assert len(rows) == 1
    return {str(name): value for name, value in rows.iloc[0].items()}


def test_columns_and_rows_stand_in_the_contracts_order() -> None:
    table = summary_table(random_trials(("b", "a"), ("s2", "s1")), [TIME, LENGTH])
    assert list(table.columns) == [
        *("scenario", "planner", "trials", "problems", "successes"),
        *("success_rate", "success_low", "success_high"),
        *("time_to_goal_s_median", "time_to_goal_s_q1", "time_to_goal_s_q3", "time_to_goal_s_n"),
        *("path_length_m_median", "path_length_m_q1", "path_length_m_q3", "path_length_m_n"),
        *("time_to_goal_s_restricted_mean", "success_rate_is", "contended_kpis"),
        *("time_to_goal_s_median_mean_of_scenarios", "path_length_m_median_mean_of_scenarios"),
    ]
    rows = list(zip(table["scenario"], table["planner"], strict=True))
    assert rows == [("s1", "a"), ("s1", "b"), ("s2", "a"), ("s2", "b"), ("all", "a"), ("all", "b")]


def test_one_scenario_by_hand() -> None:
    lengths = [4.0, 1.0, 3.0, 100.0]
    trials = pd.DataFrame(
        [
            trial(seed=seed, success=seed < 3, path_length_m=length, clearance_min_m=seed - 1.0)
            for seed, length in enumerate(lengths)
        ]
    )
    row = _row(summary_table(trials, [LENGTH, CLEARANCE]), "s", "a")
    assert (row["trials"], row["problems"], row["successes"], row["success_rate"]) == (4, 4, 3, 0.75)
    assert (row["success_low"], row["success_high"]) == pytest.approx(wilson_interval(3, 4))
    assert (row["path_length_m_median"], row["path_length_m_n"]) == (3.0, 3)
    assert (row["path_length_m_q1"], row["path_length_m_q3"]) == (2.0, 3.5)
    assert (row["clearance_min_m_median"], row["clearance_min_m_n"]) == (0.5, 4)


def test_repeats_of_one_problem_are_one_problem() -> None:
    trials = pd.DataFrame(
        [trial(seed=seed, success=seed % 4 > 0, problem_hash="fixed", path_length_m=seed + 1.0) for seed in range(100)]
    )
    row = _row(summary_table(trials, [LENGTH]), "s", "a")
    assert (row["trials"], row["problems"], row["successes"], row["success_rate"]) == (100, 1, 75, 0.75)
    assert (row["success_low"], row["success_high"]) == pytest.approx(wilson_interval(0.75, 1))
    mean = np.mean([seed + 1 for seed in range(100) if seed % 4])
    assert row["path_length_m_median"] == row["path_length_m_q3"] == pytest.approx(mean)
    assert row["path_length_m_n"] == 1


def test_repeats_count_their_problem_once() -> None:
    rows = [trial(seed=seed, problem_hash="x", success=False, clearance_min_m=0.0) for seed in range(9)]
    rows += [trial(seed=9, clearance_min_m=1.0), trial(seed=10, clearance_min_m=2.0)]
    row = _row(summary_table(pd.DataFrame(rows), [CLEARANCE]), "s", "a")
    assert (row["trials"], row["problems"], row["successes"]) == (11, 3, 2)
    assert row["success_rate"] == pytest.approx(2 / 3)
    assert row["clearance_min_m_median"] == 1.0


def test_timing_is_a_median_over_trials() -> None:
    rows = [trial(seed=seed, problem_hash="x", solver_time_p50_ms=1.0) for seed in range(9)]
    rows += [trial(seed=9, solver_time_p50_ms=9.0), trial(seed=10, success=False, solver_time_p50_ms=9.0)]
    row = _row(summary_table(pd.DataFrame(rows), [SOLVER]), "s", "a")
    assert row["solver_time_p50_ms_median"] == 1.0
    assert row["solver_time_p50_ms_n"] == 3


def test_restricted_mean_counts_failures_with_the_duration() -> None:
    rows = [
        trial(seed=0, time_to_goal_s=5.0),
        trial(seed=1, success=False, time_to_goal_s=np.nan),
        trial(seed=2, success=False, time_to_goal_s=6.0),
        trial(seed=3, success=False, time_to_goal_s=np.nan, duration_s=np.nan),
    ]
    row = _row(summary_table(pd.DataFrame(rows), [TIME]), "s", "a")
    assert row["time_to_goal_s_restricted_mean"] == (5 + 25 + 25 + 25) / 4
    assert (row["time_to_goal_s_median"], row["time_to_goal_s_n"]) == (5.5, 2)


@pytest.mark.parametrize("missing", ["", None, np.nan])
def test_a_crashed_worker_is_a_failed_problem(missing: object) -> None:
    crash = {"success": False, "outcome": "worker_crash", "problem_hash": missing, "clearance_min_m": np.nan}
    rows = [trial(seed=seed, clearance_min_m=1.0) for seed in range(3)]
    rows += [trial(seed=3) | crash, trial(seed=4) | crash]
    row = _row(summary_table(pd.DataFrame(rows), [CLEARANCE]), "s", "a")
    assert (row["trials"], row["problems"], row["successes"], row["success_rate"]) == (5, 5, 3, 0.6)
    assert row["clearance_min_m_n"] == 3


def test_a_crash_on_the_one_fixed_problem_is_one_of_its_repeats() -> None:
    rows = [trial(seed=seed, problem_hash="fixed") for seed in range(99)]
    rows += [trial(seed=99, success=False, problem_hash="")]
    row = _row(summary_table(pd.DataFrame(rows), []), "s", "a")
    assert (row["trials"], row["problems"], row["success_rate"]) == (100, 1, 0.99)


def test_all_is_the_mean_over_scenarios() -> None:
    rows = [trial("s1", seed=seed, path_length_m=1.0) for seed in range(10)]
    rows += [trial("s2", seed=seed, success=seed < 1, path_length_m=5.0) for seed in range(2)]
    rows += [trial("s3", seed=seed, success=False, path_length_m=9.0) for seed in range(4)]
    row = _row(summary_table(pd.DataFrame(rows), [LENGTH]), "all", "a")
    assert (row["trials"], row["problems"], row["successes"]) == (16, 16, 11)
    assert row["success_rate"] == pytest.approx((1 + 0.5 + 0) / 3)
    size = 9 / (1 / 10 + 1 / 2 + 1 / 4)
    assert (row["success_low"], row["success_high"]) == pytest.approx(wilson_interval(size / 2, size))
    assert row["success_rate_is"] == "mean of 3 scenarios"
    assert row["path_length_m_median_mean_of_scenarios"] == (1.0 + 5.0) / 2


def test_quartiles_of_all_are_those_of_all_problems() -> None:
    """Three lengths of 1 and five about 5: means of the scenarios' quartiles would be 3, 3, 3.5."""
    rows = [trial("s1", seed=seed, path_length_m=1.0) for seed in range(3)]
    rows += [trial("s2", seed=seed, path_length_m=length) for seed, length in enumerate([5.0, 9.0, 4.0, 6.0, 5.0])]
    rows += [trial("s2", seed=5, success=False, path_length_m=0.1)]
    row = _row(summary_table(pd.DataFrame(rows), [LENGTH]), "all", "a")
    # 1 1 1 4 5 5 6 9: q1 at 1.75 of 0..7, the median at 3.5, q3 at 5.25 (NumPy's linear percentiles).
    assert [row[f"path_length_m_{part}"] for part in ("q1", "median", "q3")] == [1.0, 4.5, 5.25]
    assert row["path_length_m_n"] == 8
    assert row["path_length_m_median_mean_of_scenarios"] == (1.0 + 5.0) / 2


def test_rates_say_what_they_are_the_mean_of() -> None:
    rows = [trial("s1", seed=seed, success=seed > 0) for seed in range(4)] + [trial("s2", problem_hash="x")]
    table = summary_table(pd.DataFrame(rows), [])
    said = [_row(table, scenario, "a")["success_rate_is"] for scenario in ("s1", "s2", "all")]
    assert said == ["mean of 4 problems", "mean of 1 problem", "mean of 2 scenarios"]


def test_kpis_that_were_contended_are_named() -> None:
    tail = Column("solver_time_p95_ms", unit="ms", timing=True)
    rows = [
        trial("s1", seed=0, solver_time_p50_ms=1.0, solver_time_p95_ms=2.0),
        trial("s1", seed=1, solver_time_p50_ms=1.0, solver_time_p95_ms=9.0),
        trial("s2", seed=0, solver_time_p50_ms=1.0, solver_time_p95_ms=2.0),
    ]
    trials = pd.DataFrame(rows).assign(contended_kpis=["", "solver_time_p95_ms; solver_time_max_ms", ""])
    table = summary_table(trials, [SOLVER, tail])
    named = [_row(table, scenario, "a")["contended_kpis"] for scenario in ("s1", "s2", "all")]
    assert named == ["solver_time_p95_ms", "", "solver_time_p95_ms"]
    every = summary_table(trials.drop(columns="contended_kpis").assign(timing_contended=True), [SOLVER, tail])
    assert _row(every, "all", "a")["contended_kpis"] == "solver_time_p50_ms; solver_time_p95_ms"


def test_with_one_scenario_all_equals_it() -> None:
    table = summary_table(random_trials(scenarios=("s",), seeds=7), KPIS)
    table = table.drop(columns=["scenario", *(name for name in table if str(name).endswith("mean_of_scenarios"))])
    pd.testing.assert_frame_equal(table[:2], table[2:].reset_index(drop=True), check_exact=True)


def test_nothing_solved_leaves_empty_cells_not_warnings() -> None:
    row = _row(summary_table(random_trials(rate=0.0), KPIS), "all", "a")
    assert np.isnan(row["path_length_m_median"])
    assert row["path_length_m_n"] == 0
    assert row["time_to_goal_s_restricted_mean"] == 25.0


def test_an_infinite_value_is_no_value() -> None:
    rows = [trial(seed=seed, clearance_min_m=value) for seed, value in enumerate([1.0, np.inf, 2.0])]
    row = _row(summary_table(pd.DataFrame(rows), [CLEARANCE]), "s", "a")
    assert (row["clearance_min_m_median"], row["clearance_min_m_n"]) == (1.5, 2)


def test_no_trials_give_an_empty_table_with_its_columns() -> None:
    table = summary_table(random_trials()[:0], [LENGTH])
    assert len(table) == 0
    assert list(table.columns)[-6:-2] == [f"path_length_m_{x}" for x in ("median", "q1", "q3", "n")]


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_row_order_and_index_change_nothing(seed: int) -> None:
    trials = random_trials(seeds=5)
    trials["problem_hash"] = [f"{s}-{k % 2}" for s, k in zip(trials["scenario"], trials["seed"], strict=True)]
    expected = summary_table(trials, KPIS)
    shuffled = trials.sample(frac=1, random_state=seed)
    pd.testing.assert_frame_equal(summary_table(shuffled, KPIS), expected, check_exact=True)


@given(st.floats(1e-3, 1e3), st.floats(-10, 10))
@settings(max_examples=10, deadline=None)
def test_a_change_of_unit_or_origin_goes_through(scale: float, shift: float) -> None:
    trials = random_trials(seeds=5)
    table = summary_table(trials, [ACTION])
    moved = summary_table(trials.assign(**{ACTION.name: trials[ACTION.name] * scale + shift}), [ACTION])
    for label in ("median", "q1", "q3"):
        expected = (table[f"{ACTION.name}_{label}"] * scale + shift).tolist()
        assert moved[f"{ACTION.name}_{label}"].tolist() == pytest.approx(expected, nan_ok=True)


def test_the_trials_are_not_changed() -> None:
    trials = random_trials()
    before = trials.copy(deep=True)
    summary_table(trials, KPIS)
    pd.testing.assert_frame_equal(trials, before)


def test_units_that_depend_on_the_control_mode_are_never_pooled() -> None:
    """kpis.md: m/s and rad/s^2 have no mean; scenarios of one mode have."""
    effort = Column("effort", unit="by control mode", direction="lower")
    rows = [
        trial(scenario, planner, effort=value, path_length_m=value, control=control)
        for scenario, planner, value, control in (
            *(("s1", "a", 1.0, "velocity [m/s]"), ("s2", "a", 3.0, "acceleration [rad/s^2]")),
            *(("s1", "b", 1.0, "velocity [m/s]"), ("s3", "b", 3.0, "velocity [m/s]")),
        )
    ]
    table = summary_table(pd.DataFrame(rows), [effort, LENGTH])
    assert np.isnan([_row(table, "all", "a")[f"effort_{label}"] for label in ("median", "q1", "q3")]).all()
    assert _row(table, "all", "a")["path_length_m_median"] == 2.0
    assert _row(table, "s2", "a")["effort_median"] == 3.0
    assert _row(table, "all", "b")["effort_median"] == 2.0
    assert _row(summary_table(pd.DataFrame(rows).drop(columns="control"), [effort]), "all", "a")["effort_median"] == 2.0
