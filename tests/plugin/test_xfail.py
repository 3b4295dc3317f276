"""Known failures are data: `xfail` in scenario files and in planner files."""

from __future__ import annotations

import pytest

from pytest_lpb.trial.files import read_trial

from .projects import SCENARIO, UNSOLVED, Project, text_of


@pytest.mark.parametrize(
    ("entry", "outcomes"),
    [
        ("pd: too far", {"xfailed": 2}),
        ("potential_field: too far", {"failed": 2}),
        ("pd: {reason: too far, outcomes: [timeout]}", {"xfailed": 2}),
        ("pd: {reason: too far, outcomes: [collision, stalled]}", {"failed": 2}),
        ("pd: {reason: too far, seeds: [1, 7]}", {"xfailed": 1, "failed": 1}),
        ("pd: {reason: too far, seeds: [0], outcomes: [collision]}", {"failed": 2}),
    ],
)
def test_xfail_of_a_scenario(project: Project, entry: str, outcomes: dict[str, int]) -> None:
    project.scenario(content=f"{UNSOLVED}xfail: {{{entry}}}\n")
    result = project.run("--lpb-trials=2", "scenarios", "-rx")
    result.assert_outcomes(**outcomes)
    assert result.ret == (1 if "failed" in outcomes else 0)
    if "xfailed" in outcomes:
        assert "too far" in text_of(result)
    # The data says what happened, whatever was expected.
    assert {row["success"] for row in project.rows()} == {"false"}
    # Which failures were foretold, it says too; reports need no scenario file for it.
    recorded = [read_trial(path).metadata for path in sorted(project.runs()[-1].rglob("seed*.parquet"))]
    known = [metadata["known_failure"] for metadata in recorded if "known_failure" in metadata]
    assert known == ["too far"] * outcomes.get("xfailed", 0)
    report = (project.runs()[-1] / "report.html").read_text("utf-8")
    assert report.count("known failure: too far") == len(known)


@pytest.mark.parametrize(
    ("entry", "outcomes"),
    [
        ("'point/*': too far", {"xfailed": 1}),
        ("'*': {reason: too far, outcomes: [timeout]}", {"xfailed": 1}),
        ("'*': {reason: too far, outcomes: [collision]}", {"failed": 1}),
        ("'*': {reason: too far, seeds: [3]}", {"failed": 1}),
        ("'arm/*': too far", {"failed": 1}),
    ],
)
def test_xfail_of_a_planner_file(project: Project, entry: str, outcomes: dict[str, int]) -> None:
    project.scenario(content=UNSOLVED)
    project.write("planners/mine.yaml", f"planner: pd\nxfail: {{{entry}}}\n")
    project.run("scenarios", planners="mine").assert_outcomes(**outcomes)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("'*': {reson: too far}", "reson"),
        ("'*': {reason: too far, outcomes: [colision]}", "colision"),
        ("'*': {reason: too far, outcomes: collision}", "collision"),
        ("'*': {reason: too far, seeds: three}", "three"),
        ("'*': 3", "3"),
    ],
)
def test_wrong_xfail_of_a_planner_file(project: Project, entry: str, message: str) -> None:
    project.scenario(content=UNSOLVED)
    project.write("planners/mine.yaml", f"planner: pd\nxfail: {{{entry}}}\n")
    result = project.run("scenarios", planners="mine")
    assert result.ret == 4
    assert "mine.yaml" in text_of(result)
    assert message in text_of(result)
    assert "Traceback" not in text_of(result)


def test_a_fault_of_the_software_is_never_expected(project: Project) -> None:
    project.scenario(content=UNSOLVED + "xfail: {broken: too far}\n")
    project.write(
        "conftest.py",
        """
from pytest_lpb import Planner

class Broken(Planner):
    name = "broken"
""",
    )
    project.run("scenarios", planners="broken").assert_outcomes(failed=1)
    assert project.row()["outcome"] == "planner_error"


@pytest.mark.parametrize("strict", ["xfail_strict = true", "strict = true", ""])
def test_an_unexpected_success_is_no_failure(project: Project, strict: str) -> None:
    project.ini(strict)
    project.scenario(content=SCENARIO + "xfail: {pd: too far}\n")
    result = project.run("scenarios")
    result.assert_outcomes(xpassed=1)
    assert result.ret == 0


@pytest.mark.parametrize("mode", ["trial", "rate", "none"])
def test_a_known_failure_is_one_in_every_mode(project: Project, mode: str) -> None:
    project.scenario(content=UNSOLVED + "xfail: {pd: {reason: too far, seeds: [0]}}\n")
    result = project.run(f"--lpb-assert={mode}", "--lpb-trials=2", "scenarios", "-v")
    if mode == "trial":
        result.assert_outcomes(xfailed=1, failed=1)
    else:
        result.assert_outcomes(xfailed=1)
        assert "UNSOLVED (timeout)" in text_of(result)
        assert "XPASS" not in text_of(result)


def test_another_outcome_than_the_known_one_is_no_unexpected_success(project: Project) -> None:
    project.scenario(content=UNSOLVED + "xfail: {pd: {reason: crashes, outcomes: [collision]}}\n")
    result = project.run("--lpb-assert=none", "scenarios", "-v")
    assert result.ret == 0
    assert "UNSOLVED (timeout)" in text_of(result)
    assert "XPASS" not in text_of(result)


def test_runxfail(project: Project) -> None:
    project.scenario(content=UNSOLVED + "xfail: {pd: too far}\n")
    result = project.run("--runxfail", "scenarios")
    result.assert_outcomes(failed=1)
    assert "repeat: pytest --lpb-planners=pd" in text_of(result)
    project.run("--runxfail", "--lpb-assert=none", "scenarios").assert_outcomes(passed=0, failed=0)
