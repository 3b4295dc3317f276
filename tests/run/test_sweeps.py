"""Curves of sweeps, from a table made by hand."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd
import pytest

from pytest_lpb.run.sweeps import Point, sweeps_of

INFO = {
    "swept": {
        "planners": {
            f"mpc_horizon-{horizon}_step-{step}": {"of": "mpc", "values": {"horizon": horizon, "step": step}}
            for horizon in (20, 5)
            for step in (0.1, 0.2)
        },
        "scenarios": {
            f"point/x_count-{count}": {"of": "point/x", "values": {"count": count}} for count in ("few", "many")
        },
    }
}


def row(scenario: str, planner: str, rate: float, clearance: float) -> dict[str, Any]:
    return {
        "scenario": scenario,
        "planner": planner,
        "successes": int(8 * rate),
        "trials": 8,
        "success_rate": rate,
        "success_low": rate - 0.1,
        "success_high": rate + 0.1,
        "clearance_min_m_median": clearance,
        "clearance_min_m_q1": clearance - 1.0,
        "clearance_min_m_q3": clearance + 1.0,
        "clearance_min_m_n": 1,
    }


SUMMARY = pd.DataFrame(
    [
        row("all", "mpc_horizon-5_step-0.1", 0.5, 1.0),
        row("all", "mpc_horizon-20_step-0.1", 0.75, 2.0),
        row("all", "mpc_horizon-5_step-0.2", 0.25, math.nan),
        row("all", "mpc_horizon-20_step-0.2", 0.625, 3.0),
        row("point/x_count-few", "pd", 1.0, 4.0),
        row("point/x_count-many", "pd", 0.5, 5.0),
        row("point/x_count-few", "mpc_horizon-5_step-0.1", 0.875, 6.0),
    ]
)


def test_a_sweep_per_parameter() -> None:
    found = [(sweep.kind, sweep.of, sweep.parameter, sweep.values) for sweep in sweeps_of(INFO)]
    assert found == [
        ("planners", "mpc", "horizon", [5, 20]),
        ("planners", "mpc", "step", [0.1, 0.2]),
        ("scenarios", "point/x", "count", ["few", "many"]),
    ]


def test_runs_without_sweeps_have_none() -> None:
    assert sweeps_of({}) == []


def test_a_parameter_of_a_planner() -> None:
    horizon, step, _ = sweeps_of(INFO)
    first, second = horizon.curves(SUMMARY, "success_rate")
    assert (first.label, second.label) == ("step 0.1", "step 0.2")
    assert first.points == [Point(5, 0.5, 0.4, 0.6, "4/8"), Point(20, 0.75, 0.65, 0.85, "6/8")]
    assert [point.figure for point in second.points] == [0.25, 0.625]
    labels = {curve.label: [point.figure for point in curve.points] for curve in step.curves(SUMMARY, "success_rate")}
    assert labels == {"horizon 20": [0.75, 0.625], "horizon 5": [0.5, 0.25]}


def test_values_that_are_missing_are_left_out() -> None:
    horizon = sweeps_of(INFO)[0]
    _, second = horizon.curves(SUMMARY, "clearance_min_m_median")
    assert second.points == [Point(20, 3.0, 2.0, 4.0, "1 problem")]


def test_a_knob_of_a_scenario_has_a_curve_per_planner() -> None:
    knob = sweeps_of(INFO)[2]
    curves = {curve.planner: curve for curve in knob.curves(SUMMARY, "clearance_min_m_median")}
    assert curves["pd"].label == "pd"
    assert [(point.value, point.figure) for point in curves["pd"].points] == [("few", 4.0), ("many", 5.0)]
    assert [point.value for point in curves["mpc_horizon-5_step-0.1"].points] == ["few"]


def test_parameters_with_one_value_are_no_sweep() -> None:
    info = {"swept": {"planners": {"pd_p-1": {"of": "pd", "values": {"p": 1}}}, "scenarios": {}}}
    assert sweeps_of(info) == []


@pytest.mark.parametrize("value", [True, "a", [1, 2]])
def test_values_of_any_kind(value: Any) -> None:
    info = {"swept": {"planners": {"a": {"of": "x", "values": {"p": value}}, "b": {"of": "x", "values": {"p": 1.0}}}}}
    (sweep,) = sweeps_of(info)
    assert sweep.values == [value, 1.0]
