"""Several runs as one."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.report.build import write_results
from pytest_lpb.run.evaluation import evaluate
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.merge import endings, merge


@pytest.fixture
def runs(finished_run: Path, tmp_path: Path) -> list[RunFolder]:
    """The same run twice, under two names."""
    load_builtin()
    copies = [tmp_path / name for name in ("20261122T024921Z-aaaaaa", "20261122T024922Z-bbbbbb")]
    for copy in copies:
        shutil.copytree(finished_run, copy)
    return [RunFolder.open(copy) for copy in copies]


def change(run: RunFolder, edit: str, planner: str | None = None) -> None:
    info = run.info()
    place = info["machine"] if planner is None else info["planners"][planner]
    place[edit] = "another"
    (run.path / "run.json").write_text(json.dumps(info))


def test_the_same_trials_count_once(runs: list[RunFolder]) -> None:
    evaluations = [evaluate(run, ["time_to_goal_s"]) for run in runs]
    merged = merge(evaluations)
    assert merged.table().to_csv() == evaluations[0].table().to_csv()
    assert merged.warnings == []
    assert merged.run.info()["notes"] == ["8 trials are in several of the runs; each counts once"]
    assert merged.run.info()["merged"] == [run.name for run in runs]


def test_versions_of_a_planner_are_told_apart(runs: list[RunFolder], tmp_path: Path) -> None:
    change(runs[1], "source_hash", "pd")
    merged = merge([evaluate(run, ["time_to_goal_s"]) for run in runs])
    assert sorted(merged.trials["planner"].unique()) == ["pd.aaaaaa", "pd.bbbbbb", "potential_field"]
    assert sorted(merged.run.info()["planners"]) == ["pd.aaaaaa", "pd.bbbbbb", "potential_field"]
    assert merged.trials["node_id"].is_unique
    node_id = "drawn.yaml::pd.bbbbbb::seed1"
    assert merged.trajectory_of(node_id).metadata["node_id"] == "drawn.yaml::pd::seed1"
    data = write_results(merged, tmp_path / "out")
    pair = data.comparisons.query("planner_a == 'pd.aaaaaa' and planner_b == 'pd.bbbbbb' and kpi == 'success'")
    assert pair["difference"].abs().max() == 0.0
    assert "pd.bbbbbb" in (tmp_path / "out/report.html").read_text()


def test_runs_whose_folders_have_one_name(runs: list[RunFolder], tmp_path: Path) -> None:
    renamed = []
    for run in runs:
        (tmp_path / run.name[-6:]).mkdir()
        renamed.append(RunFolder.open(run.path.rename(tmp_path / run.name[-6:] / "run")))
    change(renamed[1], "source_hash", "pd")
    merged = merge([evaluate(run, ["time_to_goal_s"]) for run in renamed])
    assert sorted(merged.trials["planner"].unique()) == ["pd.run", "pd.run-2", "potential_field"]
    assert merged.trials["planner"].value_counts()["pd.run-2"] == 4
    assert endings(renamed) == ["run", "run-2"]


def test_a_version_that_several_runs_have_is_one_planner(runs: list[RunFolder], tmp_path: Path) -> None:
    change(runs[1], "source_hash", "pd")
    shutil.copytree(runs[0].path, tmp_path / "20261122T024923Z-cccccc")
    third = RunFolder.open(tmp_path / "20261122T024923Z-cccccc")
    merged = merge([evaluate(run, ["time_to_goal_s"]) for run in (*runs, third)])
    assert sorted(merged.trials["planner"].unique()) == ["pd.aaaaaa", "pd.bbbbbb", "potential_field"]


def test_times_of_two_machines_do_not_compare(runs: list[RunFolder]) -> None:
    change(runs[1], "cpu")
    merged = merge([evaluate(run, ["time_to_goal_s"]) for run in runs])
    assert merged.trials["timing_contended"].all()
    assert "the runs were made on different machines: their times do not compare" in merged.run.info()["notes"]


def test_trials_that_differ_are_warned_of(runs: list[RunFolder]) -> None:
    first, second = (evaluate(run, ["time_to_goal_s"]) for run in runs)
    second.trials.loc[0, "trajectory_hash"] = "another"
    merged = merge([first, second])
    (warning,) = merged.warnings
    assert warning.startswith("1 trial is in several of the runs and different there")
    second.trials.loc[1, ["problem_hash", "trajectory_hash"]] = "another"
    changed, other = merge([first, second]).warnings
    assert changed.startswith("1 trial is in several of the runs and of another problem there: the scenarios")
    assert other == warning


def test_the_order_of_runs_changes_no_row(runs: list[RunFolder]) -> None:
    change(runs[1], "source_hash", "pd")
    evaluations = [evaluate(run, ["time_to_goal_s"]) for run in runs]
    assert merge(evaluations).table().to_csv() == merge(evaluations[::-1]).table().to_csv()
