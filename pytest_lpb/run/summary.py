"""The summary table: success rates and KPIs of each planner, per scenario and over all of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pytest_lpb.run.problems import KpiColumn, prepare, restricted_column, unit_depends_on_control
from pytest_lpb.statistics import effective_size, wilson_interval

ALL = "all"
"""The `scenario` of rows over all scenarios."""

KEYS = ["scenario", "planner"]
COUNTS = ["trials", "problems", "successes"]
QUARTILES = {"median": 0.5, "q1": 0.25, "q3": 0.75}


def summary_table(trials: pd.DataFrame, kpis: Sequence[KpiColumn]) -> pd.DataFrame:
    """summary.csv: a row per scenario and planner, then one per planner with scenario `all`.

    Repeats of one problem are averaged first, so rates, quartiles and intervals are over distinct problems
    (timing KPIs: quartiles over trials). `successes` counts trials, `success_rate` is the mean over problems,
    with its Wilson interval. `all` is the mean over the scenarios that have a value, with summed counts; its
    interval is Wilson's at the `effective_size` of the scenarios' problems. Where a planner's scenarios have
    different control modes, `all` has no figures of KPIs whose unit depends on it.

    Args:
        trials: one row per trial, the columns of trials.csv and `duration_s`, in any order.
        kpis: the KPI columns to sum up.

    Returns:
        The columns of summary.csv in the contract's order, then `KPI_restricted_mean` of restricted KPIs: the
        mean over problems in which a failed trial counts its duration.
    """
    rows = prepare(trials, kpis)
    scenarios = _scenario_rows(rows, kpis)
    overall = _overall_rows(scenarios)
    modes = rows.groupby("planner")["control"].nunique()
    by_control = [f"{kpi.name}_{label}" for kpi in kpis if unit_depends_on_control(kpi) for label in QUARTILES]
    overall.loc[overall["planner"].isin(modes.index[modes > 1]), by_control] = np.nan
    return pd.concat([scenarios, overall], ignore_index=True) if len(scenarios) else scenarios


def _scenario_rows(rows: pd.DataFrame, kpis: Sequence[KpiColumn]) -> pd.DataFrame:
    names = [kpi.name for kpi in kpis]
    restricted = [restricted_column(kpi) for kpi in kpis if kpi.restricted_to_duration]
    by_trial = rows.groupby(KEYS)
    problems = rows.groupby([*KEYS, "problem"])[["success", *names, *restricted]].mean()
    by_problem = problems.groupby(KEYS)
    rate = by_problem["success"].mean()
    sizes = by_problem["success"].count()
    columns: dict[str, pd.Series] = {
        "trials": by_trial["success"].count(),
        "problems": sizes,
        "successes": by_trial["success"].sum().astype(np.int64),
        "success_rate": rate,
        **_wilson(rate, sizes.astype(np.float64)),
    }
    for kpi in kpis:
        values = (by_trial if kpi.timing else by_problem)[kpi.name]
        columns |= {f"{kpi.name}_{label}": values.quantile(q) for label, q in QUARTILES.items()}
        columns[f"{kpi.name}_n"] = by_problem[kpi.name].count()
    columns |= {name: by_problem[name].mean() for name in restricted}
    return pd.DataFrame(columns).reset_index()


def _overall_rows(scenarios: pd.DataFrame) -> pd.DataFrame:
    """The mean over scenarios of every figure, the sum of every count, one row per planner."""
    by_planner = scenarios.groupby("planner")
    figures = [name for name in scenarios.columns if name not in KEYS]
    counts = {name for name in figures if name in COUNTS or name.endswith("_n")}
    columns: dict[str, pd.Series] = {
        name: by_planner[name].sum() if name in counts else by_planner[name].mean() for name in figures
    }
    sizes = by_planner["problems"].agg(lambda problems: effective_size(problems.tolist()))
    columns |= _wilson(columns["success_rate"], sizes.astype(np.float64))
    overall = pd.DataFrame(columns).reset_index()
    overall.insert(0, "scenario", ALL)
    return overall


def _wilson(rate: pd.Series, size: pd.Series) -> dict[str, pd.Series]:
    """Wilson's interval of each rate, as the columns success_low and success_high."""
    ends = [wilson_interval(p * n, n) for p, n in zip(rate, size, strict=True)]
    return {
        "success_low": pd.Series([low for low, _ in ends], index=rate.index, dtype=np.float64),
        "success_high": pd.Series([high for _, high in ends], index=rate.index, dtype=np.float64),
    }
