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
    failure = cases[0].find("failure")
    assert failure is not None
    assert "repeat: pytest --lpb-planners=pd" in str(failure.text)
    assert cases[1].find("failure") is None


def properties(case: ET.Element) -> list[tuple[str | None, str | None]]:
    return [(entry.get("name"), entry.get("value")) for entry in case.findall("properties/property")]


@pytest.mark.parametrize("workers", [0, 2])
def test_a_trials_outcome_and_kpis_are_properties_of_its_test_case(project: Project, workers: int) -> None:
    project.scenario()
    project.scenario("scenarios/far.yaml", UNSOLVED)
    arguments = ("--junitxml=junit.xml", "--lpb-kpis=time_to_goal_s,solver_time_p50_ms", "scenarios")
    result = project.run_workers(*arguments) if workers else project.run(*arguments)
    result.assert_outcomes(passed=1, failed=1)
    cases = {case.get("classname"): case for case in ET.parse(project.path / "junit.xml").iter("testcase")}
    assert len(cases) == 2
    for row in project.rows():
        scenario = row["scenario"].replace("/", ".")
        found = properties(cases[f"scenarios.{scenario}.yaml.pd"])
        names = ("outcome", "success", "failed_criteria", "problem_hash", "attempt", "timing_contended")
        kpis = ("time_to_goal_s", "solver_time_p50_ms")
        # The same text as in trials.csv; a KPI that does not apply has an empty cell there, and no property.
        expected = {f"lpb_{name}": row[name] for name in (*names, *kpis)}
        assert found == [(name, value) for name, value in expected.items() if value or name == "lpb_failed_criteria"]
        assert ("lpb_time_to_goal_s" in dict(found)) == (scenario == "point.x")


def test_properties_of_a_trial_that_was_rerun_are_those_of_its_first_attempt(project: Project) -> None:
    project.scenario(content=UNSOLVED)
    project.run("--junitxml=junit.xml", "--reruns=2", "scenarios").assert_outcomes(failed=1)
    for case in ET.parse(project.path / "junit.xml").iter("testcase"):
        names = [name for name, _ in properties(case)]
        assert len(names) == len(set(names))
        assert dict(properties(case)).get("lpb_attempt") == "1"


def test_faults_of_kpis_and_own_kpis_in_junit_files(project: Project) -> None:
    project.write(
        "conftest.py",
        "from pytest_lpb import kpi\n"
        "@kpi(name='own_m', unit='m', direction='lower', over='all')\ndef own(trajectory):\n    return 1.5\n"
        "@kpi(name='broken', unit='1', direction='lower', over='all')\ndef broken(trajectory):\n    return 1 / 0\n",
    )
    project.scenario()
    result = project.run("--junitxml=junit.xml", "--lpb-kpis=own_m,broken", "scenarios")
    assert result.ret == 1
    (case,) = ET.parse(project.path / "junit.xml").iter("testcase")
    assert dict(properties(case))["lpb_own_m"] == "1.5"
    assert "lpb_broken" not in dict(properties(case))
    assert text_of(result).count("KPI broken is NaN") == 1


def test_without_a_junit_file_reports_carry_no_properties(project: Project) -> None:
    project.write("conftest.py", "def pytest_runtest_logreport(report): assert report.user_properties == []\n")
    project.scenario()
    assert project.run("scenarios").ret == 0


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
