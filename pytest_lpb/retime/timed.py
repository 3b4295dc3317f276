"""One planner in one scenario: the planner, its recorded trials, and the passes made so far."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_lpb.errors import in_one_line
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.retime.figures import PassTimes, RetimedRow, row_of
from pytest_lpb.retime.job import Job, Key
from pytest_lpb.retime.passes import Check, Pass, checked, median_of
from pytest_lpb.retime.replay import Replay
from pytest_lpb.trial.files import read_trial, trial_path
from pytest_lpb.trial.holder import PlannerHolder

MS_PER_S = 1e3


class Timed:
    """Builds the planner, and makes all its calls once, untimed.

    Args:
        job: has the trials.
        key: scenario and planner.
        configuration: the planner's.
    """

    def __init__(self, job: Job, key: Key, configuration: PlannerConfiguration) -> None:
        self._key = key
        self._job = job
        self._holder = PlannerHolder(configuration)
        self._passes: list[PassTimes] = []
        self._period_ms = 0.0
        self._check = self._checked(configuration)

    def _checked(self, configuration: PlannerConfiguration) -> Check:
        scenario, name = self._key
        title = f"{name} in {scenario}"
        files = (trial_path(self._job.run, scenario, name, seed) for seed in self._job.seeds(self._key))
        replays = [Replay(read_trial(file), configuration) for file in files]
        replays = [replay for replay in replays if len(replay.rows) > 1]
        if not replays:
            return Check(warnings=[f"{title} is left out: no trial has two calls of the planner"])
        self._period_ms = replays[0].period_ms
        try:
            return checked(self._holder.get(), replays, title)
        except Exception as error:
            # A planner's constructor may raise anything.
            return Check(warnings=[f"{title} is left out: the planner raised {in_one_line(error)}"])

    @property
    def planner(self) -> Planner:
        """The planner."""
        return self._holder.get()

    @property
    def warnings(self) -> list[str]:
        """What the untimed pass found."""
        return self._check.warnings

    def next_pass(self) -> Pass | None:
        """The next pass to make; None when no trial can be timed."""
        return Pass(self.planner, self._check.kept) if self._check.kept else None

    def record(self, made: Pass, times_s: Sequence[float]) -> None:
        """Keep what a pass measured: times of its calls [s]."""
        calls_ms = [MS_PER_S * time for time in times_s]
        self._passes.append(PassTimes(calls_ms, made.first_calls_ms, median_of(made.wall_per_cpu)))

    def calls_s(self) -> list[float]:
        """Times of all calls of all passes but the first of each trial [s]."""
        return [time / MS_PER_S for measured in self._passes for time in measured.calls]

    def row(self) -> RetimedRow | None:
        """The figures; None unless every pass was made."""
        if len(self._passes) < self._job.passes:
            return None
        check = self._check
        return row_of(*self._key, self._passes, check.first_calls_ms, self._period_ms, check.different)

    def close(self) -> None:
        """Close the planner."""
        self._holder.close()
