"""Ctrl-C and SIGTERM: finished trials stay, with tables and report."""

from __future__ import annotations

import os
import signal
import subprocess
import time

import pytest

from pytest_lpb.cli import main
from pytest_lpb.trial.files import read_trial

from .crashes import expect
from .projects import UNSOLVED, Project, read_run, trial_files

SLOW = """
import signal
import time
import numpy as np
from pytest_lpb import Planner

class Slow(Planner):
    name = "slow"

    def setup(self, problem):
        self.pause = 0.02 if problem.seed < 3 else 0.1

    def compute_action(self, observation):
        time.sleep(self.pause)
        return np.zeros(2)
"""
PATIENCE_S = 60.0


@pytest.mark.parametrize(
    ("number", "workers"),
    [(signal.SIGINT, 0), (signal.SIGTERM, 0), (signal.SIGINT, 2), (signal.SIGTERM, 2)],
    ids=["Ctrl-C", "SIGTERM", "Ctrl-C with workers", "SIGTERM with workers"],
)
def test_finished_trials_are_kept(project: Project, number: signal.Signals, workers: int) -> None:
    project.write("conftest.py", SLOW)
    project.scenario(content=UNSOLVED)
    arguments = ["-n", str(workers)] if workers else []
    process = project.start(*arguments, "--lpb-trials=40", "--lpb-assert=none", "scenarios", planners="slow")
    try:
        wait_for_trials(project, process, 3)
        # A terminal sends Ctrl-C to all processes of the run; `kill` and schedulers address the first.
        (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
        process.wait(timeout=PATIENCE_S)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    output = project.output.read_text()
    assert process.returncode == 2, output
    (run,) = project.runs()
    assert read_run(run)["schema_version"] == 1
    files = trial_files(run)
    assert 3 <= len(files) < 40
    for file in files:
        assert read_trial(run / "trials" / file).metadata["outcome"] == "timeout"
    # Tables hold exactly the finished trials, and rebuilt ones are the same.
    assert len(project.rows()) == len(files)
    assert "local planner benchmark" in output
    expect("interrupt_in_a_trial", output)
    assert f"{len(files)} of 40 trials were run; " in output
    tables = {
        name: (run / name).read_bytes() for name in ("trials.csv", "summary.csv", "comparisons.csv", "aggregates.csv")
    }
    for name in tables:
        (run / name).unlink()
    assert main([str(run)]) == 0
    assert {name: (run / name).read_bytes() for name in tables} == tables


def wait_for_trials(project: Project, process: subprocess.Popen[bytes], count: int) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while len(list(project.path.glob("reports/2*/trials/**/*.parquet"))) < count:
        assert process.poll() is None, project.output.read_text()
        assert time.monotonic() < deadline, project.output.read_text()
        time.sleep(0.02)


def test_an_interrupt_before_the_first_trial_ends(project: Project) -> None:
    project.write("conftest.py", SLOW.replace("time.sleep(self.pause)", "signal.raise_signal(signal.SIGINT)"))
    project.scenario(content=UNSOLVED)
    arguments = project._arguments(("--lpb-trials=2", "scenarios"), "slow", fast=True)
    project.pytester.inline_run(*arguments, no_reraise_ctrlc=True)
    assert project.rows() == []
    (run,) = project.runs()
    assert (run / "report.html").is_file()
    assert main([str(run)]) == 0
