"""The further criteria of a scenario's `success`: KPIs held against bounds."""

from __future__ import annotations

from pytest_lpb.kpis.registry import default_registry, evaluate_kpis, load_builtin
from pytest_lpb.problem.criterion import parse_criterion
from pytest_lpb.trajectory import Trajectory


def failed_criteria(trajectory: Trajectory) -> list[str]:
    """Criteria that a trial does not meet, such as `clearance_min_m >= 0.02 (0.013)`.

    Timing criteria are skipped when the timing is contended; a KPI that raised is no value that meets a bound.
    """
    criteria = trajectory.problem.criteria
    if not criteria:
        return []
    load_builtin()
    kpis = default_registry.select(list(criteria))
    values, _ = evaluate_kpis(trajectory, kpis)
    return [
        f"{kpi.name} {criteria[kpi.name]} ({values[kpi.name]:.4g})"
        for kpi in kpis
        if not (kpi.timing and trajectory.timing_contended)
        and not parse_criterion(criteria[kpi.name]).met(values[kpi.name])
    ]
