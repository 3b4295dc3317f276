"""`--lpb-baseline`, `--lpb-fail-on`, `--lpb-inconclusive`: the regression gate in pytest."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.cli import main

from .projects import SCENARIO, Project, read_run, text_of

# Goes straight to the goal with a speed that its file says; its trials end when the goal is held.
PLANNER = """
import numpy as np
from dataclasses import dataclass
from pytest_lpb import Planner

class Straight(Planner):
    name = "straight"

    @dataclass(frozen=True)
    class Parameters:
        speed: float = 1.0  # [m/s]

    def compute_action(self, observation):
        error = observation["goal_position"] - observation["q"]
        distance = np.linalg.norm(error)
        return self.parameters.speed * error / max(distance, 0.2)
"""
DRAWN = (
    SCENARIO.replace("body_radius: 0.2", "body_radius: 0.2, control: velocity").replace("duration: 0.5", "duration: 3")
    + "randomize: {draw: [goal], goal: [[0.5, 1], [0.5, 1]]}\ntrials: 24\n"
)
BASELINE = "--lpb-baseline=baseline.json"
# The mean distance is about 1.05 m: at half the speed it takes twice the time, at a tenth it is not reached in 3 s.
SLOWER, TOO_SLOW = 0.5, 0.1


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where `gated` keeps its first run for the next test."""
    return tmp_path_factory.mktemp("measured")


@pytest.fixture
def gated(project: Project, measured: Path) -> Project:
    """A repository with a planner, 24 problems, a run of them, and a baseline."""
    project.write("straight.py", PLANNER)
    set_speed(project, 1.0)
    project.scenario(content=DRAWN)
    if not (measured / "reports").exists():
        assert project.run("scenarios", planners="mine").ret == 0
        assert main([str(project.runs()[-1]), "--save-baseline", str(measured / "baseline.json")]) == 0
        shutil.move(project.path / "reports", measured / "reports")
    shutil.copytree(measured, project.path, symlinks=True, dirs_exist_ok=True)
    return project


def set_speed(project: Project, speed: float) -> None:
    project.write("planners/mine.yaml", f"planner: straight:Straight\nparameters: {{speed: {speed}}}\n")


def test_an_unchanged_planner_keeps_it_open(gated: Project) -> None:
    result = gated.run(BASELINE, "--lpb-fail-on=success:0%,time_to_goal_s:0%", "scenarios", planners="mine")
    assert result.ret == 0, text_of(result)
    result.stdout.re_match_lines(
        [
            "regression gate, baseline baseline.json",
            r"planner +kpi +problems +baseline +now +loss +95 % bounds +margin +verdict",
            r"mine +success +24 +100 % +100 % +0 pp +0 to 0 pp +0 pp +same or better",
            r"mine +time_to_goal_s +24 .* 0 % +same or better",
            r"pp: percentage points, what two success rates differ by",
            r"time_to_goal_s, failures count the duration",
            "gate open: same or better in all that was asked",
            "report: reports/.*/report.html",
        ],
        consecutive=True,
    )
    assert read_run(gated.runs()[-1])["gate"] == {
        "baseline": "baseline.json",
        "fail_on": ["success:0%", "time_to_goal_s:0%"],
        "inconclusive": "pass",
    }


@pytest.mark.parametrize("workers", [0, 2])
def test_a_worse_planner_closes_it(gated: Project, workers: int) -> None:
    set_speed(gated, SLOWER)
    arguments = (BASELINE, "--lpb-fail-on=success:2%,time_to_goal_s:10%", "scenarios")
    result = gated.run_workers(*arguments, planners="mine") if workers else gated.run(*arguments, planners="mine")
    assert result.ret == 1
    result.assert_outcomes(passed=24)
    result.stdout.re_match_lines([r"mine +success .* same or better", r"mine +time_to_goal_s .* regressed"])
    text = text_of(result)
    assert "regressed: mine, time_to_goal_s: worse on 24 of 24 problems" in text
    assert "... and 14 more" in text
    assert "GATE CLOSED: 1 verdict regressed" in text
    # The commands repeat the trials that they stand beside.
    line = next(line for line in result.stdout.lines if line.startswith("  point/x seed"))
    seed = line.split("seed")[1].partition(":")[0]
    command = line[line.index("pytest ") :].split()[1:]
    assert command[-1] == f"scenarios/point/x.yaml::mine::seed{seed}"
    assert gated.run(*command, planners=None).ret == 0
    new = float(line.split(" -> ")[1].split(" s ")[0])
    assert float(gated.row()["time_to_goal_s"]) == pytest.approx(new, rel=1e-3)


