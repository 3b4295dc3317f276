"""Pairs a planner's trials with those of its baseline: by scenario, seed and problem."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pytest_lpb.run.baseline_file import rounded, short_hash
from pytest_lpb.run.contention import CONTENDED_KPIS, contended, with_contended_kpis
from pytest_lpb.run.margins import SUCCESS, Margin
from pytest_lpb.run.problems import KpiColumn, prepare, restricted_column
from pytest_lpb.statistics import paired_difference

OLD, NEW = "old", "new"
SEED = ["scenario", "seed"]
PROBLEM = ["scenario", "problem"]
ROUNDING = 1e-9  # of a division that gives a whole number
REPEAT = ("outcome", "node_id", "command")
NEEDED = ["scenario", "seed", "problem_hash", "success", "duration_s", "timing_contended"]
# What sorts trials where seeds are repeated; baselines have no need of it.
ABSENT: dict[str, Any] = {"attempt": 1, "trajectory_hash": "", "wall_s": 0.0}


@dataclass(frozen=True)
class Change:
    """A problem on which a planner is worse than its baseline."""

    scenario: str
    seed: int
    old: float
    new: float
    outcome: str  # of the new trial
    node_id: str
    command: str  # that repeats the new trial


@dataclass(frozen=True)
class LeftOut:
    """Problems that are not compared: (scenario, seed) of each."""

    missing: tuple[tuple[str, int], ...] = ()  # only the baseline has them
    new: tuple[tuple[str, int], ...] = ()  # only the run has them
    changed: tuple[tuple[str, int], ...] = ()  # both have them, but the problem is another one

    def of(self, scenarios: Collection[str] | None) -> LeftOut:
        """Those of some scenarios; None: all."""
        kinds = (self.missing, self.new, self.changed)
        return LeftOut(*(tuple(key for key in keys if scenarios is None or key[0] in scenarios) for keys in kinds))


class Sample(NamedTuple):
    """Values on the distinct problems that both have a value on, (n,) each."""

    old: NDArray[np.float64]
    new: NDArray[np.float64]


@dataclass(frozen=True)
class Pairing:
    """Trials of a planner and of its baseline on the same problems, a row per scenario, problem and seed."""

    old: pd.DataFrame
    new: pd.DataFrame
    left_out: LeftOut
    contended: frozenset[str]  # timing KPIs that other work on the same cores may have disturbed
    controls: int  # control modes, in which units of actions differ
    repeats: pd.DataFrame  # REPEAT of the new trials, by scenario and seed

    def sample(self, margin: Margin) -> Sample:
        """Values by distinct problem, repeats averaged."""
        pairs = self._pairs(margin)
        means = pairs.groupby(level=PROBLEM).mean()
        return Sample(means[OLD].to_numpy(), means[NEW].to_numpy())

    def _pairs(self, margin: Margin) -> pd.DataFrame:
        column = _column(margin)
        return pd.DataFrame({OLD: self.old[column], NEW: self.new[column]}).dropna()

    def further_seeds(self, margin: Margin, needed: int | None) -> int | None:
        """How many seeds more per scenario give as many problems with values as `needed`; None when no number does.

        Where nothing is drawn, further seeds are the same problem again.
        """
        given = self.old.reset_index().groupby("scenario")["problem"].agg(["size", "nunique"])
        valued = self._pairs(margin).reset_index().groupby("scenario")["problem"].nunique()
        drawn = (given["nunique"] > 1) | (given["size"] == 1)
        per_seed = float((valued / given["size"])[drawn].sum())  # problems with values, in all scenarios together
        if needed is None or per_seed == 0.0:
            return None
        return max(1, math.ceil((needed - int(valued.sum())) / per_seed - ROUNDING))

    def worse(self, margin: Margin) -> tuple[Change, ...]:
        """Problems on which the planner is worse, the worst first."""
        pairs = self._pairs(margin)
        sign = 1.0 if margin.kpi is not None and margin.kpi.direction == "lower" else -1.0
        pairs["loss"] = sign * paired_difference(pairs[OLD], pairs[NEW])
        worse = pairs[pairs["loss"] > 0].reset_index().join(self.repeats, on=SEED)
        worse = worse.sort_values(["loss", *SEED], ascending=[False, True, True])
        columns = (worse[name].tolist() for name in (*SEED, OLD, NEW, *REPEAT))
        return tuple(Change(*cells) for cells in zip(*columns, strict=True))


def _column(margin: Margin) -> str:
    """Column of `prepare` that holds what is compared; failures count the duration where a KPI says so."""
    if margin.kpi is None:
        return SUCCESS
    return restricted_column(margin.kpi) if margin.kpi.restricted_to_duration else margin.kpi.name


def pair(old: pd.DataFrame, new: pd.DataFrame, kpis: Sequence[KpiColumn]) -> Pairing:
    """Pair the trials of one planner of a baseline with those of one planner of a run."""
    both = pd.concat([_plain(old, OLD, kpis), _plain(new, NEW, kpis)], ignore_index=True)
    rows = prepare(both, kpis)
    sides = {side: rows[rows["planner"] == side].set_index([*PROBLEM, "seed"]).sort_index() for side in (OLD, NEW)}
    shared = sides[OLD].index.intersection(sides[NEW].index).sort_values()
    paired_old, paired_new = (sides[side].loc[shared] for side in (OLD, NEW))
    seeds_old, seeds_new, seeds_shared = (_seeds(index) for index in (sides[OLD].index, sides[NEW].index, shared))
    return Pairing(
        old=paired_old,
        new=paired_new,
        left_out=LeftOut(
            missing=tuple(sorted(seeds_old - seeds_new)),
            new=tuple(sorted(seeds_new - seeds_old)),
            changed=tuple(sorted((seeds_old & seeds_new) - seeds_shared)),
        ),
        contended=frozenset(kpi.name for kpi in kpis if _disturbed(paired_old, kpi) or _disturbed(paired_new, kpi)),
        controls=int(paired_new["control"].nunique()),
        repeats=new.set_index(SEED)[list(REPEAT)].sort_index(),
    )


def _plain(trials: pd.DataFrame, side: str, kpis: Sequence[KpiColumn]) -> pd.DataFrame:
    """Trials with rounded values and short hashes, so that a baseline file and a run folder say the same."""
    rows = trials[[*NEEDED, *(kpi.name for kpi in kpis)]].assign(
        planner=side, control=trials.get("control", ""), **{CONTENDED_KPIS: with_contended_kpis(trials, kpis)}, **ABSENT
    )
    rows["problem_hash"] = rows["problem_hash"].map(short_hash)
    for name in ("duration_s", *(kpi.name for kpi in kpis)):
        values = pd.to_numeric(rows[name]).astype(np.float64)
        rows[name] = [math.nan if (value := rounded(v)) is None else value for v in values.tolist()]
    return rows


def _disturbed(rows: pd.DataFrame, kpi: KpiColumn) -> bool:
    """A gate is stricter than a table: it judges no timing of a contended trial, whatever the KPI says of itself."""
    return kpi.timing and bool((rows["timing_contended"] | contended(rows, kpi)).any())


def _seeds(index: pd.Index[Any]) -> set[tuple[str, int]]:
    return {(str(scenario), int(seed)) for scenario, _, seed in index}
