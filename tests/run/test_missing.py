"""What is said of trials that a run was to have, and has not."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.report.build import report_data, write_results
from pytest_lpb.report.markdown import markdown_summary
from pytest_lpb.run.evaluation import Selection, evaluate
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.merge import merge
from pytest_lpb.run.missing import missing_notes, missing_table, missing_trials, resume_command
from pytest_lpb.run.plan import TrialKey

from ..plugin.projects import read_table

PLAN = {name: {"pd": "0-1", "potential_field": "0-1"} for name in ("drawn", "unsolved")}


@pytest.fixture
def runs(finished_run: Path, tmp_path: Path) -> list[RunFolder]:
    """Two copies of a run of eight trials; the first lacks three of them, the second two."""
    load_builtin()
    found = []
    for name, lacking in (("a", ("drawn/pd/seed0", "drawn/pd/seed1", "unsolved/pd/seed1")), ("b", ("drawn/pd/seed1",))):
        run = RunFolder.open(shutil.copytree(finished_run, tmp_path / name))
        info = {**run.info(), "planned": PLAN, "invocation": str(tmp_path)}
        (run.path / "run.json").write_text(json.dumps(info))
        for trial in lacking:
            (run.path / f"trials/{trial}.parquet").unlink()
        found.append(run)
    return found


def test_tables_and_report_say_it(runs: list[RunFolder]) -> None:
    run = runs[0].path
    data = write_results(evaluate(runs[0], ["time_to_goal_s"]), run)
    said = [
        "5 of 8 trials were run; run the others with: pytest --lpb-resume=a",
        "missing: drawn :: pd :: seed 0-1",
        "missing: unsolved :: pd :: seed 1",
    ]
    for text in (markdown_summary(data), (run / "report.html").read_text()):
        assert all(line in text for line in said)
    assert [list(row.values()) for row in read_table(run / "missing.csv")] == [
        ["drawn", "pd", "2", "0-1"],
        ["unsolved", "pd", "1", "1"],
    ]


def test_of_some_trials_only_theirs_are_missing(runs: list[RunFolder]) -> None:
    evaluation = evaluate(runs[0], ["time_to_goal_s"])
    assert evaluation.selected(Selection(scenarios=["unsolved"])).missing == [TrialKey("unsolved", "pd", 1)]
    assert not evaluation.selected(Selection(planners=["potential_field"])).missing


def test_what_another_run_has_is_not_missing(runs: list[RunFolder]) -> None:
    merged = merge([evaluate(run, ["time_to_goal_s"]) for run in runs])
    assert merged.missing == [TrialKey("drawn", "pd", 1)]
    assert report_data(merged).resume == ""


def test_a_run_without_a_plan_lacks_nothing(finished_run: Path) -> None:
    load_builtin()
    evaluation = evaluate(RunFolder.open(finished_run), ["time_to_goal_s"])
    assert not evaluation.missing
    assert not missing_trials({"planned": None}, evaluation.trials)
    assert resume_command(finished_run, {"invocation": None}) == f"pytest --lpb-resume={finished_run}"


def test_notes_have_an_end() -> None:
    missing = [TrialKey(f"s{number:02}", "pd", 0) for number in range(12)]
    notes = list(missing_notes(missing, 3, ""))
    assert notes[0] == "3 of 15 trials were run"
    assert notes[-1] == "... and 2 more scenarios and planners; missing.csv lists them all"
    assert len(notes) == 12
    assert len(missing_table(missing)) == 12
    assert list(missing_notes([], 3, "")) == []
