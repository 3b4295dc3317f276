"""What all parts of the plugin know of the run. One per process, on `config.stash`."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.run.plan import TrialKey
from pytest_lpb.study.family import Family, FileFamily, scenario_key

if TYPE_CHECKING:
    from pytest_lpb.run.gate_options import CheckedGate, GateOptions

WORKER_RUN = "lpb_run_folder"  # keys of xdist's workerinput
WORKER_ROOT = "lpb_rootdir"
WORKER_CONTROLLER = "lpb_controller"
SESSION: pytest.StashKey[LpbSession] = pytest.StashKey()
TRIAL = re.compile(r"(?P<above>.+)::(?P<planner>[^:]+)::seed(?P<seed>[0-9]+)")


@dataclass(frozen=True)
class Source:
    """What names the problems of a run in the place of scenario files: a study, or an old run.

    Attributes:
        path: the file that stands for it: the study, or the old run's run.json.
        families: its scenarios.
        swept: what of the planners and scenarios is a variant of what.
        options: that name it again.
    """

    path: Path
    families: Sequence[Family]
    swept: Mapping[str, Any]
    options: Sequence[str]


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
    options: Mapping[str, Any]  # of sources.RECORDED, as they were given
    source: Source | None = None  # None: scenario files
    planned: frozenset[TrialKey] | None = None  # trials of the run that is finished now; None: a new run
    gate: GateOptions | None = None  # as it was asked for; checked in the controlling process
    checked_gate: CheckedGate | None = None
    reported: bool = True  # whether tables and report are made at the end
    checked_trials: int | None = None  # of each planner, to be run again; None: none
    title: str = ""  # of the run; empty: none

    @property
    def shown_run(self) -> Path:
        """The run folder as it is typed."""
        return self.run.relative_to(self.invocation) if self.run.is_relative_to(self.invocation) else self.run

    @property
    def resume_command(self) -> str:
        """The command that finishes this run."""
        return shlex.join(["pytest", f"--lpb-resume={self.shown_run}"])

    @property
    def report_command(self) -> str:
        """The command that makes tables and report of this run."""
        return shlex.join(["lpb-report", str(self.shown_run)])

    def seeds(self, family: Family) -> Sequence[int]:
        """Seeds of a scenario's trials."""
        return family.seeds(self.first_seed, self.trials)

    def scenario_key(self, path: Path) -> str:
        """A scenario's key: its path below the rootdir without suffix and leading `scenarios/`."""
        return scenario_key(path, self.rootdir)

    def node_id_of(self, path: Path) -> str:
        """A scenario file's node id: its path from the rootdir; pytest's own is empty for a file outside of it."""
        return Path(os.path.relpath(path, self.rootdir)).as_posix()

    def trial_of(self, node_id: str) -> TrialKey | None:
        """The trial of a node id; None for items of others."""
        match = TRIAL.fullmatch(without_group(node_id))
        if match is None or match["planner"] not in (planner.name for planner in self.planners):
            return None
        return TrialKey(self._key_of(match["above"]), match["planner"], int(match["seed"]))

    def _key_of(self, node_id: str) -> str:
        """Scenario key of the node above planners."""
        file, _, key = node_id.partition("::")
        return key or self.scenario_key(Path(os.path.normpath(self.rootdir / file)))

    def families(self, node_ids: Iterable[str]) -> dict[str, Family]:
        """Families of trials' node ids, by scenario key."""
        found: dict[str, Family] = {}
        for node_id in node_ids:
            above = node_id.rsplit("::", 2)[0]
            key = self._key_of(above)
            if key in found:
                continue
            if self.source is None:
                found[key] = FileFamily(key, Path(os.path.normpath(self.rootdir / above)))
            else:
                found[key] = next(family for family in self.source.families if family.key == key)
        return found

    def repeat_command(self, node_id: str, planner: str, seed: int) -> str:
        """The command that runs one trial again, from the invocation directory."""
        file, separator, rest = without_group(node_id).partition("::")
        shown = Path(os.path.relpath(self.rootdir / file, self.invocation)).as_posix() + separator + rest
        if self.source is not None:
            return shlex.join(["pytest", *self.source.options, shown])
        flags = [f"--lpb-random-{part}" for part in self.flags]
        planners = f"--lpb-planners={self.references[planner]}"
        return shlex.join(["pytest", planners, f"--lpb-seed={seed}", "--lpb-trials=1", *flags, shown])


def without_group(node_id: str) -> str:
    """A trial's node id without the `@GROUP` that xdist's --dist loadgroup adds."""
    file, separator, seed = node_id.rpartition("::")
    return f"{file}{separator}{seed.partition('@')[0]}"


def session_of(config: pytest.Config) -> LpbSession:
    """The session of a configured pytest run with planners."""
    return config.stash[SESSION]
