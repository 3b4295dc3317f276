"""What to time again: trials of a run, and in how many passes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

Key = tuple[str, str]  # scenario, planner


@dataclass(frozen=True)
class Job:
    """Trials of a run to time again. Goes to another process as text."""

    run: Path
    passes: int
    trials: Sequence[tuple[str, str, int]]  # scenario, planner, seed
    trusted: bool = False  # whether the run may name what is started

    def to_json(self) -> str:
        """As text."""
        return json.dumps({"run": str(self.run), "passes": self.passes, "trials": self.trials, "trusted": self.trusted})

    @classmethod
    def from_json(cls, text: str) -> Job:
        """The job in such a text."""
        content = json.loads(text)
        trials = [(scenario, planner, seed) for scenario, planner, seed in content["trials"]]
        return cls(Path(content["run"]), content["passes"], trials, content["trusted"])

    @property
    def keys(self) -> list[Key]:
        """Scenarios and planners, in the order of the trials."""
        return list(dict.fromkeys((scenario, planner) for scenario, planner, _ in self.trials))

    def seeds(self, key: Key) -> list[int]:
        """Seeds of a planner's trials in a scenario."""
        return [seed for scenario, planner, seed in self.trials if (scenario, planner) == key]

    def order(self) -> list[tuple[Key, int]]:
        """Passes as they are made: those of a scenario's planners take turns, so slow drifts hit all alike."""
        scenarios = dict.fromkeys(scenario for scenario, _ in self.keys)
        return [
            (key, number)
            for scenario in scenarios
            for number in range(self.passes)
            for key in self.keys
            if key[0] == scenario
        ]
