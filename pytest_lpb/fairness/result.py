"""What the check found, in the run folder and in words."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from pydantic import TypeAdapter

from pytest_lpb.bounded import read_bounded
from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.errors import RecordingError, in_one_line

FAIRNESS_FILE = "fairness.json"
SCHEMA_VERSION = 1
MAX_BYTES = 10_000_000
MAX_NAMED = 5  # trials that a sentence names


@dataclass(frozen=True)
class Fairness:
    """What came out when trials of a run were run again, and scenes moved.

    Attributes:
        trials: number of trials run again, by planner.
        random: trials that differ from one process to the next, though each began it.
        dependent: trials that depend on what was run before them in the same process.
        unanswered: trials that could not be run again, with the reason.
        blind: scenarios by planner in which the first action stays the same whatever of the scene is moved.
        goal_unseen: scenarios by planner in which only obstacles change it.
        obstacles_unseen: scenarios by planner in which only the goal changes it.
    """

    trials: Mapping[str, int]
    random: Sequence[str] = ()
    dependent: Sequence[str] = ()
    unanswered: Mapping[str, str] = field(default_factory=dict)
    blind: Mapping[str, Sequence[str]] = field(default_factory=dict)
    goal_unseen: Mapping[str, Sequence[str]] = field(default_factory=dict)
    obstacles_unseen: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def faults(self) -> Iterator[str]:
        """What must not be, a sentence each."""
        if self.dependent:
            yield (
                "isolation: these trials came out otherwise when they were run alone or in another order, so they "
                f"depend on the trials before them (setup must forget): {_named(self.dependent)}"
            )
        if self.random:
            yield (
                "isolation: these trials come out otherwise each time, even alone (random numbers that are not "
                f"seeded, the clock, the order of a set): {_named(self.random)}"
            )
        for trial, reason in self.unanswered.items():
            yield f"isolation: {trial} could not be run again: {reason}"
        for planner, scenarios in self.blind.items():
            yield (
                f"scene: the first action of {planner} stays the same wherever goal and obstacles are moved, "
                f"in {_named(scenarios)}: it looks at neither, or remembers an old scene"
            )
        for planner, scenarios in self.goal_unseen.items():
            yield (
                f"scene: the first action of {planner} stays the same wherever the goal is moved, "
                f"in {_named(scenarios)}: it does not look at it, or remembers an old one"
            )

    def notes(self) -> Iterator[str]:
        """What a reader should know, a sentence each."""
        total = sum(self.trials.values())
        if not (self.dependent or self.random or self.unanswered):
            what = "trial" if total == 1 else "trials"
            told = ", ".join(f"{count} of {planner}" for planner, count in sorted(self.trials.items()))
            yield (
                f"Isolation checked: {total} {what} ({told}) run again in processes of their own and in reverse "
                "order came out the same to the last bit."
            )
        for planner, scenarios in self.obstacles_unseen.items():
            yield f"The first action of {planner} depends on no obstacle's place in {_named(scenarios)}."

    def write(self, run: Path) -> None:
        """Keep it in the run folder. Raises RecordingError."""
        content = {"schema_version": SCHEMA_VERSION, **asdict(self)}
        replace_file(run / FAIRNESS_FILE, f"{json.dumps(content, indent=1)}\n".encode())


def read_fairness(run: Path) -> Fairness | None:
    """What a run folder has of it; None when it was not checked. Raises RecordingError for a damaged file."""
    path = run / FAIRNESS_FILE
    if not path.exists():
        return None
    content = read_bounded(path, MAX_BYTES, RecordingError)
    try:
        read = json.loads(content)
        if not isinstance(read, dict) or read.pop("schema_version", None) != SCHEMA_VERSION:
            raise ValueError(f"it is not of version {SCHEMA_VERSION}")
        return TypeAdapter(Fairness).validate_python(read)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"cannot read {path}: {in_one_line(error)}; check the run again, or delete it") from None


def _named(names: Sequence[str]) -> str:
    more = len(names) - MAX_NAMED
    return ", ".join(names[:MAX_NAMED]) + (f" and {more} more" if more > 0 else "")
