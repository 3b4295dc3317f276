"""`--lpb-assert`: what fails a run."""

from __future__ import annotations

import pytest

from pytest_lpb.statistics import wilson_interval

from .projects import DRAWN, SCENARIO, UNSOLVED, Project, text_of

BROKEN = """
from pytest_lpb import Planner

class Broken(Planner):
    name = "broken"
"""
# Seeds 0, 1, 2, .. succeed or not by where their goal is drawn.
MIXED = DRAWN.replace("[[-0.06, 0.06], [-0.06, 0.06]]", "[[-0.18, 0.18], [-0.18, 0.18]]")


def test_by_default_every_failed_trial_fails(project: Project) -> None:
    project.scenario()
    project.scenario("scenarios/far.yaml", UNSOLVED)
    result = project.run("scenarios")
    result.assert_outcomes(passed=1, failed=1)
    assert result.ret == 1


def test_none_lets_plans_fail(project: Project) -> None:
    project.scenario()
    project.scenario("scenarios/far.yaml", UNSOLVED.replace("hold_time: 0.2}", "hold_time: 0.2, rate: '>= 1'}"))
    result = project.run("--lpb-assert=none", "scenarios")
    assert result.ret == 0
    result.stdout.fnmatch_lines(["scenarios/far.yaml u *", "scenarios/point/x.yaml . *", "*1 passed, 1 unsolved*"])
    assert [row["success"] for row in project.rows()] == ["false", "true"]


@pytest.mark.parametrize("mode", ["rate", "none"])
def test_faults_of_the_software_fail_in_every_mode(project: Project, mode: str) -> None:
    project.write("conftest.py", BROKEN)
    project.scenario()
    result = project.run(f"--lpb-assert={mode}", "scenarios", planners="broken")
    result.assert_outcomes(failed=1)
    assert result.ret == 1


def test_a_success_that_misses_its_criteria(project: Project) -> None:
    project.scenario(content=SCENARIO.replace("hold_time: 0.2}", "hold_time: 0.2, time_to_goal_s: '<= -1'}"))
    result = project.run("scenarios")
    result.assert_outcomes(failed=1)
    row = project.row()
    assert (row["outcome"], row["success"]) == ("success", "false")
    assert row["failed_criteria"].startswith("time_to_goal_s")
    assert "but not time_to_goal_s" in text_of(result)


def test_rates(project: Project) -> None:
    project.scenario("scenarios/free.yaml", UNSOLVED)
    project.scenario("scenarios/high.yaml", MIXED.replace("hold_time: 0.2}", "hold_time: 0.2, rate: '>= 0.99'}"))
    project.scenario("scenarios/low.yaml", MIXED.replace("hold_time: 0.2}", "hold_time: 0.2, rate: '>= 0.01'}"))
    result = project.run("--lpb-assert=rate", "--lpb-trials=10", "scenarios", "-v")
    assert result.ret == 1
    rows = [row for row in project.rows() if row["scenario"] == "high"]
    failed = [row["seed"] for row in rows if row["success"] == "false"]
    assert 0 < len(failed) < 10
    text = text_of(result)
    rate = 1 - len(failed) / 10
    low, high = wilson_interval(10 - len(failed), 10)
    assert f"FAILED: high :: pd: success rate {rate:.3f} (95 % interval {low:.3f} to {high:.3f}, " in text
    assert f"10 problems), required >= 0.99; unsolved seeds: {', '.join(failed)}" in text
    assert f"met: low :: pd: success rate {rate:.3f}" in text
    assert "free :: pd: success rate" not in text
    assert f"{10 + 2 * len(failed)} unsolved" in text
    assert " failed" not in result.stdout.lines[-1]
    assert text.count("UNSOLVED (timeout)") >= 10


def test_rates_that_are_met(project: Project) -> None:
    project.scenario(content=SCENARIO.replace("hold_time: 0.2}", "hold_time: 0.2, rate: '>= 1'}"))
    result = project.run("--lpb-assert=rate", "scenarios")
    assert result.ret == 0
    assert "met: point/x :: pd: success rate 1.000" in text_of(result)


def test_rates_with_workers(project: Project) -> None:
    project.scenario(content=UNSOLVED.replace("hold_time: 0.2}", "hold_time: 0.2, rate: '>= 0.5'}"))
    result = project.run_workers("--lpb-assert=rate", "--lpb-trials=2", "scenarios")
    assert result.ret == 1
    assert "required >= 0.5; unsolved seeds: 0, 1" in text_of(result)
    assert "2 unsolved" in text_of(result)
