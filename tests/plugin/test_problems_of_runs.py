"""--lpb-problems: the problems of an old run, with any planners."""

from __future__ import annotations

import pytest

from .projects import DRAWN, UNSOLVED, Project, node_ids, text_of


@pytest.fixture
def ran(project: Project) -> Project:
    project.scenario("scenarios/a/drawn.yaml", DRAWN)
    project.scenario("scenarios/b/unsolved.yaml", UNSOLVED)
    project.run("scenarios", "--lpb-trials=3", "--lpb-seed=5", "--lpb-assert=none")
    return project


@pytest.mark.parametrize("workers", [0, 2])
def test_the_same_problems_under_their_names(ran: Project, workers: int) -> None:
    before = {(row["scenario"], row["seed"]): row["problem_hash"] for row in ran.rows()}
    # The files are gone or have changed: the run folder has all that it takes.
    ran.scenario("scenarios/a/drawn.yaml", DRAWN.replace("0.06", "0.03"))
    (ran.path / "scenarios/b/unsolved.yaml").unlink()
    arguments = ("--lpb-problems=reports/latest", "--lpb-assert=none")
    planners = "pd,potential_field"
    result = ran.run_workers(*arguments, planners=planners) if workers else ran.run(*arguments, planners=planners)
    assert result.ret == 0, text_of(result)
    rows = ran.rows()
    assert len(rows) == 2 * len(before)
    assert {(row["scenario"], row["seed"]): row["problem_hash"] for row in rows} == before


def test_pd_does_the_same_again(ran: Project) -> None:
    before = ran.hashes()
    ran.run("--lpb-problems=reports/latest", "--lpb-assert=none")
    assert ran.hashes() == before


def test_a_part_of_them(ran: Project) -> None:
    old = ran.runs()[-1]
    listed = node_ids(ran.run(f"--lpb-problems={old}", "--collect-only", "-q"))
    assert f"reports/{old.name}/run.json::a/drawn::pd::seed5" in listed
    ran.run(f"--lpb-problems={old}", listed[0], "--lpb-assert=none")
    assert ran.row()["node_id"] == listed[0]
    ran.run(f"--lpb-problems={old}", "--lpb-trials=1", "--lpb-seed=6", "--lpb-assert=none")
    assert [row["seed"] for row in ran.rows()] == ["6", "6"]


def test_a_failure_is_repeated(ran: Project) -> None:
    result = ran.run("--lpb-problems=reports/latest", "-k", "unsolved and seed5")
    assert result.ret == 1
    (command,) = [line for line in dict.fromkeys(result.stdout.lines) if line.startswith("repeat: ")]
    digest = list(ran.hashes().values())
    (_, second) = ran.runs()
    again = ran.run(*command.removeprefix("repeat: pytest ").split(), planners=None)
    again.assert_outcomes(failed=1)
    assert ran.runs()[-1] != second
    assert list(ran.hashes().values()) == digest


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--lpb-problems=nowhere"], "nowhere is no run folder"),
        (["--lpb-problems=reports/latest", "scenarios"], "scenarios is not among them: leave it out"),
        (["--lpb-problems=reports/latest", "--lpb-random-goal"], "nothing is drawn: leave --lpb-random-goal out"),
    ],
)
def test_what_makes_no_sense(ran: Project, arguments: list[str], message: str) -> None:
    result = ran.run(*arguments)
    assert result.ret == 4
    assert message in text_of(result)


def test_planners_must_be_chosen(ran: Project) -> None:
    result = ran.run("--lpb-problems=reports/latest", planners=None)
    assert result.ret == 4
    assert "choose planners to run the problems with" in text_of(result)


def test_a_problem_that_is_damaged_is_told_without_a_traceback(ran: Project) -> None:
    old = ran.runs()[-1]
    (old / "trials/a/drawn/pd/seed6.yaml").write_text("version: 1\nrobot: {model: poimt}\n")
    result = ran.run(f"--lpb-problems={old}", "-k", "drawn")
    result.assert_outcomes(passed=2, failed=1)
    assert "seed6.yaml:2: robot.model: " in text_of(result)
    assert "Traceback" not in text_of(result)
    assert "def runtest" not in text_of(result)
