"""Performance profiles of planners: on which share of the problems a KPI is within a bound, as a curve per planner."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pytest_lpb.run.aggregates import PROBLEM
from pytest_lpb.run.paired import generator
from pytest_lpb.run.problems import KpiColumn, prepare, unit_depends_on_control
from pytest_lpb.statistics import performance_ratios, pointwise_band, shares_within

FloatArray = NDArray[np.float64]
POINTS = 161  # of a curve
RATIO, VALUE = "ratio", "value"


@dataclass(frozen=True)
class Curve:
    """Share of problems within each bound, with the ends of its pointwise 95 % interval; each (m,)."""

    share: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class KpiProfile:
    """The curves of one KPI.

    Attributes:
        kind: `ratio`: bounds are factors of the best planner's value on the same problem (Dolan & Moré 2002).
            `value`: bounds are values, a score distribution (Agarwal et al. 2021).
        at_least: whether values count from the bound up, as higher ones are better.
        bounds: (m,).
        curves: by planner.
    """

    kpi: str
    unit: str
    kind: str
    at_least: bool
    scenarios: int
    problems: int
    bounds: FloatArray
    curves: Mapping[str, Curve]


def kpi_profile(trials: pd.DataFrame, kpi: KpiColumn, rng_seed: int = 0) -> KpiProfile | None:
    """The profile of a KPI over the problems that every planner was given; scenarios weigh the same.

    A problem that a planner did not solve is within no bound, for KPIs over solved trials and for those restricted to
    the duration; of other KPIs, problems without a value for each planner are left out. Repeats of a problem are
    averaged, and must all be solved.

    Costs of several planners, positive and better when lower, are seen as ratios to the best; anything else as values.

    Args:
        trials: one row per trial, the columns of trials.csv and `duration_s`, in any order.
        kpi: the KPI's column.
        rng_seed: together with planner and KPI it decides the bootstrap of a curve.

    Returns:
        None where neither direction is better, where control modes with other units mix, and without values.
    """
    rows = prepare(trials, [kpi])
    if kpi.direction == "none" or (unit_depends_on_control(kpi) and rows["control"].nunique() > 1):
        return None
    at_least = kpi.direction == "higher"
    costs = _costs(rows, kpi, sign=-1.0 if at_least else 1.0)
    finite = costs.to_numpy()[np.isfinite(costs.to_numpy())]
    if not len(finite):
        return None
    kind = RATIO if not at_least and len(costs.columns) > 1 and finite.min() > 0 else VALUE
    ratios = performance_ratios(costs) if kind == RATIO else costs
    seen = pd.DataFrame(ratios, index=costs.index, columns=costs.columns)
    bounds = _bounds(seen.to_numpy(), kind)
    curves = {str(planner): _curve(seen[planner], bounds, kpi.name, str(planner), rng_seed) for planner in seen.columns}
    scenarios = costs.index.get_level_values("scenario").nunique()
    shown = -bounds if at_least else bounds
    return KpiProfile(kpi.name, kpi.unit, kind, at_least, scenarios, len(costs), shown, curves)


def _costs(rows: pd.DataFrame, kpi: KpiColumn, sign: float) -> pd.DataFrame:
    """Values, better when lower, of each problem and planner; inf where it was not solved."""
    values = sign * rows[kpi.name]
    if kpi.over == "solved" or kpi.restricted_to_duration:
        values = values.where(rows["success"] > 0).fillna(np.inf)
    cells = rows.assign(cost=values).groupby([*PROBLEM, "planner"])["cost"]
    return cells.mean().unstack("planner").dropna()


def _bounds(seen: FloatArray, kind: str) -> FloatArray:
    """Bounds from the best to the worst that was reached, of ratios evenly in their logarithm."""
    finite = seen[np.isfinite(seen)]
    least, most = float(finite.min()), float(finite.max())
    if kind == RATIO:
        return np.concatenate([np.geomspace(1.0, max(most, 1.0 + 1e-9), POINTS - 1), [1.05 * most]])
    margin = 0.05 * (most - least) or max(0.05 * abs(most), 1e-9)
    return np.linspace(least - margin, most + margin, POINTS)


def _curve(values: pd.Series[float], bounds: FloatArray, kpi: str, planner: str, rng_seed: int) -> Curve:
    strata = [np.asarray(group, dtype=np.float64) for _, group in values.groupby("scenario", sort=True)]
    low, high = pointwise_band(strata, bounds, generator(rng_seed, planner, kpi, "profile"))
    return Curve(shares_within(strata, bounds), low, high)
