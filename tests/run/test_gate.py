"""The gate's verdicts on hand-made trials."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.run.gate import INCONCLUSIVE, REGRESSED, SAME, Gate, GateVerdict
from pytest_lpb.run.margins import parse_margins
from tests.run.trial_frames import ACTION, CLEARANCE, KPIS, LENGTH, SOLVER, TIME, Column, random_trials, trial

MACHINE = {"cpu": "a", "cores": 4}


class Old:
    """A baseline made of trials."""

    name = "old"
    kpis = None
    warnings = ()

    def __init__(self, trials: pd.DataFrame, machine: Mapping[str, Any] | None = MACHINE) -> None:
        self._trials = trials
        self.machine = machine

    def counterparts(self, planners: Sequence[str]) -> dict[str, str]:
        return {name: name for name in planners if name in set(self._trials["planner"])}

    def trials(self, planner: str, own: pd.DataFrame, kpis: Sequence[str]) -> pd.DataFrame:
        return self._trials[self._trials["planner"] == planner]


Row = dict[str, object]


def frame(rows: Sequence[Row]) -> pd.DataFrame:
    return pd.DataFrame([{"command": f"pytest {row['node_id']}", "message": "", **row} for row in rows])


def trials(
    problems: int = 40, change: Callable[[int], Row] | None = None, scenarios: Sequence[str] = ("s",), **columns: object
) -> pd.DataFrame:
    """Trials of planner a; `change` gives columns by seed."""
    base: Row = {"time_to_goal_s": 5.0, "clearance_min_m": 0.2, "path_length_m": 4.0, "solver_time_p50_ms": 1.0}
    return frame(
        [
            trial(scenario, "a", seed, **{**base, **columns, **(change(seed) if change else {})})  # type: ignore[arg-type]
            for scenario in scenarios
            for seed in range(problems)
        ]
    )


def failed(seeds: Sequence[int]) -> Callable[[int], Row]:
    """A change that makes these seeds time out."""
    return lambda seed: (
        {"success": False, "outcome": "timeout", "time_to_goal_s": float("nan")} if seed in seeds else {}
    )


def judge(
    old: pd.DataFrame,
    new: pd.DataFrame,
    margin: str,
    machine: Mapping[str, Any] | None = MACHINE,
    kpis: Sequence[Column] = KPIS,
) -> GateVerdict:
    (verdict,) = Gate(Old(old, machine), parse_margins([margin], kpis, "--x")).judge(new, MACHINE).verdicts
    return verdict


@pytest.mark.parametrize("margin", ["success:0%", "time_to_goal_s:0%", "clearance_min_m:0m", "path_length_m:1%"])
@pytest.mark.parametrize("problems", [20, 200])
def test_a_planner_is_as_good_as_itself(margin: str, problems: int) -> None:
    noisy = frame(random_trials(("a",), ("s1", "s2"), problems // 2, rng_seed=3, rate=0.9).to_dict("records"))  # type: ignore[arg-type]
    verdict = judge(noisy, noisy, margin)
    if margin.startswith("path") and problems == 20:  # solved ones only: under 20
        assert verdict.verdict == INCONCLUSIVE
        return
    assert (verdict.verdict, verdict.loss, verdict.loss_low, verdict.loss_high) == (SAME, 0.0, 0.0, 0.0)
    assert verdict.changes == ()


@pytest.mark.parametrize("problems", [0, 1, 2, 19])
def test_under_twenty_problems_nothing_is_said(problems: int) -> None:
    old, new = trials(problems), trials(problems, failed(range(100)))
    if not problems:
        old, new = trials(5), trials(5, problem_hash="other")
    verdict = judge(old, new, "success:2%")
    assert (verdict.verdict, verdict.problems) == (INCONCLUSIVE, problems)
    expected = "no problem in common" if not problems else f"{problems} common problem"
    assert verdict.reason.startswith(expected)
    if problems:
        assert verdict.further_seeds is not None
        assert verdict.further_seeds + problems >= 20
    assert judge(trials(20), trials(20, failed(range(20))), "success:2%").verdict == REGRESSED


def test_one_flipped_seed_closes_no_gate() -> None:
    for problems in (20, 50, 400):
        for margin in ("success:0%", "time_to_goal_s:0%"):
            verdict = judge(trials(problems), trials(problems, failed([3])), margin)
            assert verdict.verdict == INCONCLUSIVE, (problems, margin)
    assert judge(trials(400), trials(400, failed([3])), "success:2%").verdict == SAME


def test_many_lost_seeds_close_it_and_are_named() -> None:
    verdict = judge(trials(40), trials(40, failed([30, 3, 7, 8, 9, 12, 17])), "success:2%")
    assert (verdict.verdict, verdict.old, verdict.new) == (REGRESSED, 1.0, 33 / 40)
    assert verdict.loss == pytest.approx(7 / 40)
    assert 0.02 < verdict.loss_low < 7 / 40 < verdict.loss_high
    assert [change.seed for change in verdict.changes] == [3, 7, 8, 9, 12, 17, 30]
    first = verdict.changes[0]
    assert (first.scenario, first.old, first.new, first.outcome) == ("s", 1.0, 0.0, "timeout")
    assert first.command == "pytest scenarios/s.yaml::a::seed3"


def test_a_kpi_that_got_worse_everywhere() -> None:
    old = trials(40, lambda seed: {"time_to_goal_s": 4.0 + seed % 5})
    new = trials(40, lambda seed: {"time_to_goal_s": 1.2 * (4.0 + seed % 5) + 0.01 * (seed % 3)})
    verdict = judge(old, new, "time_to_goal_s:10%")
    assert verdict.verdict == REGRESSED
    assert verdict.loss == pytest.approx(0.2016, abs=1e-4)
    assert len(verdict.changes) == 40
    losses = [change.new - change.old for change in verdict.changes]
    assert losses == sorted(losses, reverse=True)
    assert judge(old, new, "time_to_goal_s:25%").verdict == SAME
    assert judge(old, new, "time_to_goal_s:2s").verdict == SAME
    assert judge(old, new, "time_to_goal_s:1s").verdict == REGRESSED
    assert judge(new, old, "time_to_goal_s:0%").verdict == SAME  # faster is better


def test_higher_is_better() -> None:
    old, new = trials(clearance_min_m=0.2), trials(clearance_min_m=0.15)
    assert judge(old, new, "clearance_min_m:0.04m").verdict == REGRESSED
    assert judge(old, new, "clearance_min_m:0.06m").verdict == SAME
    assert judge(new, old, "clearance_min_m:0m").verdict == SAME


def test_a_spread_about_the_margin_is_inconclusive_and_says_what_would_decide() -> None:
    rng = np.random.default_rng(0)
    noise = rng.normal(0.5, 1.5, 40)
    old, new = trials(), trials(40, lambda seed: {"time_to_goal_s": 5.0 + noise[seed]})
    verdict = judge(old, new, "time_to_goal_s:13%")
    assert verdict.verdict == INCONCLUSIVE
    assert verdict.loss_low < 0.13 < verdict.loss_high
    assert verdict.reason == f"the loss may be {100 * verdict.loss_low:.3g} to {100 * verdict.loss_high:.3g} %"
    further = verdict.further_seeds
    assert further is not None
    # So many more of the same kind do decide.
    copies = 1 + -(-further // 40)
    many = [pd.concat([side.assign(seed=side["seed"] + 40 * k, problem_hash=side["problem_hash"] + f"-{k}",
            node_id=side["node_id"] + f"-{k}") for k in range(copies)]) for side in (old, new)]  # fmt: skip
    assert judge(many[0], many[1], "time_to_goal_s:13%").verdict == SAME


def test_failed_trials_count_the_duration_in_time_to_goal() -> None:
    verdict = judge(trials(), trials(40, failed(range(20))), "time_to_goal_s:10%")
    assert (verdict.old, verdict.new, verdict.verdict) == (5.0, 15.0, REGRESSED)
    assert [(change.old, change.new) for change in verdict.changes[:1]] == [(5.0, 25.0)]


def test_over_solved_pairs_problems_both_solved() -> None:
    new = trials(40, failed(range(10))).assign(path_length_m=[99.0] * 10 + [4.0] * 30)
    verdict = judge(trials(), new, "path_length_m:5%")
    assert (verdict.problems, verdict.verdict) == (30, SAME)


def test_repeats_of_one_problem_are_one_problem() -> None:
    old, new = trials(100, problem_hash="fixed"), trials(100, failed(range(60)), problem_hash="fixed")
    verdict = judge(old, new, "success:2%")
    assert (verdict.problems, verdict.new, verdict.verdict) == (1, 0.4, INCONCLUSIVE)
    assert verdict.further_seeds is None  # they would be the same problem again


def test_further_seeds_count_only_where_something_is_drawn() -> None:
    drawn = trials(3, scenarios=("drawn",))
    fixed = trials(2, problem_hash="always", scenarios=("fixed1", "fixed2"))
    rows = pd.concat([drawn, fixed], ignore_index=True)
    verdict = judge(rows, rows, "success:2%")
    # Three problems and twice one: each further seed brings one more, not five thirds.
    assert (verdict.problems, verdict.further_seeds) == (5, 15)


def test_further_seeds_reckon_with_problems_without_a_value() -> None:
    unsolved = trials(10, failed(range(5)))
    verdict = judge(unsolved, unsolved, "path_length_m:5%")
    # Every second problem is solved: 15 more of those take 30.
    assert (verdict.problems, verdict.further_seeds) == (5, 30)


def test_repeats_are_averaged() -> None:
    rows = trials(30, lambda seed: {"problem_hash": f"p{seed // 2}"}, scenarios=("s1", "s2"))
    verdict = judge(rows, rows, "success:0%")
    assert (verdict.problems, verdict.verdict) == (30, SAME)


def test_missing_new_and_changed_problems_are_left_out() -> None:
    old = trials(30, lambda seed: {"problem_hash": "before"} if seed == 4 else {})
    new = trials(33).query("seed != 7 and seed != 2")
    result = Gate(Old(old), parse_margins(["success:2%"], KPIS, "--x")).judge(new, MACHINE)
    left_out = result.left_out["a"]
    assert left_out.missing == (("s", 2), ("s", 7))
    assert left_out.new == (("s", 30), ("s", 31), ("s", 32))
    assert left_out.changed == (("s", 4),)
    assert result.verdicts[0].problems == 27


def test_a_lost_worker_fails_the_problem_of_its_seed() -> None:
    verdict = judge(trials(40), trials(40, lambda s: {**failed([5])(s), **({"problem_hash": ""} if s == 5 else {})}),
                    "success:5%")  # fmt: skip
    assert (verdict.problems, verdict.new) == (40, 39 / 40)


def test_rounding_to_six_digits_is_no_difference() -> None:
    old = trials(40, lambda seed: {"time_to_goal_s": round(4.0 + seed / 7, 5)})
    new = trials(40, lambda seed: {"time_to_goal_s": round(4.0 + seed / 7, 5) + 1e-9})
    assert judge(old, new, "time_to_goal_s:0%").verdict == SAME


def test_timing_gates_on_a_quiet_machine_of_the_same_kind_only() -> None:
    old, new = trials(), trials(solver_time_p50_ms=2.0)
    assert judge(old, new, "solver_time_p50_ms:10%").verdict == REGRESSED
    assert judge(old, new, "solver_time_p50_ms:10%", machine=None).verdict == REGRESSED  # of the same run
    elsewhere = judge(old, new, "solver_time_p50_ms:10%", machine={"cpu": "b", "cores": 4})
    assert (elsewhere.verdict, elsewhere.further_seeds) == (INCONCLUSIVE, None)
    assert elsewhere.reason == "the baseline is of another machine (cpu differ)"
    for one in ("old", "new"):
        contended = {"old": old, "new": new}
        contended[one] = contended[one].assign(timing_contended=lambda rows: rows["seed"] == 5)
        verdict = judge(contended["old"], contended["new"], "solver_time_p50_ms:10%")
        assert (verdict.verdict, verdict.reason[:20]) == (INCONCLUSIVE, "timing was contended")
        assert judge(contended["old"], contended["new"], "clearance_min_m:0m").verdict == SAME
    for name, expected in (("solver_time_p50_ms", INCONCLUSIVE), ("solver_time_p95_ms", REGRESSED)):
        # In one trial, a KPI of its own says that it waited; `timing_contended` is false.
        named = new.assign(contended_kpis=[name if seed == 5 else "" for seed in new["seed"]])
        assert judge(old, named, "solver_time_p50_ms:10%").verdict == expected
    assert judge(old, trials(clearance_min_m=0.1), "clearance_min_m:1%", machine={}).verdict == REGRESSED


def test_no_percentage_of_nothing() -> None:
    old, new = trials(clearance_min_m=0.0), trials(clearance_min_m=-0.1)
    verdict = judge(old, new, "clearance_min_m:10%")
    assert (verdict.verdict, verdict.reason[:23]) == (INCONCLUSIVE, "the baseline's mean is ")
    assert judge(old, new, "clearance_min_m:0.01m").verdict == REGRESSED


def test_a_kpi_without_values() -> None:
    verdict = judge(trials(clearance_min_m=np.nan), trials(), "clearance_min_m:10%")
    assert (verdict.verdict, verdict.reason) == (INCONCLUSIVE, "no problem has a value with both")


def test_units_of_control_modes_are_not_mixed() -> None:
    effort = Column("effort", unit="by control mode")
    old = trials(30, scenarios=("s1", "s2"), effort=1.0)
    new = old.assign(effort=2.0, control=["velocity [m/s]"] * 30 + ["acceleration [m/s^2]"] * 30)
    assert judge(old, new, "effort:10%", kpis=[effort]).verdict == INCONCLUSIVE
    assert judge(old, new.assign(control="velocity [m/s]"), "effort:10%", kpis=[effort]).verdict == REGRESSED


def test_every_planner_and_margin_has_a_verdict_and_strangers_are_named() -> None:
    both = pd.concat([trials(), trials().assign(planner="b"), trials().assign(planner="c")])
    old = both[both["planner"] != "c"]
    margins = parse_margins(["success:2%", "path_length_m:1%"], KPIS, "--x")
    result = Gate(Old(old), margins).judge(both.sample(frac=1, random_state=0), MACHINE)
    assert [(v.planner, v.margin.name) for v in result.verdicts] == [
        *(("a", "success"), ("a", "path_length_m"), ("b", "success"), ("b", "path_length_m"))
    ]
    assert (result.unknown, result.closed, result.sure) == (["c"], False, True)
    assert [v.planner for v in result.of(["b"]).verdicts] == ["b", "b"]


def test_inconclusive_fails_only_if_it_is_to() -> None:
    margins = parse_margins(["success:2%"], KPIS, "--x")
    for fails in (False, True):
        result = Gate(Old(trials(10)), margins, fails).judge(trials(10), MACHINE)
        assert (result.sure, result.closed) == (False, fails)


def test_a_direction_is_needed() -> None:
    with pytest.raises(ConfigurationError, match="no direction"):
        parse_margins([f"{ACTION.name}:5%"], KPIS, "--x")


KPIS_JUDGED = [CLEARANCE, LENGTH, TIME, SOLVER]


def test_copies_of_one_planner_are_called_regressed_at_the_nominal_rate_at_most() -> None:
    """150 studies of 200 problems with one noisy planner twice, at margin 0, where the loss is the margin itself."""
    margins = parse_margins(["success:0%", *(f"{kpi.name}:0%" for kpi in KPIS_JUDGED)], KPIS_JUDGED, "--x")
    verdicts: dict[str, list[str]] = {margin.name: [] for margin in margins}
    for study in range(150):
        both = frame(random_trials(("a", "b"), ("s1", "s2"), 100, KPIS_JUDGED, study).to_dict("records"))  # type: ignore[arg-type]
        old = both[both["planner"] == "b"].assign(planner="a")
        for verdict in Gate(Old(old), margins).judge(both[both["planner"] == "a"], MACHINE).verdicts:
            verdicts[verdict.margin.name].append(verdict.verdict)
    for name, found in verdicts.items():
        assert found.count(REGRESSED) / 150 <= 0.1, name
        assert found.count(SAME) / 150 <= 0.1, name
    everything = [verdict for found in verdicts.values() for verdict in found]
    assert 0.02 <= everything.count(REGRESSED) / len(everything) <= 0.065


def test_a_loss_beyond_the_margin_is_found() -> None:
    margins = parse_margins(["success:5%", "path_length_m:10%"], KPIS, "--x")
    found = 0
    for study in range(20):
        both = frame(random_trials(("a", "b"), ("s",), 200, KPIS, study, rate=0.95).to_dict("records"))  # type: ignore[arg-type]
        old = both[both["planner"] == "b"].assign(planner="a")
        new = both[both["planner"] == "a"].copy()
        new["path_length_m"] *= 1.3
        new["success"] &= new["seed"] % 4 != 0
        result = Gate(Old(old), margins).judge(new, MACHINE)
        found += result.count(REGRESSED)
    assert found >= 36  # of 40
