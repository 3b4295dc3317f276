"""`lpb-report RUN --retime`: recorded calls timed again with pytest-benchmark in a process of its own."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.cli import EXIT_WARNINGS, main
from pytest_lpb.commands import EXIT_USAGE
from pytest_lpb.retime.result import read_retimed

from .projects import DRAWN, SCENARIO, UNSOLVED, Project, read_run
from .test_own_code import PLANNER, lpb_report


@pytest.fixture
def run(finished_run: Path, tmp_path: Path) -> Path:
    """A copy of a run with pd and potential_field, two scenarios, two seeds."""
    return shutil.copytree(finished_run, tmp_path / "a run")


def benchmarks(file: Path) -> list[dict[str, Any]]:
    content = json.loads(file.read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = content["benchmarks"]
    return found


def test_every_planner_and_scenario(
    run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    # What a user has set for other runs of pytest is not for this one.
    monkeypatch.setenv("PYTEST_ADDOPTS", "-n 2 --benchmark-disable -k nothing")
    monkeypatch.setenv("PYTEST_PLUGINS", "no_such_plugin")
    raw = {path: path.read_bytes() for path in (run / "trials").rglob("*.*")}
    tables = {name: (run / name).read_bytes() for name in ("trials.csv", "summary.csv", "comparisons.csv")}
    assert main([str(run), "--retime", "3"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    found = benchmarks(run / "retimed.json")
    keys = [(entry["group"], entry["name"]) for entry in found]
    assert keys == [(scenario, planner) for scenario in ("drawn", "unsolved") for planner in ("pd", "potential_field")]
    for entry in found:
        info, stats = entry["extra_info"], entry["stats"]
        # A call per step of 0.05 s, but for the first, in two trials and three passes.
        steps = [
            int(row["steps"])
            for row in rows_of(run)
            if (row["scenario"], row["planner"]) == (entry["group"], entry["name"])
        ]
        assert stats["rounds"] == info["calls"] == 3 * sum(step - 1 for step in steps)
        assert (info["trials"], info["passes"], info["different_trials"]) == (2, 3, 0)
        assert info["deadline_calls"] == info["calls"] + 6
        assert info["period_ms"] == 50.0
        assert stats["median"] * 1e3 == pytest.approx(info["p50_ms"])
        assert stats["max"] * 1e3 == pytest.approx(info["max_ms"])
        assert info["p50_ms"] <= info["p95_ms"] <= info["p99_ms"] <= info["max_ms"]
        assert info["noise_p50"] > 0.0
        assert entry["options"]["timer"] == "perf_counter"
    assert {tuple(line.split()[:2]) for line in shown.out.splitlines()} >= set(keys)
    assert "A/A noise floor of this machine: " in shown.out
    assert 'id="retimed"' in (run / "report.html").read_text(encoding="utf-8")
    # Raw data and tables are as they were.
    assert {path: path.read_bytes() for path in (run / "trials").rglob("*.*")} == raw
    assert {name: (run / name).read_bytes() for name in tables} == tables


def rows_of(run: Path) -> list[dict[str, str]]:
    import csv

    with (run / "trials.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_pytest_benchmark_compares_it(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), "--retime", "2", "--scenarios", "drawn"]) == 0
    assert not (run / "retimed.json").exists()
    file = run / "selected" / "retimed.json"
    assert {entry["group"] for entry in benchmarks(file)} == {"drawn"}
    assert json.loads(file.read_text(encoding="utf-8"))["machine_info"]["node"] == ""
    capsys.readouterr()
    command = [sys.executable, "-m", "pytest_benchmark", "compare", str(file), "--columns=median,rounds"]
    result = subprocess.run(command, cwd=run.parent, capture_output=True, text=True, check=True)
    assert "benchmark 'drawn': 2 tests" in result.stdout
    lines = {line.split()[0]: line.split()[-1] for line in result.stdout.splitlines() if line.startswith(("pd", "pot"))}
    rounds = {entry["name"]: str(entry["stats"]["rounds"]) for entry in benchmarks(file)}
    assert lines == rounds


def test_other_options_choose(run: Path, tmp_path: Path) -> None:
    output = tmp_path / "elsewhere"
    assert main([str(run), "--planners=pd", "--scenarios=unsolved", "--retime", "2", f"--output={output}"]) == 0
    assert [(e["group"], e["name"]) for e in benchmarks(output / "retimed.json")] == [("unsolved", "pd")]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--retime", "1"], "--retime: found 1 passes; allowed are 2 to 1000"),
        (["--retime", "1001"], "--retime: found 1001 passes"),
        (["--retime", "--trial=drawn.yaml::pd::seed0"], "choose with --planners and --scenarios, not --trial"),
    ],
)
def test_wrong_arguments(run: Path, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), *arguments]) == EXIT_USAGE
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("place", ["conftest.py", "my_package/planners.py"])
def test_planners_of_users_are_found_from_elsewhere(
    project: Project, tmp_path_factory: pytest.TempPathFactory, place: str
) -> None:
    project.ini()
    project.write(place, PLANNER)
    if place == "conftest.py":
        chosen = "mine"
    else:
        project.write("my_package/__init__.py", "")
        project.write(
            "planners/chosen.yaml", "planner: my_package.planners:Mine\nparameters: {push: 0.1}\nperiod: 0.1\n"
        )
        chosen = "chosen"
    project.scenario()
    project.run("scenarios", planners=chosen).assert_outcomes(passed=1)
    run = project.runs()[-1]
    result = lpb_report(tmp_path_factory.mktemp("elsewhere"), run, "--retime", "2")
    assert (result.returncode, result.stderr) == (0, "")
    retimed = read_retimed(run / "retimed.json")
    assert retimed is not None
    (row,) = retimed.rows
    assert (row.planner, row.different_trials) == (chosen, 0)
    assert row.period_ms == (50.0 if chosen == "mine" else 100.0)


def test_a_planner_that_is_gone(project: Project, tmp_path_factory: pytest.TempPathFactory) -> None:
    project.ini()
    module = project.write("gone.py", PLANNER)
    project.write("planners/tuned.yaml", "planner: gone:Mine\n")
    project.scenario()
    project.run("scenarios", planners="tuned").assert_outcomes(passed=1)
    module.unlink()
    run = project.runs()[-1]
    result = lpb_report(tmp_path_factory.mktemp("elsewhere"), run, "--retime")
    assert result.returncode == EXIT_USAGE
    assert (
        "planner 'tuned' of this run cannot be loaded again: planner 'gone:Mine': cannot import 'gone'" in result.stderr
    )
    assert f"the run had it from {module}" in result.stderr
    assert not (run / "retimed.json").exists()


def test_a_planner_that_has_changed(project: Project, tmp_path_factory: pytest.TempPathFactory) -> None:
    project.ini()
    project.write("changing.py", PLANNER)
    project.write("planners/tuned.yaml", "planner: changing:Mine\n")
    project.scenario(content=SCENARIO)
    project.run("scenarios", planners="tuned").assert_outcomes(passed=1)
    project.write("changing.py", PLANNER.replace("self.parameters.push, 0.0", "self.parameters.push, 0.125"))
    run = project.runs()[-1]
    result = lpb_report(tmp_path_factory.mktemp("elsewhere"), run, "--retime", "2")
    assert result.returncode == EXIT_WARNINGS
    assert "planner 'tuned' has changed since the run: its source is another" in result.stderr
    steps = int(project.row()["steps"])
    assert f"actions differ from the recorded ones in {steps} of {steps} calls, first in row 0" in result.stderr
    (entry,) = benchmarks(run / "retimed.json")
    assert entry["extra_info"]["different_trials"] == 1


def test_a_planner_that_raises_now_leaves_the_others(
    project: Project, tmp_path_factory: pytest.TempPathFactory
) -> None:
    project.ini()
    project.write("failing.py", PLANNER)
    project.write("planners/tuned.yaml", "planner: failing:Mine\n")
    project.scenario("scenarios/a.yaml", UNSOLVED)
    project.run("scenarios", "--lpb-assert=none", planners="pd,tuned").stdout.fnmatch_lines("*2 unsolved*")
    # It raises in the fifth pass only: while it is timed.
    counting = "np.array([self.parameters.push if self.setups < 5 else 1 / 0, 0.0])\n\n    setups = 0\n\n"
    counting += "    def setup(self, problem):\n        self.setups += 1"
    project.write("failing.py", PLANNER.replace("np.array([self.parameters.push, 0.0])", counting))
    run = project.runs()[-1]
    result = lpb_report(tmp_path_factory.mktemp("elsewhere"), run, "--retime", "5")
    assert result.returncode == EXIT_WARNINGS
    assert "a::tuned pass 4: ZeroDivisionError: division by zero" in result.stderr
    assert [entry["name"] for entry in benchmarks(run / "retimed.json")] == ["pd"]
    result = lpb_report(tmp_path_factory.mktemp("elsewhere"), run, "--retime", "5", "--planners=tuned")
    assert result.returncode == EXIT_USAGE
    assert "--retime: nothing could be timed" in result.stderr
    assert "ZeroDivisionError" in result.stderr


def test_code_in_the_run_folder_is_never_loaded(project: Project, tmp_path_factory: pytest.TempPathFactory) -> None:
    project.ini()
    project.write("mine.py", PLANNER)
    project.write("planners/tuned.yaml", "planner: mine:Mine\n")
    project.scenario(content=DRAWN)
    project.run("scenarios", planners="tuned").assert_outcomes(passed=1)
    run = project.runs()[-1]
    (project.path / "mine.py").rename(run / "mine.py")
    info = read_run(run)
    info |= {"rootdir": str(run), "invocation": str(run)}
    info["planners"]["tuned"]["source"]["file"] = str(run / "mine.py")
    (run / "run.json").write_text(json.dumps(info), encoding="utf-8")
    result = lpb_report(tmp_path_factory.mktemp("elsewhere"), run, "--retime")
    assert result.returncode == EXIT_USAGE
    assert "cannot import 'mine'" in result.stderr
