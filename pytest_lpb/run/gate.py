"""The regression gate: is a planner still as good as its baseline, on the problems that both were given?"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import pandas as pd

from pytest_lpb.names import count
from pytest_lpb.run.baseline import Baseline
from pytest_lpb.run.gate_pairs import Change, LeftOut, Pairing, pair
from pytest_lpb.run.margins import Margin
from pytest_lpb.run.problems import unit_depends_on_control
from pytest_lpb.statistics import decided, deciding_pairs, loss_of_means, loss_of_rates
from pytest_lpb.statistics.loss import Loss

MIN_PROBLEMS = 20
"""With fewer common problems a verdict would say more about them than about the planner."""

SAME, REGRESSED, INCONCLUSIVE = "same or better", "regressed", "inconclusive"
VERDICTS = {False: SAME, True: REGRESSED, None: INCONCLUSIVE}


@dataclass(frozen=True)
class GateVerdict:
    """What is said of one planner and one KPI. Losses are positive where the planner is worse than its baseline."""

    planner: str
    baseline: str  # the baseline's planner
    margin: Margin
    verdict: str
    reason: str  # why it is inconclusive; else empty
    problems: int  # that both have a value on
    old: float = math.nan  # mean over these problems
    new: float = math.nan
    loss: float = math.nan  # in the margin's terms: a share, or in the KPI's unit
    loss_low: float = math.nan  # one-sided 95 % bounds
    loss_high: float = math.nan
    further_seeds: int | None = None  # per scenario, that would decide
    changes: tuple[Change, ...] = ()  # worse problems, the worst first


@dataclass(frozen=True)
class GateResult:
    """All verdicts of a run."""

    baseline: str
    inconclusive_fails: bool
    verdicts: Sequence[GateVerdict] = ()
    left_out: Mapping[str, LeftOut] = field(default_factory=dict)  # by planner
    unknown: Sequence[str] = ()  # planners of the run that the baseline does not know
    warnings: Sequence[str] = ()  # of evaluating the baseline

    def count(self, verdict: str) -> int:
        """How many verdicts are this one."""
        return sum(entry.verdict == verdict for entry in self.verdicts)

    def of(self, planners: Collection[str] | None, scenarios: Collection[str] | None = None) -> GateResult:
        """The verdicts on some planners; and of the problems left out, those of some scenarios. None: all."""
        planners = planners or {entry.planner for entry in self.verdicts} | set(self.unknown)
        return replace(
            self,
            verdicts=[entry for entry in self.verdicts if entry.planner in planners],
            left_out={name: entry.of(scenarios) for name, entry in self.left_out.items() if name in planners},
            unknown=[name for name in self.unknown if name in planners],
        )

    @property
    def sure(self) -> bool:
        """Whether every verdict is one."""
        return self.count(INCONCLUSIVE) == 0

    @property
    def closed(self) -> bool:
        """Whether the run is to fail."""
        return self.count(REGRESSED) > 0 or (self.inconclusive_fails and self.count(INCONCLUSIVE) > 0)


@dataclass(frozen=True)
class Gate:
    """What is compared with what, and how much worse it may be."""

    baseline: Baseline
    margins: Sequence[Margin]
    inconclusive_fails: bool = False

    def judge(self, trials: pd.DataFrame, machine: Mapping[str, Any]) -> GateResult:
        """Judge every planner that the baseline knows.

        Args:
            trials: of the run: columns of trials.csv, `duration_s`, `command`, and the KPIs of all margins.
            machine: as run.json describes it.

        Raises:
            ConfigurationError: the baseline has none of the planners.
        """
        planners = [str(name) for name in sorted(trials["planner"].unique())]
        if not planners:
            return GateResult(self.baseline.name, self.inconclusive_fails)
        kpis = [margin.kpi for margin in self.margins if margin.kpi is not None]
        verdicts, left_out = [], {}
        counterparts = self.baseline.counterparts(planners)
        elsewhere = _differences(self.baseline.machine, machine)
        for planner, counterpart in counterparts.items():
            old = self.baseline.trials(counterpart, trials, [kpi.name for kpi in kpis])
            pairing = pair(old, trials[trials["planner"] == planner], kpis)
            left_out[planner] = pairing.left_out
            verdicts += [_judge(planner, counterpart, margin, pairing, elsewhere) for margin in self.margins]
        unknown = [name for name in planners if name not in counterparts and name not in counterparts.values()]
        warnings = tuple(self.baseline.warnings)
        return GateResult(self.baseline.name, self.inconclusive_fails, verdicts, left_out, unknown, warnings)


def _differences(old: Mapping[str, Any] | None, new: Mapping[str, Any]) -> list[str]:
    """In what a machine is not the baseline's."""
    return [] if old is None else sorted(key for key in {*old, *new} if old.get(key) != new.get(key))


def _judge(planner: str, counterpart: str, margin: Margin, pairing: Pairing, elsewhere: Collection[str]) -> GateVerdict:
    sample = pairing.sample(margin)
    problems = len(sample.old)
    if not problems:
        reason = "no problem in common" if pairing.old.empty else "no problem has a value with both"
        return GateVerdict(planner, counterpart, margin, INCONCLUSIVE, reason, 0)
    old, new = float(sample.old.mean()), float(sample.new.mean())
    try:
        loss = _loss(margin, sample.old, sample.new)
    except ZeroDivisionError:
        reason = "the baseline's mean is 0, of which there is no percentage: give a margin in the KPI's unit"
        return GateVerdict(planner, counterpart, margin, INCONCLUSIVE, reason, problems, old, new)
    low, high = loss.bounds()
    verdict = VERDICTS[decided(loss, margin.value)]
    reason = _obstacle(margin, pairing, elsewhere)
    further = None
    if reason:
        verdict = INCONCLUSIVE
    elif problems < MIN_PROBLEMS:
        verdict = INCONCLUSIVE
        reason = f"{count(problems, 'common problem')}; {MIN_PROBLEMS} are needed"
        further = pairing.further_seeds(margin, deciding_pairs(loss, margin.value, MIN_PROBLEMS) or MIN_PROBLEMS)
    elif verdict == INCONCLUSIVE:
        reason = f"the loss may be {margin.text(low, high)}"
        further = pairing.further_seeds(margin, deciding_pairs(loss, margin.value, MIN_PROBLEMS))
    changes = pairing.worse(margin)
    return GateVerdict(
        planner, counterpart, margin, verdict, reason, problems, old, new, loss.estimate, low, high, further, changes
    )


def _loss(margin: Margin, old: Any, new: Any) -> Loss:
    if margin.kpi is None:
        return loss_of_rates(old, new)
    return loss_of_means(old, new, margin.kpi.direction, relative=margin.relative)


def _obstacle(margin: Margin, pairing: Pairing, elsewhere: Collection[str]) -> str:
    """Why nothing can be said, however many problems there are; empty when something can."""
    if margin.timing and elsewhere:
        return f"the baseline is of another machine ({', '.join(elsewhere)} differ)"
    if margin.name in pairing.contended:
        return "timing was contended: other work ran on the same cores"
    if margin.kpi is not None and unit_depends_on_control(margin.kpi) and pairing.controls > 1:
        return "its unit depends on the control mode, in which the scenarios differ"
    return ""
