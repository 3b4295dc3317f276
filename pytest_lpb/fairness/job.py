"""What a process of its own is to do again, and what it answers."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pytest_lpb.run.plan import TrialKey

RUN, MOVE = "run", "move"  # tasks: run trials again; move the scene and ask the planner again


@dataclass(frozen=True)
class Job:
    """Trials of a run, in the order in which they are taken up. Goes to another process as text."""

    run: Path
    task: str
    trials: Sequence[TrialKey]

    def to_json(self) -> str:
        """As text."""
        return json.dumps({"run": str(self.run), "task": self.task, "trials": self.trials})

    @classmethod
    def from_json(cls, text: str) -> Job:
        """The job in such a text."""
        content = json.loads(text)
        return cls(Path(content["run"]), content["task"], [TrialKey(*trial) for trial in content["trials"]])


@dataclass(frozen=True)
class Answers:
    """What processes answered.

    Attributes:
        by_trial: hashes and outcome of each trial, or what the planner reacts to.
        missing: trials without an answer, with the reason.
    """

    by_trial: dict[TrialKey, dict[str, Any]]
    missing: dict[TrialKey, str]


def answer_line(key: TrialKey, answer: dict[str, Any]) -> str:
    """One answer as a line of the answers' file."""
    return f"{json.dumps([key, answer])}\n"


def read_answers(lines: Iterable[str]) -> dict[TrialKey, dict[str, Any]]:
    """Answers by trial. A process that died may have left half a line, which is none."""
    return {TrialKey(*key): answer for key, answer in (json.loads(line) for line in lines if line.endswith("\n"))}
