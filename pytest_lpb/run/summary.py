"""The summary table: success rates and KPIs of each planner, per scenario and over all of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from pytest_lpb.names import count
from pytest_lpb.run.contention import CONTENDED_KPIS, contended_names
from pytest_lpb.run.problems import KpiColumn, prepare, restricted_column, unit_depends_on_control
from pytest_lpb.statistics import effective_size, wilson_interval

ALL = "all"
"""The `scenario` of rows over all scenarios."""

KEYS = ["scenario", "planner"]
COUNTS = ["trials", "problems", "successes"]
QUARTILES = {"median": 0.5, "q1": 0.25, "q3": 0.75}
MEAN_OF_MEDIANS = "median_mean_of_scenarios"


def summary_table(trials: pd.DataFrame, kpis: Sequence[KpiColumn]) -> pd.DataFrame:
    """summary.csv: a row per scenario and planner, then one per planner with scenario `all`.

    Repeats of one problem are averaged first, so rates, quartiles and intervals are over distinct problems
    (timing KPIs: quartiles over trials). `successes` counts trials, `success_rate` is the mean over problems,
    with its Wilson interval. In `all`, counts are sums and `success_rate` is the mean over scenarios, with Wilson's
    interval at the `effective_size` of their problems, while median and quartiles are those of the problems of all
    scenarios in one pool; a mean of quartiles is no quartile. Where a planner's scenarios have different control
    modes, `all` has no figures of KPIs whose unit depends on it.

    Args:
        trials: one row per trial, the columns of trials.csv and `duration_s`, in any order.
        kpis: the KPI columns to sum up.

    Returns:
        The columns of summary.csv in the contract's order, then `KPI_restricted_mean` of restricted KPIs (the
        mean over problems in which a failed trial counts its duration), `success_rate_is` (what it is the mean of),
        `contended_kpis`, and in `all` `KPI_median_mean_of_scenarios`, the mean of the scenarios' medians.
    """
    rows = prepare(trials, kpis)
    names = [kpi.name for kpi in kpis]
    problems = rows.groupby([*KEYS, "problem"])[["success", *names, *_restricted(kpis)]].mean()
    scenarios = _scenario_rows(rows, problems, kpis)
    if not len(scenarios):
        return scenarios
    return pd.concat([scenarios, _overall_rows(rows, problems, scenarios, kpis)], ignore_index=True)


def _scenario_rows(rows: pd.DataFrame, problems: pd.DataFrame, kpis: Sequence[KpiColumn]) -> pd.DataFrame:
    by_problem = problems.groupby(KEYS)
    sizes, rate = by_problem["success"].count(), by_problem["success"].mean()
    columns: dict[str, pd.Series] = {
        "trials": rows.groupby(KEYS)["success"].count(),
        "problems": sizes,
        "successes": rows.groupby(KEYS)["success"].sum().astype(np.int64),
        "success_rate": rate,
        **_wilson(rate, sizes.astype(np.float64)),
        **_quartiles(rows, problems, kpis, KEYS),
        **{name: by_problem[name].mean() for name in _restricted(kpis)},
        "success_rate_is": _means_of(sizes, "problem"),
        CONTENDED_KPIS: contended_names(rows, KEYS, kpis),
    }
    return pd.DataFrame(columns).reset_index()


def _overall_rows(
    rows: pd.DataFrame, problems: pd.DataFrame, scenarios: pd.DataFrame, kpis: Sequence[KpiColumn]
) -> pd.DataFrame:
    """One row per planner: sums of counts, means over scenarios of rates, quartiles of all problems."""
    by_planner = scenarios.groupby("planner")
    rate, number = by_planner["success_rate"].mean(), by_planner.size()
    sizes = by_planner["problems"].agg(lambda each: effective_size(each.tolist()))
    columns: dict[str, pd.Series] = {
        **{name: by_planner[name].sum() for name in COUNTS},
        "success_rate": rate,
        **_wilson(rate, sizes.astype(np.float64)),
        **_quartiles(rows, problems, kpis, ["planner"]),
        **{name: by_planner[name].mean() for name in _restricted(kpis)},
        "success_rate_is": _means_of(number, "scenario").where(number > 1, by_planner["success_rate_is"].first()),
        CONTENDED_KPIS: contended_names(rows, ["planner"], kpis),
        **{f"{kpi.name}_{MEAN_OF_MEDIANS}": by_planner[f"{kpi.name}_median"].mean() for kpi in kpis},
    }
    overall = pd.DataFrame(columns).reset_index()
    modes = rows.groupby("planner")["control"].nunique()
    figures = (*QUARTILES, MEAN_OF_MEDIANS)
    by_control = [f"{kpi.name}_{label}" for kpi in kpis if unit_depends_on_control(kpi) for label in figures]
    overall.loc[overall["planner"].isin(modes.index[modes > 1]), by_control] = np.nan
    overall.insert(0, "scenario", ALL)
    return overall


def _quartiles(
    rows: pd.DataFrame, problems: pd.DataFrame, kpis: Sequence[KpiColumn], keys: list[str]
) -> dict[str, pd.Series]:
    """Median and quartiles of each KPI over the problems of each group, of timing over its trials; problems counted."""
    by_problem, by_trial = problems.groupby(keys), rows.groupby(keys)
    columns: dict[str, pd.Series] = {}
    for kpi in kpis:
        values = (by_trial if kpi.timing else by_problem)[kpi.name]
        columns |= {f"{kpi.name}_{label}": values.quantile(q) for label, q in QUARTILES.items()}
        columns[f"{kpi.name}_n"] = by_problem[kpi.name].count()
    return columns


def _restricted(kpis: Sequence[KpiColumn]) -> list[str]:
    return [restricted_column(kpi) for kpi in kpis if kpi.restricted_to_duration]


def _means_of(sizes: pd.Series, noun: str) -> pd.Series:
    """What each rate is the mean of, in words: `mean of 3 scenarios`."""
    return sizes.map(lambda size: f"mean of {count(size, noun)}").astype(object)


def _wilson(rate: pd.Series, size: pd.Series) -> dict[str, pd.Series]:
    """Wilson's interval of each rate, as the columns success_low and success_high."""
    ends = [wilson_interval(p * n, n) for p, n in zip(rate, size, strict=True)]
    return {
        "success_low": pd.Series([low for low, _ in ends], index=rate.index, dtype=np.float64),
        "success_high": pd.Series([high for _, high in ends], index=rate.index, dtype=np.float64),
    }
