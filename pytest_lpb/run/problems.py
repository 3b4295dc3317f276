"""From trials to problems: what both tables start from."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Protocol

import numpy as np
import pandas as pd

from pytest_lpb.kpis.derived import DIVERGED
from pytest_lpb.kpis.units import BY_CONTROL_MODE
from pytest_lpb.run.contention import CONTENDED_KPIS, with_contended_kpis

TRIAL_KEYS = ["scenario", "planner", "seed", "problem_hash", "attempt", "trajectory_hash", "wall_s"]
"""What sorts trials: tables do not depend on the order in which trials were run or read."""


class KpiColumn(Protocol):
    """What tables need to know of a KPI."""

    @property
    def name(self) -> str:
        """Column of trials.csv."""

    @property
    def unit(self) -> str:
        """Unit, as text."""

    @property
    def direction(self) -> str:
        """Which values are better: lower, higher or none."""

    @property
    def over(self) -> str:
        """Which trials it speaks of: solved or all."""

    @property
    def timing(self) -> bool:
        """Whether it measures the machine as well as the planner."""

    @property
    def restricted_to_duration(self) -> bool:
        """Whether a failed trial counts the scenario's duration in means and comparisons."""


def restricted_column(kpi: KpiColumn) -> str:
    """Column that holds a KPI with failures counted as the duration."""
    return restricted_name(kpi.name)


def restricted_name(kpi_name: str) -> str:
    """That column, by the KPI's name."""
    return f"{kpi_name}_restricted_mean"


def unit_depends_on_control(kpi: KpiColumn) -> bool:
    """Whether a KPI's unit is that of the actions, so that values of different control modes never mix."""
    return kpi.unit == BY_CONTROL_MODE


def prepare(trials: pd.DataFrame, kpis: Sequence[KpiColumn]) -> pd.DataFrame:
    """Trials in a fixed order, with numbers where they apply and NaN where they do not.

    Args:
        trials: one row per trial, the columns of trials.csv, `duration_s` and `control` (without it: one control
            mode), in any order.
        kpis: the KPI columns to keep.

    Returns:
        scenario, planner, seed, problem (see `_problems`), control, success (0.0 or 1.0), timing_contended,
        contended_kpis, one column per KPI (NaN for a failed trial where the KPI is over solved ones), and one
        `restricted_column` each.
    """
    rows = trials.assign(
        scenario=trials["scenario"].astype(str),
        planner=trials["planner"].astype(str),
        problem_hash=trials["problem_hash"].fillna("").astype(str),
    )
    rows = rows.sort_values(TRIAL_KEYS, kind="stable", ignore_index=True)
    solved = rows["success"].eq(True)
    columns = {
        "scenario": rows["scenario"],
        "planner": rows["planner"],
        "seed": rows["seed"],
        "problem": _problems(rows),
        "control": rows.get("control", ""),
        "success": solved.astype(np.float64),
        "timing_contended": rows["timing_contended"].eq(True),
        CONTENDED_KPIS: with_contended_kpis(rows, kpis),
    }
    for kpi in kpis:
        values = pd.to_numeric(rows[kpi.name]).astype(np.float64)
        values = values.where(values.abs() < DIVERGED)  # beyond, sums overflow
        columns[kpi.name] = values.where(solved) if kpi.over == "solved" else values
        if kpi.restricted_to_duration:
            columns[restricted_column(kpi)] = values.where(solved, _durations(rows))
    return pd.DataFrame(columns)


def _durations(rows: pd.DataFrame) -> pd.Series[float]:
    """Each trial's duration; where a crashed worker left none, its scenario's."""
    durations = rows["duration_s"].astype(np.float64)
    return durations.fillna(durations.groupby(rows["scenario"]).transform("max"))


def _problems(rows: pd.DataFrame) -> list[str]:
    """What stands for each trial's problem: its hash, or where a crashed worker left none, the best guess.

    The problem of a scenario and seed is the same for every planner; and where several seeds gave one
    problem, nothing is drawn. Failing both, the seed is a problem of its own, the same for all that crashed.
    """
    of_seed: dict[tuple[str, int], set[str]] = defaultdict(set)
    of_scenario: dict[str, set[str]] = defaultdict(set)
    seeds: dict[str, set[int]] = defaultdict(set)
    keys = list(zip(rows["scenario"], rows["seed"], rows["problem_hash"], strict=True))
    for scenario, seed, problem in keys:
        if problem:
            of_seed[scenario, seed].add(problem)
            of_scenario[scenario].add(problem)
            seeds[scenario].add(seed)
    problems = []
    for scenario, seed, problem in keys:
        guesses = of_seed.get((scenario, seed), set())
        if not guesses and len(seeds[scenario]) > 1:
            guesses = of_scenario[scenario]
        problems.append(problem or (next(iter(guesses)) if len(guesses) == 1 else f"seed{seed}"))
    return problems
