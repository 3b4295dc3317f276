"""Evaluating KPIs on a trial: each gives a finite number or NaN, and every fault is named."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from numbers import Real

import numpy as np

from pytest_lpb.errors import KpiError
from pytest_lpb.kpis.definition import Kpi
from pytest_lpb.trajectory import Trajectory

_LONGEST_TEXT = 300


def evaluate_kpis(trajectory: Trajectory, kpis: Iterable[Kpi]) -> tuple[dict[str, float], list[str]]:
    """Values of KPIs for one trial.

    Args:
        trajectory: the trial; with zero rows (its worker crashed) every KPI is NaN without a warning.
        kpis: as `Registry.select` gives them.

    Returns:
        Value by KPI name, finite or NaN; and a text for each KPI that raised or returned something else (then
        NaN), which names the KPI, the trial and the error.
    """
    if not len(trajectory):
        return {entry.name: math.nan for entry in kpis}, []
    values: dict[str, float] = {}
    faults: list[str] = []
    with warnings.catch_warnings():
        # A value must not depend on whether warnings are errors: pytest may say so, lpb-report does not.
        warnings.simplefilter("ignore")
        for entry in kpis:
            try:
                values[entry.name] = as_number(entry(trajectory))
            except KeyboardInterrupt:
                raise
            except BaseException as error:  # also SystemExit and pytest.fail: the fault is handed on
                values[entry.name] = math.nan
                faults.append(_fault(entry, trajectory, error))
    return values, faults


def as_number(value: object) -> float:
    """A KPI's result as float. Raises KpiError unless it is a real number, finite or NaN."""
    if not isinstance(value, Real | np.bool_):
        raise KpiError(f"returned {_described(value)}; allowed is a number, or NaN where it does not apply")
    result = float(value)
    if math.isinf(result):
        raise KpiError(f"returned {result}; allowed is a finite number, or NaN where it does not apply")
    return result


def _fault(entry: Kpi, trajectory: Trajectory, error: BaseException) -> str:
    node_id = trajectory.metadata.get("node_id", "a trial without node id")
    text = _shortened(" ".join(str(error).split()), _LONGEST_TEXT)
    return f"KPI {entry.name} is NaN for {node_id}: {type(error).__name__}: {text} ({entry.place})"


def _described(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    return f"{_shortened(repr(value), 60)} ({type(value).__name__})"


def _shortened(text: str, length: int) -> str:
    return text if len(text) <= length else text[: length - 3] + "..."