def test_by_default_five_points_of_success_are_allowed(gated: Project) -> None:
    set_speed(gated, TOO_SLOW)
    result = gated.run(BASELINE, "--lpb-assert=none", "scenarios", planners="mine")
    assert result.ret == 1
    result.stdout.re_match_lines([r"mine +success +24 +100 % +0 % +100 pp .* 5 pp +regressed"])
    assert "success -> timeout" in text_of(result)


@pytest.mark.parametrize(("mode", "code"), [("pass", 0), ("fail", 1)])
def test_under_twenty_problems_it_is_inconclusive(gated: Project, mode: str, code: int) -> None:
    result = gated.run(
        BASELINE, f"--lpb-inconclusive={mode}", "--lpb-trials=6", "--lpb-seed=20", "scenarios", planners="mine"
    )
    assert result.ret == code
    text = text_of(result)
    assert "inconclusive: mine, success: 4 common problems; 20 are needed; at least 16 further seeds per sc" in text
    assert "not compared: mine: not in the baseline: point/x seed24, point/x seed25" in text
    assert "not compared: mine: only in the baseline: point/x seed0, " in text
    assert ("GATE OPEN, BUT NOT SURE" if code == 0 else "GATE CLOSED: 1 verdict inconclusive") in text


def test_changed_problems_are_left_out(gated: Project) -> None:
    gated.scenario(content=DRAWN.replace("[0.5, 1]]}", "[0.5, 1.1]]}"))
    result = gated.run(BASELINE, "scenarios", planners="mine")
    assert result.ret == 0
    assert "inconclusive: mine, success: no problem in common" in text_of(result)
    assert "not compared: mine: another problem than in the baseline: point/x seed0, " in text_of(result)


def test_a_run_as_baseline(gated: Project) -> None:
    earlier = gated.runs()[-1]
    set_speed(gated, SLOWER)
    for reference in (f"reports/{earlier.name}", "reports/latest"):
        result = gated.run(
            f"--lpb-baseline={reference}", "--lpb-fail-on=time_to_goal_s:0.4s", "scenarios", planners="mine"
        )
        # The newest run before this one is the slower one, for the second.
        assert result.ret == (1 if reference.endswith(earlier.name) else 0), text_of(result)
        assert "regression gate, baseline reports/2" in text_of(result)


def test_another_planner_of_the_run_as_baseline(gated: Project) -> None:
    gated.write("planners/slow.yaml", "planner: straight:Straight\nparameters: {speed: 0.5}\n")
    gate = "--lpb-baseline=planner:mine"
    result = gated.run(gate, "--lpb-fail-on=time_to_goal_s:50%", "scenarios", planners="slow,mine")
    assert result.ret == 1
    result.stdout.re_match_lines([r"slow \(was mine\) +time_to_goal_s +24 .* regressed"])
    result = gated.run(gate, "--lpb-fail-on=time_to_goal_s:200%", "scenarios", planners="slow,mine")
    assert result.ret == 0


@pytest.mark.parametrize(
    ("edit", "reason"),
    [
        (lambda content: content["machine"].update(cpu="abacus"), "the baseline is of another machine (cpu differ)"),
        (lambda content: content["planners"]["mine"]["trials"][7].__setitem__(5, True), "timing was contended: other"),
    ],
    ids=["another machine", "contended"],
)
def test_timing_that_does_not_compare_never_gates(
    gated: Project, edit: Callable[[dict[str, Any]], object], reason: str
) -> None:
    path = gated.path / "baseline.json"
    kpis = "--lpb-kpis=solver_time_p50_ms"
    gated.run(kpis, "scenarios", planners="mine")
    assert main([str(gated.runs()[-1]), "--save-baseline", str(path), "--kpis=solver_time_p50_ms"]) == 0
    content = json.loads(path.read_text("utf-8"))
    edit(content)
    path.write_text(json.dumps(content), "utf-8")
    result = gated.run(BASELINE, kpis, "--lpb-fail-on=solver_time_p50_ms:0%", "scenarios", planners="mine")
    assert result.ret == 0
    assert f"inconclusive: mine, solver_time_p50_ms: {reason}" in text_of(result)


