"""`lpb-report`: baselines, the gate, and Markdown."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.cli import main

from .plugin.projects import read_table


@pytest.fixture
def run(finished_run: Path, tmp_path: Path) -> Path:
    """A copy of a finished run with two planners, two scenarios and two seeds."""
    folder = tmp_path / "runs" / finished_run.name
    shutil.copytree(finished_run, folder)
    return folder


def saved(run: Path, *arguments: str) -> dict[str, Any]:
    path = run.parent / "baseline.json"
    assert main([str(run), "--save-baseline", str(path), *arguments]) == 0
    content: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return content


def test_a_baseline_is_saved_and_found_the_same(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = saved(run)
    assert list(content["planners"]) == ["pd", "potential_field"]
    assert f"baseline: {run.parent / 'baseline.json'}" in capsys.readouterr().out
    gate = ["--baseline", str(run.parent / "baseline.json"), "--fail-on=success:0%,time_to_goal_s:0.1s"]
    assert main([str(run), *gate]) == 0
    text = capsys.readouterr().out
    assert text.count("3 common problems; 20 are needed") == 4
    assert "GATE OPEN, BUT NOT SURE: 4 verdicts inconclusive" in text
    assert main([str(run), *gate, "--inconclusive=fail"]) == 1
    assert "GATE CLOSED: 4 verdicts inconclusive" in capsys.readouterr().out


def test_what_is_saved_can_be_chosen(run: Path) -> None:
    content = saved(run, "--planners=pd", "--scenarios=drawn", "--kpis=clearance_mean_m,path_length_m,first_call_ms")
    assert [len(planner["trials"]) for planner in content["planners"].values()] == [2]
    assert content["columns"][5:] == ["timing_contended", "path_length_m", "clearance_mean_m", "first_call_ms"]
    # The run's own tables have all KPIs still.
    assert "sparc" in read_table(run / "trials.csv")[0]


def test_planner_of_the_run_as_baseline(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), "--baseline=planner:pd", "--fail-on=success:10%", "--planners=potential_field"]) == 0
    assert "potential_field (was pd)" in capsys.readouterr().out


def test_one_scenario_alone(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    saved(run)
    gate = ["--baseline", str(run.parent / "baseline.json"), "--scenarios=drawn"]
    capsys.readouterr()
    assert main([str(run), *gate]) == 0
    text = capsys.readouterr().out
    assert text.count("2 common problems; 20 are needed") == 2
    assert "not compared" not in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--fail-on=success:2%"], "--fail-on: nothing to compare with; add --baseline=RUN_OR_FILE"),
        (["--baseline=nowhere.json"], "--baseline: found 'nowhere.json', and there is no nowhere.json"),
        (["--baseline=planner:mpc"], "--baseline: no planner 'mpc' in this run"),
        (["--baseline=planner:pd", "--fail-on=success:2"], "--fail-on: success: found 2; allowed are percentage poin"),
        (["--baseline=planner:pd", "--fail-on=sprac:2%"], "unknown KPI 'sprac'; did you mean 'sparc'"),
        (["--trial=drawn.yaml::pd::seed0", "--baseline=x"], "--trial shows one trial; leave --baseline out"),
        (["--trial=drawn.yaml::pd::seed0", "--markdown"], "--trial shows one trial; leave --markdown out"),
    ],
)
def test_wrong_arguments(run: Path, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), *arguments]) == 4
    assert message in capsys.readouterr().err


def test_inconclusive_has_two_values(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main([str(run), "--baseline=planner:pd", "--inconclusive=maybe"])
    assert caught.value.code == 4
    assert "invalid choice: 'maybe'" in capsys.readouterr().err


def test_markdown_on_the_standard_output_is_alone_there(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), "--markdown", "--baseline=planner:pd"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("### Local planner benchmark: 2 planners, 2 scenarios, 8 trials\n\n| planner | ")
    assert "**GATE OPEN, BUT NOT SURE: 1 verdict inconclusive" in captured.out
    assert "report: " not in captured.out
    assert f"report: {run / 'report.html'}" in captured.err


def test_markdown_in_a_file(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "comment.md"
    assert main([str(run), "--markdown", str(path)]) == 0
    assert f"markdown: {path}" in capsys.readouterr().out
    text = path.read_text("utf-8")
    assert "GATE" not in text
    assert "<details><summary>4 trials without success</summary>" in text
