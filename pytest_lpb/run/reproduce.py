"""How to run an old run again, whether what it took is still the same, and whether another run did the same."""

from __future__ import annotations

import hashlib
import os
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pytest_lpb.errors import LpbError, RecordingError, in_one_line
from pytest_lpb.names import listed
from pytest_lpb.planner.files import read_planner
from pytest_lpb.run.folder import RUN_FILE, RunFolder
from pytest_lpb.run.inputs import planner_file
from pytest_lpb.run.own_planners import own_isolation
from pytest_lpb.run.plan import TrialKey
from pytest_lpb.run.provenance import PACKAGES, git_state, installed_version
from pytest_lpb.run.recorded_planners import load_class, look_up_as_the_run_did
from pytest_lpb.trial.files import read_metadata

NEEDED = ("command", "invocation", "planners", "scenarios", "packages")  # of run.json
HASHES = ("problem_hash", "trajectory_hash", "outcome")


@dataclass(frozen=True)
class Finding:
    """Something that a run depends on, now.

    Attributes:
        what: such as `planner mpc`.
        state: `same`, `changed`, `missing`, or `differs` for what need not matter.
        detail: what it was, and what it is.
    """

    what: str
    state: str
    detail: str = ""

    @property
    def spoils(self) -> bool:
        """Whether the run cannot be repeated with it."""
        return self.state in ("changed", "missing")


def _info(run: RunFolder) -> dict[str, Any]:
    """What run.json says. Raises RecordingError when it lacks what repeating takes."""
    info = run.info()
    missing = [key for key in NEEDED if info.get(key) is None]
    if missing:
        raise RecordingError(f"{run.path / RUN_FILE}: {listed(missing)} is missing: the run cannot be repeated")
    return info


def commands(run: RunFolder) -> list[tuple[str, str]]:
    """Commands that run it again, each with what it takes."""
    info = _info(run)
    shown = Path(os.path.relpath(run.path))
    planners = ",".join(str(planner_file(shown, name)) for name in info["planners"])
    return [
        (f"in {info['invocation']}, with the files that it was made from", shlex.join(info["command"])),
        (
            "from the run folder alone, wherever the planners' code can be imported",
            shlex.join(["pytest", f"--lpb-problems={shown}", f"--lpb-planners={planners}"]),
        ),
    ]


def findings(run: RunFolder, *, trusted: bool = False) -> Iterator[Finding]:
    """What the run took, compared with what is there now.

    Interpreters and hosts are asked for a planner's parameters and source if they are the user's own, or `trusted`.
    """
    info = _info(run)
    for name, scenario in info["scenarios"].items():
        yield _scenario(name, scenario)
    look_up_as_the_run_did(info, run.path)
    for name, planner in info["planners"].items():
        yield _planner(run, name, planner, trusted)
    for name in PACKAGES:
        before, now = info["packages"].get(name), installed_version(name)
        yield Finding(f"package {name}", "same" if before == now else "differs", f"{before}, now {now}")
    yield _commit(info)


def _scenario(name: str, scenario: Mapping[str, Any]) -> Finding:
    what, file = f"scenario {name}", Path(scenario["file"])
    if "problems_of" in scenario:
        return Finding(what, "same", f"problems of {scenario['problems_of']}, copied into this run folder")
    if not file.is_file():
        return Finding(what, "missing", f"{file} is gone; the run folder has its problems")
    same = hashlib.sha256(file.read_bytes()).hexdigest() == scenario["hash"]
    return Finding(what, "same" if same else "changed", str(file))


def _planner(run: RunFolder, name: str, recorded: Mapping[str, Any], trusted: bool) -> Finding:
    what, file = f"planner {name}", planner_file(run.path, name)
    try:
        read = read_planner(file, name)
        now = replace(read, isolation=own_isolation(run, name, read.planner, read.isolation, trusted=trusted))
        load_class(now, recorded, run)
        hashes = {"parameters": now.parameters_hash, "code": now.source_hash}
    except LpbError as error:
        return Finding(what, "missing", in_one_line(error))
    before = {"parameters": recorded["parameters_hash"], "code": recorded["source_hash"]}
    changed = [key for key in hashes if hashes[key] != before[key]]
    return Finding(what, "changed" if changed else "same", ", ".join(changed))


def _commit(info: Mapping[str, Any]) -> Finding:
    before, now = info["git"], git_state(Path(info["invocation"]))
    told = [_told(state) for state in (before, now)]
    return Finding("commit", "same" if before == now else "differs", f"{told[0]}, now {told[1]}")


def _told(state: Mapping[str, Any] | None) -> str:
    if state is None:
        return "none"
    return f"{state['commit'][:12]}{' with changes' if state['dirty'] else ''}"


@dataclass(frozen=True)
class Sameness:
    """Two runs, trial by trial."""

    same: int
    different: list[tuple[TrialKey, str]]  # what differs first: problem, trajectory or outcome
    only_first: list[TrialKey]
    only_second: list[TrialKey]

    @property
    def whole(self) -> bool:
        """Whether every trial of each is the same in the other."""
        return not (self.different or self.only_first or self.only_second)


def compare_runs(first: RunFolder, second: RunFolder) -> Sameness:
    """Whether two runs did the same, to the last bit; times measured are left out. Raises RecordingError."""
    trials = [dict(_hashes(run)) for run in (first, second)]
    both = sorted(trials[0].keys() & trials[1].keys())
    different = []
    for key in both:
        differing = [name for name in HASHES if trials[0][key][name] != trials[1][key][name]]
        if differing:
            different.append((key, differing[0].removesuffix("_hash")))
    only = [sorted(mine.keys() - other.keys()) for mine, other in (trials, reversed(trials))]
    return Sameness(len(both) - len(different), different, only[0], only[1])


def _hashes(run: RunFolder) -> Iterator[tuple[TrialKey, Mapping[str, Any]]]:
    for path in run.trial_files():
        metadata = read_metadata(path)
        yield TrialKey(metadata["scenario"], metadata["planner"], metadata["seed"]), metadata
