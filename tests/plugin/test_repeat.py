"""A failed trial names the command that repeats it, and the command does."""

from __future__ import annotations

import shlex

import pytest

from .projects import DRAWN, FAST, UNSOLVED, Project, text_of

RANGES = UNSOLVED + "randomize: {goal: [[2, 3], [2, 3]], start: {q: [[-1, 1], [-1, 1]]}}\n"


def commands(result: pytest.RunResult) -> list[list[str]]:
    # Where CI is set, pytest prints the whole text again in its short summary.
    lines = dict.fromkeys(line for line in result.stdout.lines if line.startswith("repeat: "))
    return [shlex.split(line.removeprefix("repeat: ")) for line in lines]


def repeat(project: Project, command: list[str]) -> None:
    """Run the command; its trajectory is the one of the last run."""
    before = project.hashes()
    assert command[0] == "pytest"
    result = project.pytester.runpytest_inprocess(*command[1:], FAST)
    result.assert_outcomes(failed=1)
    (digest,) = project.hashes().values()
    (seed,) = {row["seed"] for row in project.rows()}
    assert digest in {value for key, value in before.items() if key[2] == seed}
    assert len(set(before.values())) == len(before)


def test_the_text_of_a_failure(project: Project) -> None:
    project.scenario(content=UNSOLVED)
    result = project.run("scenarios")
    text = text_of(result)
    assert "timeout: reached " in text
    assert "from the goal (tolerance 0.10 m)" in text
    (command,) = commands(result)
    node_id = "scenarios/point/x.yaml::pd::seed0"
    assert command == ["pytest", "--lpb-planners=pd", "--lpb-seed=0", "--lpb-trials=1", node_id]
    assert "Traceback" not in text
    repeat(project, command)


def test_seeds_and_flags(project: Project) -> None:
    project.scenario(content=RANGES)
    result = project.run("--lpb-seed=7", "--lpb-trials=2", "--lpb-random-goal", "--lpb-random-start", "scenarios")
    _, second = commands(result)
    assert {"--lpb-seed=8", "--lpb-trials=1", "--lpb-random-goal", "--lpb-random-start"} < set(second)
    repeat(project, second)


def test_a_planner_by_path_from_another_folder(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    project.scenario("robots/my scenarios/x.yaml", UNSOLVED)
    project.write("robots/tuned pd.yaml", "planner: pd\nparameters: {p: 3.0}\n")
    monkeypatch.chdir(project.path / "robots")
    result = project.run("my scenarios/x.yaml", "--lpb-reports=../reports", planners="fast=tuned pd.yaml")
    (command,) = commands(result)
    assert "--lpb-planners=fast=tuned pd.yaml" in command
    repeat(project, [*command, "--lpb-reports=../reports"])


def test_a_planner_of_the_ini_file_from_another_folder(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    project.ini("lpb_planners = planners/tuned.yaml")
    project.scenario(content=UNSOLVED)
    project.write("planners/tuned.yaml", "planner: pd\nparameters: {p: 3.0}\n")
    monkeypatch.chdir(project.path / "scenarios")
    result = project.run(FAST, "--lpb-reports=../reports", planners=None)
    (command,) = commands(result)
    assert "--lpb-planners=../planners/tuned.yaml" in command
    repeat(project, [*command, "--lpb-reports=../reports"])


def test_every_trial_of_a_run_repeats(project: Project) -> None:
    project.scenario(content=DRAWN)
    project.run("--lpb-trials=3", "scenarios", planners="pd,potential_field").assert_outcomes(passed=6)
    whole = project.hashes()
    for row in project.rows(project.runs()[0]):
        project.run(row["node_id"], f"--lpb-seed={row['seed']}", "--lpb-trials=1", planners=row["planner"])
        ((key, digest),) = project.hashes().items()
        assert whole[key] == digest


def test_an_error_in_a_planner_shows_where(project: Project) -> None:
    project.scenario(content=UNSOLVED)
    project.write(
        "conftest.py",
        """
from pytest_lpb import Planner

class Broken(Planner):
    name = "broken"

    def compute_action(self, observation):
        return observation["no_such_key"]
""",
    )
    result = project.run("scenarios", planners="broken")
    result.assert_outcomes(failed=1)
    text = text_of(result)
    assert "planner_error: KeyError: 'no_such_key'" in text
    assert 'conftest.py", line 8, in compute_action' in text
    repeat_line = (
        "repeat: pytest --lpb-planners=broken --lpb-seed=0 --lpb-trials=1 scenarios/point/x.yaml::broken::seed0"
    )
    assert repeat_line in text
    assert project.row()["outcome"] == "planner_error"
