"""The comparisons table: every pair of planners, on the problems they share."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pandas as pd

from pytest_lpb.run.contention import contended as contended_trials
from pytest_lpb.run.paired import SUCCESS, Figures, Measure, Sample, compare, generator
from pytest_lpb.run.problems import KpiColumn, prepare
from pytest_lpb.run.summary import ALL
from pytest_lpb.run.verdict import verdict
from pytest_lpb.statistics import holm

COLUMNS = [
    "planner_a",
    "planner_b",
    "scenario",
    "kpi",
    "over",
    "pairs",
    "median_a",
    "median_b",
    "difference",
    "difference_low",
    "difference_high",
    "ratio",
    "p",
    "p_adjusted",
    "improvement_probability",
    "verdict",
]
PROBLEM = ["scenario", "problem"]


class _Comparison(NamedTuple):
    planner_a: str
    planner_b: str
    scenario: str
    measure: Measure
    figures: Figures
    contended: bool


def comparisons_table(trials: pd.DataFrame, kpis: Sequence[KpiColumn], rng_seed: int = 0) -> pd.DataFrame:
    """comparisons.csv: each pair of planners per scenario and over all, for success and every KPI.

    Trials are paired by scenario, seed and problem; repeats of one problem are averaged, so `pairs` counts
    distinct problems. KPIs over solved trials compare problems both solved; a failed trial counts its
    duration where the KPI is restricted to it. p values are adjusted by Holm over the planner pairs of a KPI
    and scenario. `all` of a KPI whose unit depends on the control mode has no pairs where the scenarios differ
    in it. See docs/statistics.md for the tests, intervals and verdicts.

    Args:
        trials: one row per trial, the columns of trials.csv and `duration_s`, in any order.
        kpis: the KPI columns to compare.
        rng_seed: together with planners, scenario and KPI it decides the bootstrap of a row.

    Returns:
        The columns of comparisons.csv; pairs by planner name, then scenarios by name and `all`, then success
        and the KPIs in the given order. Scenarios that only one planner of a pair has run have no rows.
    """
    rows = prepare(trials, kpis)
    measures = [SUCCESS, *map(Measure.of, kpis)]
    compared = [
        comparison
        for a, b in combinations(sorted(rows["planner"].unique()), 2)
        for comparison in _pair(rows, a, b, measures, rng_seed)
    ]
    adjusted = _adjust(compared)
    return pd.DataFrame([_record(item, p) for item, p in zip(compared, adjusted, strict=True)], columns=COLUMNS)


def _pair(rows: pd.DataFrame, a: str, b: str, measures: Sequence[Measure], rng_seed: int) -> Iterator[_Comparison]:
    """Every comparison of planners a and b: each scenario, then all of them."""
    both = rows[rows["planner"].isin([a, b])]
    tested = both.groupby("scenario")["planner"].nunique()
    scenarios = sorted(tested.index[tested == 2])
    contended = {measure.name: _contended(both, measure) for measure in measures}
    samples = _samples(both, a, b, measures)
    for scenario in scenarios:
        for measure in measures:
            rng = generator(rng_seed, a, b, scenario, measure.name)
            figures = compare([samples[scenario, measure.column]], measure, rng)
            yield _Comparison(a, b, scenario, measure, figures, scenario in contended[measure.name])
    if not scenarios:
        return
    mixed = both.loc[both["scenario"].isin(scenarios), "control"].nunique() > 1
    for measure in measures:
        pooled = [] if measure.by_control and mixed else scenarios
        label = scenarios[0] if len(scenarios) == 1 else ALL
        rng = generator(rng_seed, a, b, label, measure.name)
        figures = compare([samples[scenario, measure.column] for scenario in pooled], measure, rng)
        yield _Comparison(a, b, ALL, measure, figures, bool(contended[measure.name] & set(scenarios)))


def _contended(rows: pd.DataFrame, measure: Measure) -> set[str]:
    """Scenarios in which a trial's value was disturbed by other work on the same cores."""
    return set(rows.loc[contended_trials(rows, measure), "scenario"])


def _samples(rows: pd.DataFrame, a: str, b: str, measures: Sequence[Measure]) -> dict[tuple[str, str], Sample]:
    """Values of both planners on each distinct problem, by scenario and column."""
    columns = [measure.column for measure in measures]
    cells = rows.groupby(["planner", *PROBLEM, "seed"])[columns].mean()
    cells_a, cells_b = (cells.loc[[planner]].droplevel("planner") for planner in (a, b))
    shared = cells_a.index.intersection(cells_b.index).sort_values()
    values_a, values_b = cells_a.loc[shared], cells_b.loc[shared]
    unknown = values_a.isna() | values_b.isna()
    means_a, means_b = (values.mask(unknown).groupby(PROBLEM).mean() for values in (values_a, values_b))
    samples: dict[tuple[str, str], Sample] = defaultdict(lambda: (np.empty(0), np.empty(0)))
    for scenario, in_scenario in means_a.groupby("scenario").indices.items():
        x, y = (means.iloc[in_scenario].to_numpy() for means in (means_a, means_b))
        for index, column in enumerate(columns):
            samples[str(scenario), column] = (x[:, index], y[:, index])
    return samples


def _adjust(compared: Sequence[_Comparison]) -> list[float]:
    """Holm over the planner pairs of each KPI and scenario."""
    families: dict[tuple[str, str], list[int]] = defaultdict(list)
    for index, item in enumerate(compared):
        families[item.measure.name, item.scenario].append(index)
    adjusted = np.full(len(compared), np.nan)
    for members in families.values():
        adjusted[members] = holm([compared[index].figures.p for index in members])
    return adjusted.tolist()


def _record(item: _Comparison, p_adjusted: float) -> tuple[object, ...]:
    figures = item.figures
    return (
        item.planner_a,
        item.planner_b,
        item.scenario,
        item.measure.name,
        item.measure.over,
        figures.pairs,
        figures.median_a,
        figures.median_b,
        figures.difference,
        figures.difference_low,
        figures.difference_high,
        figures.ratio,
        figures.p,
        p_adjusted,
        figures.improvement_probability,
        verdict(item.measure, figures, p_adjusted, item.contended),
    )