def test_planners_that_the_baseline_does_not_know_are_named(gated: Project) -> None:
    result = gated.run(BASELINE, "--lpb-assert=none", "scenarios", planners="mine,pd")
    assert result.ret == 0
    assert "not compared: pd: the baseline does not know this planner" in text_of(result)


def test_ini(gated: Project) -> None:
    (gated.path / "ci").mkdir()
    (gated.path / "baseline.json").rename(gated.path / "ci/baseline.json")
    gated.ini("lpb_baseline = ci/baseline.json", "lpb_fail_on = success:2% time_to_goal_s:10%")
    set_speed(gated, SLOWER)
    result = gated.run("scenarios", planners="mine")
    assert result.ret == 1
    assert "regression gate, baseline ci/baseline.json" in text_of(result)
    assert "GATE CLOSED: 1 verdict regressed" in text_of(result)
    # Options come before ini values; an empty baseline turns the gate off.
    assert gated.run("--lpb-fail-on=time_to_goal_s:300%", "scenarios", planners="mine").ret == 0
    result = gated.run("--lpb-baseline=", "scenarios", planners="mine")
    assert result.ret == 0
    assert "regression gate" not in text_of(result)
    # Single trials are not judged: who repeats one wants to see it.
    result = gated.run("scenarios/point/x.yaml::mine::seed3", planners="mine")
    assert result.ret == 0
    assert "regression gate" not in text_of(result)
    gated.ini("lpb_baseline = ci/baseline.json", "lpb_inconclusive = fail")
    assert gated.run("--lpb-trials=3", "scenarios", planners="mine").ret == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--lpb-baseline=else.json"], "--lpb-baseline: found 'else.json', and there is no "),
        (["--lpb-baseline=planner:other"], "--lpb-baseline: no planner 'other' in this run"),
        (["--lpb-baseline=planner:mine"], "--lpb-baseline: mine is the only planner of this run"),
        (["--lpb-baseline=reports"], "reports is no run folder: it has no run.json; run folders in "),
        (["--lpb-baseline=straight.py"], "straight.py is no baseline: it is no JSON"),
        (["--lpb-fail-on=success:2%"], "--lpb-fail-on (or ini lpb_fail_on): nothing to compare with"),
        ([BASELINE, "--lpb-fail-on="], "--lpb-fail-on: found no margin"),
        ([BASELINE, "--lpb-fail-on=success:2m"], "--lpb-fail-on: success: found 2m; allowed are percentage points"),
        ([BASELINE, "--lpb-fail-on=sucess:2%"], "did you mean 'success'?"),
        (
            [BASELINE, "--lpb-fail-on=solver_time_p95_ms:2%", "--lpb-kpis=solver_time_p95_ms"],
            "baseline.json has no values of solver_time_p95_ms, but of time_to_goal_s; save it again with",
        ),
        (
            [BASELINE, "--lpb-fail-on=clearance_min_m:2%"],
            "unknown KPI 'clearance_min_m'; margins may have: success, time_to_goal_s",
        ),
        ([BASELINE, "-o", "lpb_inconclusive=maybe"], "--lpb-inconclusive: found 'maybe'; allowed are fail, pass"),
        ([BASELINE, "--lpb-planners=pd"], "has no planner of this run: it has mine, the run pd"),
    ],
)
def test_wrong_options(gated: Project, arguments: list[str], message: str) -> None:
    runs = gated.runs()
    result = gated.run(*arguments, "scenarios", planners="mine")
    assert result.ret == 4, text_of(result)
    assert message in text_of(result)
    assert gated.runs() == runs


def test_a_baseline_that_vanishes_meanwhile_closes_it(gated: Project) -> None:
    earlier = gated.runs()[-1]
    gated.write(
        "conftest.py",
        f"import shutil\ndef pytest_runtestloop(session): shutil.rmtree({str(earlier / 'run.json')!r}, "
        f"ignore_errors=True); __import__('os').unlink({str(earlier / 'run.json')!r})\n",
    )
    result = gated.run(f"--lpb-baseline={earlier}", "scenarios", planners="mine")
    assert result.ret == 1
    assert f"warning: the gate cannot be judged: {earlier / 'run.json'}: cannot be read: " in text_of(result)


KPI = """
from pytest_lpb import kpi

@kpi(name="height_max_m", unit="m", direction="higher", over="all")
def height(trajectory):
    return trajectory.q[:, 1].max()
"""


