"""Equal faults of many trials as one: what went wrong, where, and how often."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pytest_lpb.names import count
from pytest_lpb.trial.outcome import INFEASIBLE, SOFTWARE_FAULTS, WORKER_CRASH

FAULTS = (*SOFTWARE_FAULTS, INFEASIBLE, WORKER_CRASH)  # outcomes whose messages name a cause
_TIME = re.compile(r"^[a-z ]+ (at t = \S+ s): ")  # how such messages begin
_PLACE = re.compile(r" \(\S.*:\d+\)$")  # file and line that raised
_NUMBER = re.compile(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?|\bnan\b|[-+]?\binf\b", re.IGNORECASE)


@dataclass(frozen=True)
class FaultGroup:
    """Trials of a planner that ended by the same fault.

    Attributes:
        planner: its name.
        outcome: of each of the trials.
        cause: what went wrong, with file and line, as the first of them says.
        node_ids: of the trials, in order.
        command: that repeats the first.
    """

    planner: str
    outcome: str
    cause: str
    node_ids: tuple[str, ...]
    command: str

    @property
    def count(self) -> str:
        """Such as `22 trials`."""
        return count(len(self.node_ids), "trial")

    @property
    def line(self) -> str:
        """Such as `22 trials of dwa: planner_error: AttributeError: no attribute 'x' (dwa.py:27)`."""
        return f"{self.count} of {self.planner}: {self.outcome}: {below_here(self.cause)}"


def cause_and_time(message: str) -> tuple[str, str]:
    """What went wrong, of a trial's message, and when, such as `at t = 0.15 s`; empty where it does not say."""
    found = _TIME.match(message)
    return (message[found.end() :], found.group(1)) if found else (message, "")


def fault_key(planner: str, outcome: str, message: str) -> tuple[str, str, str]:
    """What equal faults share: numbers in the text may differ, the place that raised may not."""
    cause, _ = cause_and_time(message)
    place = _PLACE.search(cause)
    text = cause[: place.start()] if place else cause
    return planner, outcome, _NUMBER.sub("#", text) + (place.group() if place else "")


def fault_groups(trials: Iterable[Mapping[Any, Any]]) -> list[FaultGroup]:
    """Faults of trials, the most frequent first.

    Args:
        trials: with planner, outcome, message, node_id and command each; those of other outcomes are left out.
    """
    groups: dict[tuple[str, str, str], list[Mapping[Any, Any]]] = {}
    for trial in trials:
        if trial["outcome"] in FAULTS:
            key = fault_key(str(trial["planner"]), str(trial["outcome"]), str(trial["message"]))
            groups.setdefault(key, []).append(trial)
    found = [
        FaultGroup(
            planner,
            outcome,
            cause_and_time(str(rows[0]["message"]))[0],
            tuple(str(row["node_id"]) for row in rows),
            str(rows[0]["command"]),
        )
        for (planner, outcome, _), rows in groups.items()
    ]
    return sorted(found, key=lambda group: -len(group.node_ids))


def below_here(text: str) -> str:
    """A text whose paths below the current folder are relative to it."""
    return text.replace(f"({Path.cwd()}/", "(")
