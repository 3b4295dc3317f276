"""KPIs of a trajectory."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

from pytest_lpb.kpis.registry import Registry, default_registry, evaluate_kpis, load_builtin
from pytest_lpb.run.plugins import load_kpi_entry_points
from pytest_lpb.trajectory import Trajectory


def registered_kpis() -> Registry:
    """The built-in KPIs, those of installed packages, and those that were defined in this process."""
    load_builtin()
    load_kpi_entry_points()
    return default_registry


def evaluate(trajectory: Trajectory, kpis: Sequence[str] | None = None) -> dict[str, float]:
    """KPIs of one trial, as in trials.csv.

    Args:
        trajectory: of `run_trial`, or `load_run(..).trajectory(..)`.
        kpis: names of those wanted; None: all that are registered.

    Returns:
        Value by KPI name, which ends with its unit: `time_to_goal_s`, `path_length_m`; NaN where it does not apply.
        A KPI that raises is NaN, with a warning that says why.

    Raises KpiError for unknown names.
    """
    chosen = registered_kpis().select([kpis] if isinstance(kpis, str) else kpis)
    values, faults = evaluate_kpis(trajectory, chosen)
    for fault in faults:
        warnings.warn(fault, stacklevel=2)
    return values
