"""The further criteria of a scenario's `success`: KPIs held against bounds."""

from __future__ import annotations

from math import isnan

from pytest_lpb.kpis.registry import default_registry, evaluate_kpis, load_builtin
from pytest_lpb.problem.criterion import parse_criterion
from pytest_lpb.trajectory import Trajectory


def failed_criteria(trajectory: Trajectory) -> list[str]:
    """Criteria that a trial does not meet, such as `clearance_min_m >= 0.02 (0.013)`.

    Timing criteria are skipped when the timing is contended, and those on KPIs that do not apply (NaN), such as the
    clearance where there are no obstacles. A KPI that raises meets no bound.
    """
    criteria = trajectory.problem.criteria
    if not criteria:
        return []
    load_builtin()
    kpis = default_registry.select(list(criteria))
    failed = []
    for kpi in kpis:
        values, faults = evaluate_kpis(trajectory, [kpi])
        value = values[kpi.name]
        disturbed = kpi.timing and (trajectory.timing_contended or kpi.is_contended(trajectory))
        applies = bool(faults) or not (isnan(value) or disturbed)
        if applies and not parse_criterion(criteria[kpi.name]).met(value):
            failed.append(f"{kpi.name} {criteria[kpi.name]} ({value:.4g})")
    return failed
