"""The table of aggregates: each planner over all scenarios, KPI by KPI, on the problems that can be compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from pytest_lpb.run.contention import contended
from pytest_lpb.run.paired import Measure, generator
from pytest_lpb.run.problems import KpiColumn, prepare
from pytest_lpb.statistics import interquartile_interval, interquartile_mean, stratified_weights

COLUMNS = [
    "planner",
    "kpi",
    "over",
    "scenarios",
    "problems",
    "mean_of_scenarios",
    "iqm",
    "iqm_low",
    "iqm_high",
    "contended",
]
PROBLEM = ["scenario", "problem"]


def aggregates_table(trials: pd.DataFrame, kpis: Sequence[KpiColumn], rng_seed: int = 0) -> pd.DataFrame:
    """aggregates.csv: mean over scenarios and interquartile mean of each KPI and planner, in the KPI's unit.

    Every planner is looked at on the same problems: those of which each planner has a value, so that one that fails
    where it is hard does not look good (planners without any value are left out of this). Repeats of a problem are
    averaged. A failed trial counts its duration where the KPI is restricted to it; a KPI whose unit depends on the
    control mode has no values where the scenarios differ in it. Scenarios weigh the same.

    Args:
        trials: one row per trial, the columns of trials.csv and `duration_s`, in any order.
        kpis: the KPI columns to aggregate.
        rng_seed: together with planner and KPI it decides the bootstrap of a row.

    Returns:
        The columns of aggregates.csv; KPIs in the given order, in each the planners by name. No interval where every
        scenario has one problem, since nothing says how problems differ; `contended`: timing of a trial was disturbed.
    """
    rows = prepare(trials, kpis)
    planners = sorted(rows["planner"].unique())
    records = [record for kpi in kpis for record in _records(rows, Measure.of(kpi), planners, rng_seed)]
    return pd.DataFrame(records, columns=COLUMNS)


def _records(
    rows: pd.DataFrame, measure: Measure, planners: Sequence[str], rng_seed: int
) -> Iterator[tuple[object, ...]]:
    mixed = measure.by_control and rows["control"].nunique() > 1
    values = shared_values(rows.iloc[:0] if mixed else rows, measure.column)
    disturbed = bool(contended(rows, measure).any())
    for planner in planners:
        strata = _strata(values, planner)
        sizes = [len(stratum) for stratum in strata]
        yield (
            planner,
            measure.name,
            measure.over,
            len(sizes),
            sum(sizes),
            *_figures(strata, measure, planner, rng_seed),
            disturbed,
        )


def shared_values(rows: pd.DataFrame, column: str) -> pd.DataFrame:
    """Values on the problems of which every planner has one: a row per scenario and problem, a column per planner.

    Args:
        rows: as `prepare` gives them.
        column: of the values.
    """
    values = rows.groupby([*PROBLEM, "planner"])[column].mean().unstack("planner")
    return values.dropna(axis="columns", how="all").dropna()


def _strata(values: pd.DataFrame, planner: str) -> list[np.ndarray]:
    """A planner's values by scenario; none where it has no value at all."""
    if planner not in values.columns:
        return []
    return [group.to_numpy() for _, group in values[planner].groupby("scenario", sort=True)]


def _figures(strata: Sequence[np.ndarray], measure: Measure, planner: str, rng_seed: int) -> tuple[float, ...]:
    """Mean of the scenarios' means, interquartile mean, and its interval."""
    if not strata:
        return (float("nan"),) * 4
    pool = np.concatenate(strata)
    mean = float(np.mean([stratum.mean() for stratum in strata]))
    weights = stratified_weights([len(stratum) for stratum in strata])
    nan = float("nan")
    interval = (nan, nan)
    if len(pool) > len(strata):
        interval = interquartile_interval(strata, generator(rng_seed, planner, measure.name, "iqm"))
    return mean, interquartile_mean(pool, weights), *interval
