"""Running an old run again, and telling whether it did the same."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.planner.files import find_planners
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.inputs import planner_file, write_planner_files
from pytest_lpb.run.plan import TrialKey
from pytest_lpb.run.reproduce import commands, compare_runs, findings
from pytest_lpb.trajectory import Trajectory


@pytest.fixture
def run(finished_run: Path, tmp_path: Path) -> RunFolder:
    copy = tmp_path / "20261122T024921Z-aaaaaa"
    shutil.copytree(finished_run, copy)
    write_planner_files(copy, find_planners(["pd", "potential_field"], []))
    return RunFolder.open(copy)


def states(run: RunFolder) -> dict[str, str]:
    return {finding.what: finding.state for finding in findings(run)}


def edit(run: RunFolder, *keys: str) -> None:
    info = run.info()
    place: Any = info
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = "another"
    (run.path / "run.json").write_text(json.dumps(info))


def test_nothing_has_changed(run: RunFolder) -> None:
    found = states(run)
    assert set(found.values()) == {"same"}
    assert {"planner pd", "scenario drawn", "package numpy", "commit"} <= found.keys()


@pytest.mark.parametrize(
    ("keys", "what", "state"),
    [
        (("planners", "pd", "source_hash"), "planner pd", "changed"),
        (("planners", "pd", "parameters_hash"), "planner pd", "changed"),
        (("scenarios", "drawn", "hash"), "scenario drawn", "changed"),
        (("scenarios", "drawn", "file"), "scenario drawn", "missing"),
        (("packages", "numpy"), "package numpy", "differs"),
    ],
)
def test_what_has_changed_is_told(run: RunFolder, keys: tuple[str, ...], what: str, state: str) -> None:
    edit(run, *keys)
    found = states(run)
    assert found.pop(what) == state
    assert set(found.values()) == {"same"}


def test_planners_that_cannot_be_loaded(run: RunFolder) -> None:
    planner_file(run.path, "pd").write_text("planner: nowhere.to:BeFound\n")
    (finding,) = [finding for finding in findings(run) if finding.what == "planner pd"]
    assert finding.state == "missing"
    assert "cannot import 'nowhere.to'" in finding.detail


def test_commands(run: RunFolder) -> None:
    (_, first), (_, second) = commands(run)
    assert first == "pytest"
    assert "--lpb-problems=" in second
    assert second.endswith("planners/potential_field.yaml")


def test_runs_that_did_the_same(run: RunFolder, finished_run: Path) -> None:
    sameness = compare_runs(run, RunFolder.open(finished_run))
    assert sameness.whole
    assert sameness.same == 8


def test_runs_that_did_not(run: RunFolder, finished_run: Path) -> None:
    trials = run.path / "trials"
    (trials / "drawn/pd/seed0.parquet").unlink()
    shutil.copy(trials / "unsolved/pd/seed0.parquet", trials / "drawn/pd/seed1.parquet")
    shutil.copy(trials / "drawn/potential_field/seed0.parquet", trials / "unsolved/pd/seed0.parquet")
    sameness = compare_runs(run, RunFolder.open(finished_run))
    assert not sameness.whole
    assert sameness.only_second == [TrialKey("drawn", "pd", 0), TrialKey("drawn", "pd", 1)]


def test_other_problems_are_told_as_such(run: RunFolder, finished_run: Path) -> None:
    from pytest_lpb.trial.files import read_trial, write_trial

    path = run.path / "trials/drawn/pd/seed1.parquet"
    trajectory = read_trial(path)
    path.unlink()
    metadata = {**trajectory.metadata, "trajectory_hash": "0" * 64}
    changed = Trajectory(trajectory.columns, metadata, trajectory.problem)
    write_trial(run.path, changed)
    sameness = compare_runs(run, RunFolder.open(finished_run))
    assert sameness.different == [(TrialKey("drawn", "pd", 1), "trajectory")]
    assert sameness.same == 7
