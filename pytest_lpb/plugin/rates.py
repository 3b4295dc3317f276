"""`--lpb-assert=rate`: a planner's success rate against the scenario's `rate`, judged when all trials are done."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from pytest_lpb.names import count
from pytest_lpb.problem.criterion import parse_criterion
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.statistics.intervals import wilson_interval
from pytest_lpb.trial.files import read_trial, trial_path


@dataclass(frozen=True)
class RateVerdict:
    """Whether a planner's success rate in a scenario meets its criterion."""

    scenario: str
    planner: str
    met: bool
    text: str


def judge_rates(trials: pd.DataFrame, run: RunFolder) -> list[RateVerdict]:
    """One verdict per scenario that names a rate and planner; problems that repeat count once, as everywhere."""
    verdicts = []
    for (scenario, planner), rows in trials.groupby(["scenario", "planner"], sort=True):
        seed = int(rows["seed"].iloc[0])
        problem = read_trial(trial_path(run.path, str(scenario), str(planner), seed)).problem
        criterion = problem.entry["success"].get("rate")
        if criterion is not None:
            verdicts.append(_judge(str(scenario), str(planner), rows, criterion))
    return verdicts


def _judge(scenario: str, planner: str, rows: pd.DataFrame, criterion: str) -> RateVerdict:
    rates = rows.groupby("problem_hash")["success"].mean()
    rate = float(rates.mean())
    low, high = wilson_interval(float(rates.sum()), len(rates))
    failed = sorted(rows.loc[~rows["success"].astype(bool), "seed"].tolist())
    seeds = ", ".join(map(str, failed[:20])) + (", ..." if len(failed) > 20 else "")
    met = parse_criterion(criterion).met(rate)
    text = (
        f"{scenario} :: {planner}: success rate {rate:.3f} (95 % interval {low:.3f} to {high:.3f}, "
        f"{count(len(rates), 'problem')}), required {criterion}"
    )
    return RateVerdict(scenario, planner, met, text if met or not failed else f"{text}; unsolved seeds: {seeds}")
