"""Passes through the recorded calls of one planner in one scenario; what is not the planner's stays off the clock."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from time import perf_counter_ns, thread_time_ns
from typing import Any

import numpy as np

from pytest_lpb.errors import LpbError, in_one_line
from pytest_lpb.planner.base import Planner
from pytest_lpb.retime.replay import Replay

NS_PER_MS = 1e6


@dataclass
class Check:
    """What an untimed pass found."""

    kept: list[Replay] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    different: int = 0  # trials whose actions differ from the recorded ones
    first_calls_ms: list[float] = field(default_factory=list)


def checked(planner: Planner, replays: Sequence[Replay], title: str) -> Check:
    """Make all calls once, before any is timed: are the actions those recorded? Trials that raise are left out."""
    check = Check()
    for replay in replays:
        where = f"{title}, seed {replay.seed}"
        try:
            different = _different_rows(planner, replay, check)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            # A planner may raise anything, as in a trial.
            check.warnings.append(f"{where} is left out: the planner raised {in_one_line(error)}")
            continue
        check.kept.append(replay)
        if different:
            check.different += 1
            check.warnings.append(
                f"{where}: actions differ from the recorded ones in {len(different)} of {len(replay.rows)} calls, "
                f"first in row {different[0]}: what is timed is not what the trial computed"
            )
    return check


def _different_rows(planner: Planner, replay: Replay, check: Check) -> list[int]:
    """Rows whose action is not the recorded one; the first call is timed: in a new process it is the coldest."""
    different = []
    replay.set_up(planner)
    for row, seen in zip(replay.rows, replay.observations(), strict=True):
        started = perf_counter_ns()
        result = planner.compute_action(seen)
        ended = perf_counter_ns()
        if row == replay.rows[0]:
            check.first_calls_ms.append((ended - started) / NS_PER_MS)
        planner.diagnostics = {}
        try:
            same = replay.is_recorded(row, result)
        except LpbError:
            same = False
        if not same:
            different.append(row)
    return different


class Pass:
    """One pass: hands out the observations of all trials in order, and sets the planner up before each trial.

    The first call of each trial is made here, so that it is apart from the others.

    Args:
        planner: the planner.
        replays: the trials, each with two calls or more.
    """

    def __init__(self, planner: Planner, replays: Sequence[Replay]) -> None:
        self._planner = planner
        self._replays = replays
        self._calls = self._walk()
        self._started_ns = (0, 0)
        self.first_calls_ms: list[float] = []
        self.wall_per_cpu: list[float] = []  # of each call but the last, the timer's own work included
        self.rounds = sum(len(replay.rows) - 1 for replay in replays)

    def next_observation(self) -> tuple[tuple[dict[str, Any]], dict[str, Any]]:
        """Arguments of the next call; off the clock."""
        self._end_window()
        self._planner.diagnostics = {}
        seen = next(self._calls)
        self._started_ns = (perf_counter_ns(), thread_time_ns())
        return (seen,), {}

    def _end_window(self) -> None:
        wall, cpu = perf_counter_ns(), thread_time_ns()
        wall_started, cpu_started = self._started_ns
        if wall_started and cpu > cpu_started:
            self.wall_per_cpu.append((wall - wall_started) / (cpu - cpu_started))

    def _walk(self) -> Iterator[dict[str, Any]]:
        for replay in self._replays:
            replay.set_up(self._planner)
            seen = replay.observation(replay.rows[0])
            started = perf_counter_ns()
            self._planner.compute_action(seen)
            self.first_calls_ms.append((perf_counter_ns() - started) / NS_PER_MS)
            for row in replay.rows[1:]:
                self._planner.diagnostics = {}
                yield replay.observation(row)


def median_of(ratios: Sequence[float]) -> float:
    """Median of ratios; 1 without any."""
    return float(np.median(ratios)) if ratios else 1.0
