"""Beside other plugins that report: junit files, no terminal, no cache, no xdist, warnings as errors."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import pytest

from .projects import SCENARIO, UNSOLVED, Project, read_table, text_of


@pytest.mark.parametrize(
    "arguments",
    [
        ("-p", "no:terminal"),
        ("-p", "no:xdist"),
        ("-p", "no:benchmark"),
        ("-p", "no:cacheprovider"),
        ("-p", "no:rerunfailures"),
        ("-p", "no:junitxml"),
        ("-p", "no:skipping"),
        ("-W", "error"),
        ("-o", "strict=true"),
        ("-q", "-q"),
        ("-vv", "-s"),
        ("--tb=no",),
    ],
    ids=" ".join,
)
def test_runs_in_any_company(project: Project, arguments: tuple[str, ...]) -> None:
    project.scenario(content=SCENARIO + "xfail: {potential_field: {reason: why not, seeds: [5]}}\n")
    result = project.run(*arguments, "--lpb-trials=2", "scenarios")
    assert result.ret == 0, text_of(result)
    assert [row["outcome"] for row in project.rows()] == ["success", "success"]


def test_junit_file(project: Project) -> None:
    project.scenario()
    project.scenario("scenarios/far.yaml", UNSOLVED)
    project.run("--junitxml=junit.xml", "scenarios").assert_outcomes(passed=1, failed=1)
    cases = ET.parse(project.path / "junit.xml").findall(".//testcase")
    assert [(case.get("classname"), case.get("name")) for case in cases] == [
        ("scenarios.far.yaml.pd", "seed0"),
        ("scenarios.point.x.yaml.pd", "seed0"),
    ]
    assert all(case.find("properties") is None for case in cases)
    failure = cases[0].find("failure")
    assert failure is not None
    assert "repeat: pytest --lpb-planners=pd" in str(failure.text)
    assert cases[1].find("failure") is None


def test_a_run_without_a_summary_has_its_tables(project: Project) -> None:
    project.scenario()
    result = project.run("--no-summary", "scenarios")
    assert result.ret == 0
    assert read_table(project.runs()[-1] / "summary.csv")


@pytest.mark.parametrize("arguments", [("--markers",), ("--fixtures",), ("--setup-plan", "scenarios"), ("--version",)])
def test_what_runs_nothing_makes_no_folder(project: Project, arguments: tuple[str, ...]) -> None:
    project.scenario()
    result = project.run(*arguments)
    assert result.ret == 0
    assert project.runs() == []
    if arguments == ("--markers",):
        assert "@pytest.mark.planar: scenario tag: in the plane" in text_of(result)