@pytest.mark.parametrize("place", ["conftest.py", "ini"])
def test_a_kpi_of_ones_own_gates(gated: Project, place: str) -> None:
    if place == "ini":
        gated.write("heights.py", KPI)
        gated.ini("lpb_plugins = heights")
    else:
        gated.write("conftest.py", KPI)
    kpis = "--lpb-kpis=height_max_m"
    assert gated.run(kpis, "scenarios", planners="mine").ret == 0
    assert main([str(gated.runs()[-1]), "--save-baseline", str(gated.path / "baseline.json")]) == 0
    saved = json.loads((gated.path / "baseline.json").read_text("utf-8"))
    assert saved["columns"][-1] == "height_max_m"
    gate = (BASELINE, "--lpb-fail-on=height_max_m:0.05m", kpis)
    assert gated.run(*gate, "scenarios", planners="mine").ret == 0
    set_speed(gated, TOO_SLOW)
    result = gated.run(*gate, "--lpb-assert=none", "scenarios", planners="mine")
    assert result.ret == 1
    result.stdout.re_match_lines([r"mine +height_max_m +24 .* 0.05 m +regressed"])
    assert main([str(gated.runs()[-1]), "--baseline", str(gated.path / "baseline.json"), "--fail-on=success:100%"]) == 0
    assert main(
        [str(gated.runs()[-1]), "--baseline", str(gated.path / "baseline.json"), "--fail-on=height_max_m:0.05m"]
    ) == 1  # fmt: skip


def test_nothing_of_it_without_a_baseline(project: Project, tmp_path: Path) -> None:
    project.scenario()
    result = project.run("scenarios")
    assert "gate" not in read_run(project.runs()[-1])
    assert "regression gate" not in text_of(result)


STUDY = """\
study: does it still work?
scenarios: [scenarios/point/x.yaml]
planners: [mine]
gate: {baseline: baseline.json, fail_on: "time_to_goal_s:10%"}
"""


def test_a_study_has_its_gate(gated: Project) -> None:
    gated.write("study.yaml", STUDY)
    assert gated.run("study.yaml", planners=None).ret == 0
    set_speed(gated, SLOWER)
    result = gated.run("study.yaml", planners=None)
    assert result.ret == 1
    result.stdout.re_match_lines(["regression gate, baseline baseline.json", r"mine +time_to_goal_s +24 .* regressed"])
    assert gated.run("--lpb-fail-on=time_to_goal_s:300%", "study.yaml", planners=None).ret == 0
    assert "regression gate" not in text_of(gated.run("--lpb-baseline=", "study.yaml", planners=None))


def test_a_run_that_is_finished_later_is_gated_as_it_was_to_be(gated: Project) -> None:
    set_speed(gated, TOO_SLOW)
    result = gated.run(BASELINE, "--lpb-fail-on=success:3%", "-x", "scenarios", planners="mine")
    assert result.ret == 1
    run = gated.runs()[-1]
    assert len(gated.rows(run)) < 24
    assert "GATE OPEN, BUT NOT SURE" in text_of(result)
    result = gated.run(f"--lpb-resume={run}", planners=None, fast=False)
    assert result.ret == 1
    result.stdout.re_match_lines([r"mine +success +24 .* 3 pp +regressed"])


def test_lpb_report_judges_a_gated_run_again(gated: Project, capsys: pytest.CaptureFixture[str]) -> None:
    set_speed(gated, SLOWER)
    assert gated.run(BASELINE, "--lpb-fail-on=time_to_goal_s:10%", "scenarios", planners="mine").ret == 1
    run = str(gated.runs()[-1])
    page = gated.runs()[-1] / "report.html"
    before = page.read_bytes()
    capsys.readouterr()
    # Looking at a run that failed is no failure; asking whether it regressed is.
    assert main([run]) == 0
    assert "GATE CLOSED: 1 verdict regressed" in capsys.readouterr().out
    assert page.read_bytes() == before
    assert main([run, "--baseline=baseline.json", "--fail-on=time_to_goal_s:10%"]) == 1
    assert main([run, "--baseline=baseline.json", "--fail-on=time_to_goal_s:300%"]) == 0
    (gated.path / "baseline.json").unlink()
    capsys.readouterr()
    assert main([run]) == 0
    captured = capsys.readouterr()
    assert "GATE" not in captured.out
    assert "note: the run's gate is left out: --lpb-baseline: found 'baseline.json', and there is no" in captured.err
