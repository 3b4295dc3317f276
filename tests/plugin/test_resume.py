"""--lpb-resume: an interrupted run is finished, and only what is missing is run."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import pytest

from .projects import DRAWN, UNSOLVED, Project, read_run, read_table, text_of, trial_files
from .test_interrupt import PATIENCE_S, SLOW, wait_for_trials

MISSING = ("a/drawn/pd/seed1", "b/unsolved/potential_field/seed2")
TIMING = ("wall_s", "timing_contended", "solver_", "real_time_factor", "setup_ms", "first_call_ms", "deadline_miss")


@pytest.fixture
def cut(project: Project) -> Project:
    """A run of which two trials are missing."""
    project.scenario("scenarios/a/drawn.yaml", DRAWN)
    project.scenario("scenarios/b/unsolved.yaml", UNSOLVED)
    project.run("scenarios", "--lpb-trials=3", planners="pd,potential_field")
    (run,) = project.runs()
    (run / "whole.csv").write_bytes((run / "trials.csv").read_bytes())
    for name in MISSING:
        for suffix in (".parquet", ".yaml"):
            (run / "trials" / f"{name}{suffix}").unlink()
    for table in ("trials.csv", "summary.csv", "comparisons.csv", "report.html"):
        (run / table).unlink()
    return project


def untimed(path: Path) -> list[dict[str, str]]:
    return [{key: value for key, value in row.items() if not key.startswith(TIMING)} for row in read_table(path)]


@pytest.mark.parametrize("workers", [0, 2])
def test_what_is_missing_is_run(cut: Project, workers: int) -> None:
    (run,) = cut.runs()
    before = {file: (run / "trials" / file).stat().st_mtime_ns for file in trial_files(run)}
    arguments = ("--lpb-resume=reports/latest",)
    result = cut.run_workers(*arguments, planners=None) if workers else cut.run(*arguments, planners=None)
    assert result.ret == 1, text_of(result)  # as the whole run: some trials are unsolved
    result.assert_outcomes(passed=6, failed=6)
    assert cut.runs() == [run]
    assert {file: (run / "trials" / file).stat().st_mtime_ns for file in before} == before
    assert len(trial_files(run)) == len(before) + 2
    assert untimed(run / "trials.csv") == untimed(run / "whole.csv")
    assert len(read_run(run)["resumed"]) == 1


def test_a_run_that_is_whole_is_only_told(cut: Project) -> None:
    cut.run("--lpb-resume=reports/latest", planners=None)
    (run,) = cut.runs()
    before = {file: (run / "trials" / file).stat().st_mtime_ns for file in trial_files(run)}
    result = cut.run("--lpb-resume=reports/latest", planners=None)
    result.assert_outcomes(passed=6, failed=6)
    assert {file: (run / "trials" / file).stat().st_mtime_ns for file in before} == before


def test_selections_hold(project: Project) -> None:
    """What -k left out is not missing."""
    project.scenario("scenarios/a/drawn.yaml", DRAWN)
    project.run("scenarios", "--lpb-trials=4", "-k", "seed1 or seed2")
    (run,) = project.runs()
    (run / "trials/a/drawn/pd/seed2.parquet").unlink()
    project.run(f"--lpb-resume={run}", planners=None).assert_outcomes(passed=2, deselected=2)
    assert trial_files(run) == ["a/drawn/pd/seed1.parquet", "a/drawn/pd/seed2.parquet"]


def test_a_study(cut: Project) -> None:
    cut.write("study.yaml", "study: s\nplanners: [pd]\nscenarios: scenarios/a/drawn.yaml\ntrials: 3\n")
    cut.run("study.yaml", planners=None)
    run = cut.runs()[-1]
    before = (run / "trials.csv").read_text()
    (run / "trials/a/drawn/pd/seed1.parquet").unlink()
    cut.run(f"--lpb-resume={run}", planners=None).assert_outcomes(passed=3)
    after = untimed(run / "trials.csv")
    (run / "trials.csv").write_text(before)
    assert after == untimed(run / "trials.csv")


def change_planner(project: Project) -> None:
    project.write("planners/pd.yaml", "planner: pd\nparameters: {p: 3.0}\n")


def change_scenario(project: Project) -> None:
    project.scenario("scenarios/a/drawn.yaml", DRAWN + "# changed\n")


def remove_scenario(project: Project) -> None:
    (project.path / "scenarios/a/drawn.yaml").unlink()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (change_planner, "planner 'pd' (parameters hash)"),
        (change_scenario, "scenario 'a/drawn' (hash)"),
        (remove_scenario, "scenario 'a/drawn' (hash)"),
    ],
)
@pytest.mark.parametrize("workers", [0, 2])
def test_what_has_changed_is_not_mixed(cut: Project, change: object, message: str, workers: int) -> None:
    change(cut)  # type: ignore[operator]
    arguments = ["--lpb-resume=reports/latest", *(["-n", "2"] if workers else [])]
    result = cut.run(*arguments, planners=None)
    assert result.ret != 0
    assert message in text_of(result)
    assert "undo the changes, or start a new run" in text_of(result)
    assert len(trial_files(cut.runs()[0])) == 10


@pytest.mark.parametrize(
    ("arguments", "planners", "message"),
    [
        (["--lpb-resume=reports/latest", "--lpb-trials=4"], None, "--lpb-trials=4 is not what"),
        (["--lpb-resume=reports/latest"], "pd", "--lpb-planners=pd is not what"),
        (["--lpb-resume=reports/latest", "scenarios/a"], None, "was started with scenarios; leave scenarios/a out"),
        (["--lpb-resume=reports/none"], None, "reports/none is no run folder"),
    ],
)
def test_a_run_is_finished_as_it_began(cut: Project, arguments: list[str], planners: str | None, message: str) -> None:
    result = cut.run(*arguments, planners=planners, fast=planners is None)
    assert result.ret == 4
    assert message in text_of(result)


def test_the_whole_command_again_is_fine(cut: Project) -> None:
    result = cut.run("scenarios", "--lpb-trials=3", "--lpb-resume=reports/latest", planners="pd,potential_field")
    result.assert_outcomes(passed=6, failed=6)


def test_runs_of_other_places(cut: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(cut.path / "scenarios")
    result = cut.run("--lpb-resume=../reports/latest", planners=None)
    assert result.ret == 4
    assert f"was started in {cut.path}; finish it there" in text_of(result)


def test_runs_without_a_plan(cut: Project) -> None:
    (run,) = cut.runs()
    info = read_run(run)
    del info["planned"]
    (run / "run.json").write_text(json.dumps(info))
    result = cut.run("--lpb-resume=reports/latest", planners=None)
    assert result.ret == 4
    assert "does not say which trials it was to have" in text_of(result)


@pytest.mark.parametrize("workers", [0, 2])
def test_after_an_interrupt(project: Project, workers: int) -> None:
    project.write("conftest.py", SLOW)
    project.scenario(content=UNSOLVED)
    arguments = ["-n", str(workers)] if workers else []
    process = project.start(*arguments, "--lpb-trials=7", "--lpb-assert=none", "scenarios", planners="slow")
    try:
        wait_for_trials(project, process, 2)
        os.killpg(process.pid, signal.SIGKILL if workers else signal.SIGINT)
        process.wait(timeout=PATIENCE_S)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    (run,) = project.runs()
    if not workers:
        assert f"pytest --lpb-resume=reports/{run.name}" in project.output.read_text()
    done = trial_files(run)
    assert 2 <= len(done) < 7
    result = project.run(f"--lpb-resume={run}", planners=None)
    assert result.ret == 0
    assert len(trial_files(run)) == 7
    assert [row["outcome"] for row in project.rows()] == ["timeout"] * 7
    assert len(set(project.hashes().values())) == 1


def test_a_trial_that_is_damaged_is_told_without_a_traceback(cut: Project) -> None:
    (run,) = cut.runs()
    (run / "trials/a/drawn/pd/seed0.parquet").write_bytes(b"PAR1")
    result = cut.run("--lpb-resume=reports/latest", planners=None)
    result.assert_outcomes(passed=5, failed=7)
    assert "cannot read " in text_of(result)
    assert "def runtest" not in text_of(result)
