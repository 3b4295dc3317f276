"""Planner files with `isolate`, limits, `python`: alone and with workers."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from .projects import DRAWN, Project, read_run, text_of
from .test_faults import leads_to
from .test_interrupt import PATIENCE_S

# Seed 1 crashes, seed 2 hangs; all others are sound.
PLANNER = """\
import ctypes
import time

import numpy as np

from pytest_lpb import Planner


class Mine(Planner):
    def setup(self, problem):
        self.seed = problem.seed

    def compute_action(self, observation):
        if observation["t"] > 0.1 and self.seed in HARMFUL:
            print("seed", self.seed, "goes wrong")
            ctypes.string_at(0) if self.seed == 1 else time.sleep(60.0)
        return observation["goal_position"] - observation["q"] - 2.0 * observation["u"]


HARMFUL = ()


class Harmful(Mine):
    def compute_action(self, observation):
        global HARMFUL
        HARMFUL = (1, 2)
        return super().compute_action(observation)
"""


@pytest.fixture
def planners(project: Project) -> Project:
    project.write("mine.py", PLANNER)
    project.write("planners/sound.yaml", "planner: mine:Mine\n")
    project.write("planners/harmful.yaml", "planner: mine:Harmful\nisolate: true\ndeadline_s: 1.0\n")
    project.scenario(content=DRAWN)
    return project


@pytest.mark.parametrize("workers", [0, 2])
def test_one_fault_is_one_row_and_its_neighbours_are_the_same(planners: Project, workers: int) -> None:
    result = planners.run_workers("--lpb-trials=4", planners="sound,harmful", workers=workers)
    rows = {(row["planner"], int(row["seed"])): row for row in planners.rows()}
    assert len(rows) == 8
    outcomes = [rows["harmful", seed]["outcome"] for seed in range(4)]
    assert outcomes == [rows["sound", 0]["outcome"], "planner_error", "deadline", rows["sound", 3]["outcome"]]
    for seed in (0, 3):
        assert rows["harmful", seed]["trajectory_hash"] == rows["sound", seed]["trajectory_hash"]
    text = text_of(result)
    assert "planner_error: the planner's process was ended by SIGSEGV (signal 11)" in text
    assert "its last words: seed 1 goes wrong" in text
    assert "deadline: compute_action took longer than deadline_s = 1 s" in text
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    about = read_run(planners.runs()[-1])["planners"]["harmful"]
    assert about["isolation"] == {"isolate": True, "deadline_s": 1.0}


@pytest.mark.parametrize("workers", [0, 2])
def test_a_planner_of_another_interpreter(planners: Project, workers: int) -> None:
    """This one, by its path: what differs is that nothing is imported here."""
    planners.write("planners/far.yaml", f"planner: mine:Mine\npython: {sys.executable}\n")
    result = planners.run_workers("--lpb-trials=2", planners="sound,far", workers=workers)
    assert result.ret in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
    rows = {(row["planner"], int(row["seed"])): row for row in planners.rows()}
    for seed in range(2):
        assert rows["far", seed]["trajectory_hash"] == rows["sound", seed]["trajectory_hash"]
    assert read_run(planners.runs()[-1])["planners"]["far"]["runs"]["python"].startswith("3.")


@pytest.mark.parametrize("workers", [0, 2])
def test_what_is_not_there_is_a_usage_error(planners: Project, workers: int) -> None:
    planners.write("planners/far.yaml", "planner: mine:Mine\npython: ../no/python\n")
    result = planners.run_workers(planners="far", workers=workers)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert "no/python is no program that can be run" in text_of(result)


HANGING = """\
import time
from pathlib import Path

from pytest_lpb import Planner


class Hanging(Planner):
    def compute_action(self, observation):
        Path("class-hangs").touch()
        time.sleep(600)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize("workers", [0, 2])
def test_what_hangs_ends_with_a_killed_run(project: Project, workers: int) -> None:
    """A class and a program, neither of which looks whether anybody is there."""
    project.write("hanging.py", HANGING)
    project.write("planners/class.yaml", "planner: hanging:Hanging\nisolate: true\n")
    program = project.write("program.sh", "#!/bin/sh\ntouch program-hangs\nsleep 600\ntrue\n")
    program.chmod(0o755)
    project.write("planners/program.yaml", "command: ../program.sh\n")
    project.scenario(content=DRAWN)
    planners = ["class", "program"][: max(1, workers)]
    process = project.start("-n", str(workers), "scenarios", planners=",".join(planners))
    try:
        wait_until(lambda: all((project.path / f"{name}-hangs").exists() for name in planners))
        assert processes_in(project.path) > workers + 1
    finally:
        process.kill()
        process.wait()
    wait_until(lambda: not processes_in(project.path))


def wait_until(told: Callable[[], bool]) -> None:
    until = time.monotonic() + PATIENCE_S
    while not told():
        assert time.monotonic() < until
        time.sleep(0.05)


def processes_in(folder: Path) -> int:
    """How many processes have a folder for their current one."""
    return sum(leads_to(link, folder) for link in Path("/proc").glob("[0-9]*/cwd")) - leads_to(
        Path("/proc/self/cwd"), folder
    )
