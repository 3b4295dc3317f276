"""KPIs about a planner's own solver, by what it records at each call."""

from __future__ import annotations

import math

import numpy as np

from pytest_lpb.kpis.registry import kpi
from pytest_lpb.trajectory import Trajectory


@kpi("infeasible_rate", "1", "lower", "all", group="solver")
def infeasible_rate(trajectory: Trajectory) -> float:
    """Share of calls in which the planner's own solver found no solution; NaN where it records no `solved`."""
    if "planner_solved" not in trajectory.columns:
        return math.nan
    solved = trajectory.planner("solved")
    asked = solved[np.isfinite(solved)]
    return float(1.0 - asked.mean()) if len(asked) else math.nan
