"""Collecting many trials, and evaluating and reporting a large run, each in a process of its own."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from pytest_benchmark.fixture import BenchmarkFixture

from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.files import write_trial
from pytest_lpb.trial.trial import run_trial

from .test_trials import specification

SCENARIO = {
    "version": 1,
    "robot": {"model": "point", "body_radius": 0.2},
    "goal": [{"name": "reach", "type": "position", "link": "body", "target": [4.0, 0.2], "tolerance": 0.1}],
    "randomize": {"draw": ["goal"], "goal": [[1, 4], [-2, 2]]},
}
COLLECTED = 10_000
TRIALS = 1_000

# Runs a command and prints its seconds, those of processors, and the largest memory of any process in it [MiB].
MEASURE = """
import json, resource, subprocess, sys, time
started = time.perf_counter()
result = subprocess.run(sys.argv[1:], capture_output=True, text=True)
seconds = time.perf_counter() - started
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps({"s": seconds, "cpu_s": used.ru_utime + used.ru_stime, "peak_mib": used.ru_maxrss / 1024,
    "code": result.returncode, "end": result.stdout[-300:] + result.stderr[-2000:]}))
"""

# Evaluates the run folder of its argument: tables and report.
EVALUATE = """
import json, sys, time
from pathlib import Path
from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.report.build import write_results
from pytest_lpb.run.evaluation import evaluate
from pytest_lpb.run.folder import RunFolder
load_builtin()
run = RunFolder.open(Path(sys.argv[1]))
started = time.perf_counter()
evaluation = evaluate(run)
evaluated = time.perf_counter()
write_results(evaluation, run.path)
print(json.dumps({"trials": len(evaluation.trials), "evaluate_s": evaluated - started,
                  "report_s": time.perf_counter() - evaluated}))
"""


def measured(*command: str, cwd: Path) -> dict[str, Any]:
    result = subprocess.run(
        [sys.executable, "-c", MEASURE, *command], cwd=cwd, capture_output=True, text=True, check=True
    )
    figures: dict[str, Any] = json.loads(result.stdout)
    assert figures["code"] == 0, figures["end"]
    return figures


def test_collecting_10_000_trials(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    (tmp_path / "scenarios").mkdir()
    for index in range(10):
        content = {**SCENARIO, "trials": COLLECTED // 10}
        (tmp_path / "scenarios" / f"family{index}.yaml").write_text(json.dumps(content), encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "--lpb-planners=pd", "-p", "no:cacheprovider"]
    figures = benchmark.pedantic(measured, args=command, kwargs={"cwd": tmp_path}, rounds=1)  # type: ignore[no-untyped-call]
    benchmark.extra_info.update(s=round(figures["s"], 2), peak_mib=round(figures["peak_mib"]))
    assert f"{COLLECTED} tests collected" in figures["end"]


def make_run(tmp_path: Path, count: int) -> Path:
    """A run folder of `count` trials of 500 steps: one trial of each of two planners, copied under new seeds."""
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "scenarios" / "family.yaml").write_text(json.dumps({**SCENARIO, "trials": 1}), encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "--lpb-planners=pd,potential_field", "--lpb-assert=none"]
    subprocess.run([*command, "-p", "no:cacheprovider"], cwd=tmp_path, check=True, capture_output=True)
    run = (tmp_path / "reports" / "latest").resolve()
    for planner in ("pd", "potential_field"):
        made = replace(specification(), planner=PlannerConfiguration(planner, planner), scenario="family")
        trial = run_trial(made)
        for seed in range(1, count // 2):
            node_id = f"scenarios/family.yaml::{planner}::seed{seed}"
            changes = {"seed": seed, "node_id": node_id, "problem_hash": f"{seed:064x}"}
            write_trial(run, Trajectory(trial.columns, {**trial.metadata, **changes}, trial.problem))
    return run


def test_evaluation_and_report_of_1_000_trials(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    run = make_run(tmp_path, TRIALS)
    command = [sys.executable, "-c", EVALUATE, str(run)]
    figures = benchmark.pedantic(measured, args=command, kwargs={"cwd": tmp_path}, rounds=1)  # type: ignore[no-untyped-call]
    inside = json.loads(str(figures["end"]).strip().splitlines()[-1])
    assert inside["trials"] == TRIALS
    benchmark.extra_info.update(
        s=round(figures["s"], 1),
        evaluate_s=round(inside["evaluate_s"], 1),
        report_s=round(inside["report_s"], 1),
        peak_mib=round(figures["peak_mib"]),
        report_bytes=(run / "report.html").stat().st_size,
    )
