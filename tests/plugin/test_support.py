"""Trials that planners do not support are skipped: no failures, not missing, and of no weight in any figure."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from pytest_lpb.cli import main

from .projects import DRAWN, UNSOLVED, Project, read_run, read_table, text_of

PLANNERS = """
from pytest_lpb import Planner
from pytest_lpb.planner.pd import PD

class Arms(Planner):
    name = "arms"
    supports = {"robots": ["planar_arm_*"]}

class Even(PD):
    name = "even"
    def supports(self, problem):
        return True if problem.seed % 2 == 0 else "odd seeds are beyond it"
"""
REASON = "odd seeds are beyond it"


@pytest.fixture
def choosy(project: Project) -> Project:
    project.write("my_planners.py", PLANNERS)
    project.write("planners/arms.yaml", "planner: my_planners:Arms\n")
    project.write("planners/even.yaml", "planner: my_planners:Even\n")
    project.write("planners/elsewhere.yaml", "planner: my_planners:Even\nisolate: true\n")
    project.write("planners/slow.yaml", "planner: pd\nsupports: {control: velocity}\nper_robot: {pont: {p: 2.0}}\n")
    project.scenario("scenarios/drawn.yaml", DRAWN)
    return project


def check_skips(run: Path, planners: list[str]) -> None:
    """Even seeds are skipped by `arms` and `slow` as declared, odd ones by the others' method as well."""
    expected = {
        "arms": ("4", "0-3", "it supports robots planar_arm_*, and this one is point"),
        "slow": ("4", "0-3", "it supports control velocity, and this is acceleration"),
        "even": ("2", "1,3", REASON),
        "elsewhere": ("2", "1,3", REASON),
    }
    rows = read_table(run / "skipped.csv")
    found = {row["planner"]: (row["skipped"], row["seeds"], row["reason"]) for row in rows}
    assert found == {name: expected[name] for name in planners if name in expected}
    assert not (run / "missing.csv").exists()


def test_skips_are_counted_and_weigh_nothing(choosy: Project) -> None:
    planners = ["pd", "arms", "even", "elsewhere", "slow"]
    choosy.scenario("scenarios/far.yaml", UNSOLVED.replace("point,", "point, control: velocity,"))
    choosy.write("planners/pd.yaml", "planner: pd\nsupports: {control: [acceleration]}\n")
    result = choosy.run("--lpb-trials=4", "scenarios/drawn.yaml", planners=",".join(planners))
    result.assert_outcomes(passed=8, skipped=12, warnings=1)
    text = text_of(result)
    assert (
        "no robot of this run matches 'pont' of planner 'slow' (did you mean 'point'?); there are point@accel" in text
    )
    assert f"skipped: 2 trials of even, not counted in its figures: {REASON}" in text
    (run,) = choosy.runs()
    check_skips(run, planners)
    summary = {row["planner"]: row for row in read_table(run / "summary.csv") if row["scenario"] == "all"}
    assert {name: (row["trials"], row["success_rate"]) for name, row in summary.items()} == {
        "pd": ("4", "1.0"),
        "even": ("2", "1.0"),
        "elsewhere": ("2", "1.0"),
    }
    pairs = {(row["planner_a"], row["planner_b"]): row["pairs"] for row in read_table(run / "comparisons.csv")}
    assert pairs["even", "pd"] == "2"
    assert read_run(run)["planners"]["arms"]["supports"] == [{"robots": ["planar_arm_*"]}, {}]
    # Whoever evaluates it again, or finishes it, finds the same.
    before = {path.name: path.read_bytes() for path in run.glob("*.csv")}
    assert main([str(run)]) == 0
    assert {path.name: path.read_bytes() for path in run.glob("*.csv")} == before
    resumed = choosy.run(f"--lpb-resume={run}", planners=None)
    resumed.assert_outcomes(passed=8, skipped=12, warnings=1)
    # Means are over what a planner ran: it loses nothing by a scenario that it does not take.
    both = choosy.run("--lpb-trials=2", "scenarios", planners="pd,even")
    assert "skipped: 2 trials of pd, not counted in its figures: it supports control accel" in text_of(both)
    rates = {row["planner"]: row["success_rate"] for row in read_table(choosy.runs()[-1] / "summary.csv")[-2:]}
    assert rates == {"even": "0.5", "pd": "1.0"}


def test_with_plugins_loaded_by_hand_and_workers(choosy: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    result = choosy.pytester.run(
        *(sys.executable, "-m", "pytest", "-p", "xdist.plugin", "-p", "pytest_lpb.plugin", "-n", "2", "-rs"),
        *("--lpb-planners=even,arms", "--lpb-trials=4", "--lpb-report=none"),
    )
    result.assert_outcomes(passed=2, skipped=6)
    result.stdout.fnmatch_lines_random(
        [
            f"SKIPPED [[]2] scenarios/drawn.yaml:1: even: {REASON}",
            "SKIPPED [[]4] scenarios/drawn.yaml:1: arms: it supports robots planar_arm_*, and this one is point",
        ]
    )
    assert "trials were run" not in text_of(result)
    (run,) = choosy.runs()
    assert main([str(run)]) == 0
    check_skips(run, ["even", "arms"])


def test_wrong_declarations_are_told_before_anything_runs(choosy: Project) -> None:
    choosy.write("planners/slow.yaml", "planner: pd\nsupports: {contrl: velocity}\n")
    result = choosy.run(planners="slow")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    place = choosy.path / "planners/slow.yaml"
    assert f"{place}:2: supports: contrl: unknown key; did you mean 'control'?; allowed: base, con" in text_of(result)
