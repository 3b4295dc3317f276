"""The further criteria of a scenario's `success`: KPIs held against bounds."""

from __future__ import annotations

import operator
from collections.abc import Callable
from math import isnan

from pytest_lpb.errors import ScenarioError
from pytest_lpb.kpis.registry import default_registry, evaluate_kpis, load_builtin
from pytest_lpb.trajectory import Trajectory

OPERATORS: dict[str, Callable[[float, float], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
}


def parse_criterion(text: str) -> tuple[Callable[[float, float], bool], float]:
    """Comparison and bound of a criterion such as `>= 0.02`. Raises ScenarioError for anything else."""
    for sign in sorted(OPERATORS, key=len, reverse=True):
        if text.strip().startswith(sign):
            return OPERATORS[sign], float(text.strip()[len(sign) :])
    raise ScenarioError(f"criterion {text!r} has no comparison; use one of {', '.join(OPERATORS)} and a number")


def failed_criteria(trajectory: Trajectory) -> list[str]:
    """Criteria that a trial does not meet, such as `clearance_min_m >= 0.02 (0.013)`; timing ones only if trusted."""
    criteria = trajectory.problem.criteria
    if not criteria:
        return []
    load_builtin()
    kpis = default_registry.select(list(criteria))
    values, _ = evaluate_kpis(trajectory, kpis)
    failed = []
    for kpi in kpis:
        compare, bound = parse_criterion(criteria[kpi.name])
        value = values[kpi.name]
        if kpi.timing and trajectory.timing_contended:
            continue
        if isnan(value) or not compare(value, bound):
            failed.append(f"{kpi.name} {criteria[kpi.name]} ({value:.4g})")
    return failed
