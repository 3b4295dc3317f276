"""What all parts of the plugin know of the run. One per process, on `config.stash`."""

from __future__ import annotations

import hashlib
import os
import shlex
from dataclasses import dataclass
from pathlib import Path

import pytest

from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.scenario.load import Scenario

WORKER_RUN = "lpb_run_folder"  # key of xdist's workerinput
SESSION: pytest.StashKey[LpbSession] = pytest.StashKey()


@dataclass(frozen=True)
class LpbSession:
    """The options of a run, resolved."""

    planners: list[PlannerConfiguration]
    references: dict[str, str]  # planner name -> as it was asked for
    flags: tuple[str, ...]  # parts drawn by flag
    first_seed: int | None
    trials: int | None
    assertion: str  # trial, rate or none
    render: bool
    kpis: list[str] | None
    modules: list[str]  # of lpb_plugins
    reports: Path
    run: Path  # the run folder; made when the first trial is about to run
    rootdir: Path
    invocation: Path
    workers: int

    def seeds(self, scenario: Scenario) -> range:
        """Seeds of a scenario's trials."""
        first = scenario.seed if self.first_seed is None else self.first_seed
        return range(first, first + (scenario.trials if self.trials is None else self.trials))

    def scenario_key(self, path: Path) -> str:
        """A scenario's key: its path below the rootdir without suffix and leading `scenarios/`."""
        if path.is_relative_to(self.rootdir):
            key = path.relative_to(self.rootdir).with_suffix("").as_posix()
            return key.removeprefix("scenarios/")
        digest = hashlib.sha256(str(path).encode()).hexdigest()[:8]
        return f"{path.stem}-{digest}"

    def node_id_of(self, path: Path) -> str:
        """A scenario file's node id: its path from the rootdir; pytest's own is empty for a file outside of it."""
        return Path(os.path.relpath(path, self.rootdir)).as_posix()

    def file_of(self, node_id: str) -> Path:
        """The scenario file of a node id, or of a trial's."""
        return Path(os.path.normpath(self.rootdir / node_id.partition("::")[0]))

    def repeat_command(self, path: Path, planner: str, seed: int) -> str:
        """The command that runs one trial again, from the invocation directory."""
        node_id = f"{Path(os.path.relpath(path, self.invocation)).as_posix()}::{planner}::seed{seed}"
        flags = [f"--lpb-random-{part}" for part in self.flags]
        planners = f"--lpb-planners={self.references[planner]}"
        return shlex.join(["pytest", planners, f"--lpb-seed={seed}", "--lpb-trials=1", *flags, node_id])


def without_group(node_id: str) -> str:
    """A trial's node id without the `@GROUP` that xdist's --dist loadgroup adds."""
    file, separator, seed = node_id.rpartition("::")
    return f"{file}{separator}{seed.partition('@')[0]}"


def session_of(config: pytest.Config) -> LpbSession:
    """The session of a configured pytest run with planners."""
    return config.stash[SESSION]
