"""One trial of a run, found without reading the others."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from pytest_lpb.errors import LpbError
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.lookup import find_trial
from pytest_lpb.trial.files import trial_path, write_trial
from pytest_lpb.trial.outcome import ENVIRONMENT_ERROR
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import failed_trial
from tests.problem.entries import problem_entry
from tests.trial.specifications import configuration


def run_with(folder: Path, *keys: tuple[str, str]) -> RunFolder:
    """A run of trials by their node ids and scenarios."""
    run = RunFolder.create(folder / "run", {})
    for node_id, scenario in keys:
        *_, planner, seed = node_id.split("::")
        problem = problem_entry(seed=int(seed.removeprefix("seed")))
        named = replace(configuration("pd"), name=planner)
        trial = TrialSpecification(problem=problem, planner=named, scenario=scenario, node_id=node_id)
        write_trial(run.path, failed_trial(trial, ENVIRONMENT_ERROR, "no problem"))
    return run


@pytest.mark.parametrize(
    ("node_id", "scenario"),
    [
        ("scenarios/point/x.yaml::pd::seed0", "point/x"),
        ("../elsewhere/x.yaml::pd::seed0", "x-0123abcd"),
        ("scenarios/arm/x.yaml::pd::seed0", "arm/x"),
        ("scenarios/arm/x.yaml::pd::seed1", "arm/x"),
        ("scenarios/arm/x.yaml::mine::seed0", "arm/x"),
        ("study.yaml::arm/y::pd::seed0", "arm/y"),
        ("reports/20261122T024921Z-74be96/run.json::arm/z::pd::seed0", "arm/z"),
    ],
)
def test_every_trial_is_found(tmp_path: Path, node_id: str, scenario: str) -> None:
    keys = [
        ("scenarios/point/x.yaml::pd::seed0", "point/x"),
        ("../elsewhere/x.yaml::pd::seed0", "x-0123abcd"),
        ("scenarios/arm/x.yaml::pd::seed0", "arm/x"),
        ("scenarios/arm/x.yaml::pd::seed1", "arm/x"),
        ("scenarios/arm/x.yaml::mine::seed0", "arm/x"),
        ("study.yaml::arm/y::pd::seed0", "arm/y"),
        ("reports/20261122T024921Z-74be96/run.json::arm/z::pd::seed0", "arm/z"),
    ]
    run = run_with(tmp_path, *keys)
    *_, planner, seed = node_id.split("::")
    assert find_trial(run, node_id) == trial_path(run.path, scenario, planner, int(seed.removeprefix("seed")))


def test_damaged_files_are_passed_over(tmp_path: Path) -> None:
    run = run_with(tmp_path, ("scenarios/a/x.yaml::pd::seed0", "a/x"), ("scenarios/b/x.yaml::pd::seed0", "b/x"))
    trial_path(run.path, "a/x", "pd", 0).write_bytes(b"no Parquet")
    assert find_trial(run, "scenarios/b/x.yaml::pd::seed0") == trial_path(run.path, "b/x", "pd", 0)
    with pytest.raises(LpbError, match=r"there are scenarios/b/x\.yaml::pd::seed0$"):
        find_trial(run, "scenarios/a/x.yaml::pd::seed0")


@pytest.mark.parametrize(
    "node_id", ["scenarios/point/x.yaml::pd::seed3", "x", "::", "scenarios/point/y.yaml::pd::seed0"]
)
def test_what_is_not_there_is_told(tmp_path: Path, node_id: str) -> None:
    run = run_with(tmp_path, ("scenarios/point/x.yaml::pd::seed0", "point/x"))
    with pytest.raises(LpbError, match=r"no trial '.*' in this run.*; there are scenarios/point/x\.yaml::pd::seed0$"):
        find_trial(run, node_id)
    shutil.rmtree(run.path / "trials")
    with pytest.raises(LpbError, match=r"there are \(none\)$"):
        find_trial(run, node_id)
