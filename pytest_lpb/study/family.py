"""Where the problems of a scenario come from."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

from pytest_lpb.errors import MissingRobotsError, ScenarioError
from pytest_lpb.scenario.load import Scenario, load_scenario
from pytest_lpb.study.change import Change


def scenario_key(path: Path, root: Path) -> str:
    """A scenario's key: its path below a root without suffix and leading `scenarios/`."""
    if path.is_relative_to(root):
        return path.relative_to(root).with_suffix("").as_posix().removeprefix("scenarios/")
    digest = hashlib.sha256(str(path).encode()).hexdigest()[:8]
    return f"{path.stem}-{digest}"


class Family(Protocol):
    """Problems that differ by seed, under one scenario key."""

    @property
    def key(self) -> str:
        """The scenario's key in results."""

    @property
    def path(self) -> Path:
        """A file that says what the problems are."""

    def scenario(self, seed: int | None = None) -> Scenario:
        """The scenario that the problem of a seed is drawn from; of no seed in particular: of any.

        Raises ScenarioError and MissingRobotsError.
        """

    def seeds(self, first: int | None, trials: int | None) -> Sequence[int]:
        """Seeds to run, where a run says the first and how many, or (None) leaves that to the scenario."""

    def description(self) -> dict[str, Any]:
        """What run.json says: `file`, `hash` (SHA-256), and what was changed."""


@dataclass(frozen=True)
class FileFamily:
    """The problems of a scenario file, perhaps with some of its values changed."""

    key: str
    path: Path
    changes: Sequence[Change] = ()
    base: str = ""  # key of the unchanged scenario

    @cached_property
    def _scenario(self) -> Scenario:
        try:
            return load_scenario(self.path, [change.apply for change in self.changes])
        except MissingRobotsError:
            raise
        except ScenarioError as error:
            if not self.changes:
                raise
            values = ", ".join(f"{change.name}: {change.value}" for change in self.changes)
            raise ScenarioError(f"{self.changes[0].place}: with {values} it is no scenario:", *error.faults) from None

    def scenario(self, seed: int | None = None) -> Scenario:  # noqa: ARG002 - all seeds share it
        """The scenario of the file."""
        return self._scenario

    def seeds(self, first: int | None, trials: int | None) -> Sequence[int]:
        """Consecutive seeds."""
        start = self._scenario.seed if first is None else first
        return range(start, start + (self._scenario.trials if trials is None else trials))

    def description(self) -> dict[str, Any]:
        """File, hash and changes."""
        told: dict[str, Any] = {"file": str(self.path), "hash": hashlib.sha256(self.path.read_bytes()).hexdigest()}
        if self.changes:
            told["changes"] = {change.name: change.value for change in self.changes}
        return told


@dataclass(frozen=True)
class RecordedFamily:
    """The concrete problems of an old run, one file per seed."""

    key: str
    files: Mapping[int, Path]
    of: str  # the old run

    @property
    def path(self) -> Path:
        """The first problem's file."""
        return next(iter(self.files.values()))

    def scenario(self, seed: int | None = None) -> Scenario:
        """The concrete problem of a seed, which is a scenario file."""
        return load_scenario(self.path if seed is None else self.files[seed])

    def seeds(self, first: int | None, trials: int | None) -> Sequence[int]:
        """The old run's seeds, from `first` on, at most `trials`."""
        seeds = [seed for seed in self.files if first is None or seed >= first]
        return seeds if trials is None else seeds[:trials]

    def description(self) -> dict[str, Any]:
        """The old run, and a hash over all its problems."""
        digest = hashlib.sha256()
        for path in self.files.values():
            digest.update(path.read_bytes())
        return {"file": str(self.path), "hash": digest.hexdigest(), "problems_of": self.of}
