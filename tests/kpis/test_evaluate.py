import math
import sys
import warnings
from collections.abc import Callable
from fractions import Fraction
from time import perf_counter
from typing import Any

import numpy as np
import pytest

from pytest_lpb.kpis.registry import Registry, evaluate_kpis, load_builtin

from .scenes import ORIGIN, reaching
from .trials import make_problem, make_trial

TRIAL = make_trial(make_problem(), np.zeros((3, 2)))


def evaluate(function: Callable[..., Any]) -> tuple[float, list[str]]:
    registry = Registry()
    registry.kpi("mine", "1", "lower", "all")(function)
    values, faults = evaluate_kpis(TRIAL, registry)
    return values["mine"], faults


@pytest.mark.parametrize("value", [1, 1.0, np.float32(1.0), np.int64(1), True, np.True_, Fraction(1)])
def test_numbers_of_any_kind(value: Any) -> None:
    found, faults = evaluate(lambda trajectory: value)
    assert found == 1.0
    assert type(found) is float
    assert faults == []


def test_nan_is_no_fault() -> None:
    found, faults = evaluate(lambda trajectory: np.float64("nan"))
    assert math.isnan(found)
    assert faults == []


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (math.inf, "returned inf; allowed is a finite number, or NaN"),
        (-np.inf, "returned -inf"),
        (1j, r"returned 1j (complex)"),
        ("1.0", "returned '1.0' (str)"),
        (None, "returned None (NoneType)"),
        (np.zeros(3), "returned an array of shape (3,)"),
        (np.zeros(()), "returned an array of shape ()"),
        (10**400, "OverflowError"),
    ],
)
def test_what_is_no_number_is_nan_and_named(value: Any, message: str) -> None:
    found, faults = evaluate(lambda trajectory: value)
    assert math.isnan(found)
    (fault,) = faults
    assert fault.startswith("KPI mine is NaN for scenarios/x.yaml::mine::seed0: ")
    assert message in fault
    assert "test_evaluate.py:" in fault


def test_what_raises_is_nan_and_the_others_are_evaluated() -> None:
    registry = Registry()
    registry.kpi("broken", "1", "lower", "all")(lambda trajectory: trajectory.link("hnad")[0, 0])
    registry.kpi("fine", "1", "lower", "all")(lambda trajectory: 2.0)
    values, faults = evaluate_kpis(TRIAL, registry)
    assert math.isnan(values["broken"])
    assert values["fine"] == 2.0
    assert len(faults) == 1
    assert "RecordingError: no column 'link_hnad_x'" in faults[0]


def test_a_value_does_not_depend_on_whether_warnings_are_errors() -> None:
    def warns(trajectory: object) -> float:
        warnings.warn("old", DeprecationWarning, stacklevel=1)
        return 3.0

    assert evaluate(warns) == (3.0, [])


def test_interrupts_are_not_caught() -> None:
    def interrupted(trajectory: object) -> float:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        evaluate(interrupted)


def test_shared_values_are_computed_once() -> None:
    trial = reaching(0.05, ORIGIN)
    evaluate_kpis(trial, load_builtin())
    size = len(trial.derived)
    again, _ = evaluate_kpis(trial, load_builtin())
    assert size == len(trial.derived) > 3
    fresh, _ = evaluate_kpis(reaching(0.05, ORIGIN), load_builtin())
    np.testing.assert_equal(again, fresh)


def test_all_kpis_of_a_trial_take_milliseconds() -> None:
    """The budget is 6 ms for 500 rows; the bound here leaves room for a busy machine."""
    trials = [reaching(0.01, ORIGIN) for _ in range(10)]
    times = []
    for trial in trials:
        start = perf_counter()
        _, faults = evaluate_kpis(trial, load_builtin())
        times.append(perf_counter() - start)
        assert faults == []
    assert min(times) < 0.03


@pytest.mark.parametrize("leave", [sys.exit, pytest.fail, pytest.skip, pytest.xfail])
def test_leaving_is_a_fault_like_any_other(leave: Callable[[str], Any]) -> None:
    found, (fault,) = evaluate(lambda trajectory: leave("enough"))
    assert math.isnan(found)
    assert "enough (" in fault
