"""Crashes that a run survives, as the table in docs/crashes.md lists them, and a project to provoke them in."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from pytest_lpb.trial.files import read_trial

from .projects import DRAWN, Project, hashes_of

RESUME = " trials were run; run the others with: pytest --lpb-resume="
# What the user sees of each, in part; `TESTS` names what provokes it.
CRASHES: dict[str, tuple[str, ...]] = {
    "killed_worker": ("worker_crash: the process that ran the trial died",),
    "killed_controller": (RESUME,),
    "interrupt_in_collection": ("no tests ran",),
    "interrupt_in_a_trial": (RESUME,),
    "interrupt_at_the_end": ("interrupted before tables and report were done; make them with: lpb-report",),
    "full_disk": (
        "No space left on device; free space there, then finish the run with: pytest --lpb-resume=",
        "trials cannot be recorded any more",
        RESUME,
    ),
    "full_disk_at_the_start": ("No space left on device; free space there",),
    "file_too_large": ("File too large", RESUME),
    "read_only_reports": ("cannot write to", "choose another with --lpb-reports=DIR"),
    "read_only_run": ("run.json: Read-only file system",),
    "damaged_trial": ("cannot read", "delete it, and --lpb-resume runs its trial again"),
    "two_runs_at_once": ("report: reports/",),
    "two_that_finish_one_run": ("is being run by another process: wait until that has ended",),
}
# Tests in this folder that say with `expect` that the user sees that.
TESTS = {name: f"test_crash_safety.test_{name}" for name in CRASHES} | {
    "interrupt_in_a_trial": "test_interrupt.test_finished_trials_are_kept",
    "read_only_run": "test_crash_safety.test_full_disk_at_the_start",
    "two_that_finish_one_run": "test_crash_safety.test_killed_controller",
}

# Each trial says that it runs. The third goes no further while there is a file `hold`; in a run that begins while
# there is a file `full`, its raw data find no space.
CONFTEST = """
import errno, os, pathlib, resource, time
import pytest
import pytest_lpb.documents.atomic
from pytest_lpb import Planner, kpi

def wait_while(name):
    # Not for ever: a test that fails is to end.
    end = time.monotonic() + 60.0
    while os.path.exists(name) and time.monotonic() < end:
        time.sleep(0.01)

class Held(Planner):
    name = "held"

    def setup(self, problem):
        self.seed = problem.seed

    def compute_action(self, observation):
        with open(f"in_trial{self.seed}", "w") as file:
            file.write(str(os.getpid()))
        if self.seed == 2:
            wait_while("hold")
        return observation["goal_position"] - observation["q"] - observation["u"]

@kpi(name="held_kpi", unit="s", direction="higher", over="all")
def held_kpi(trajectory):
    open("in_kpi", "w").close()
    wait_while("hold_kpi")
    return 1.0

def pytest_collection(session):
    open("in_collection", "w").close()
    wait_while("hold_collection")

class FullFile:
    def __init__(self, file):
        self.file = file

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.file.close()

    def write(self, content):
        self.file.write(content[:100])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

class Disk(type(pathlib.Path())):
    def open(self, mode="r", *arguments, **keywords):
        file = super().open(mode, *arguments, **keywords)
        return FullFile(file) if "seed2.parquet" in self.name else file

unfinished = pytest_lpb.documents.atomic.unfinished

def pytest_sessionstart(session):
    if os.path.exists("full"):
        pytest_lpb.documents.atomic.unfinished = lambda path: Disk(unfinished(path))
    if os.path.exists("small_files"):
        resource.setrlimit(resource.RLIMIT_FSIZE, (15_000, 15_000))

def pytest_unconfigure():
    pytest_lpb.documents.atomic.unfinished = unfinished
"""
PATIENCE_S = 60.0
TRIALS = 4


class CrashProject:
    """A repository with four different trials, the third of which can be held."""

    def __init__(self, project: Project) -> None:
        self.project = project
        self.path = project.path
        project.write("conftest.py", CONFTEST)
        project.scenario(content=DRAWN)

    def start(self, workers: int, *arguments: str, planners: str | None = "held") -> subprocess.Popen[bytes]:
        """Start a run of the four trials."""
        own = [] if planners is None else [f"--lpb-trials={TRIALS}", "--lpb-assert=none", "scenarios"]
        return self.project.start(*(["-n", str(workers)] if workers else []), *own, *arguments, planners=planners)

    def mark(self, name: str) -> None:
        """Make a file that holds something."""
        self.project.write(name, "")

    def unmark(self, name: str) -> None:
        """Let it go on."""
        (self.path / name).unlink()

    def wait_for(self, condition: Callable[[], object], process: subprocess.Popen[bytes] | None = None) -> None:
        """Wait until something is so, while a run goes on."""
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            assert process is None or process.poll() is None, self.output()
            assert time.monotonic() < deadline
            time.sleep(0.01)

    def is_there(self, name: str) -> Callable[[], bool]:
        """Whether a file is there, and has content or needs none."""
        return lambda: (self.path / name).exists() and (not name.startswith("in_trial") or self.pid(name) > 0)

    def pid(self, name: str) -> int:
        """The process that said that it is in a trial; 0: none yet."""
        return int((self.path / name).read_text() or 0)

    def recorded(self, *seeds: int) -> Callable[[], bool]:
        """Whether the trials of these seeds are recorded."""
        return lambda: all(list(self.path.glob(f"reports/2*/trials/point/x/held/seed{seed}.parquet")) for seed in seeds)

    def output(self) -> str:
        """What the last run that was started has printed."""
        return self.project.output.read_text()

    def run(self) -> Path:
        """The only run folder."""
        (run,) = self.project.runs()
        return run

    def resume(self, workers: int = 0) -> str:
        """Finish the run in this process; what was printed. Afterwards it is as if nothing had happened."""
        arguments = ("-n", str(workers)) if workers else ()
        result = self.project.run(f"--lpb-resume={self.run()}", *arguments, planners=None)
        output = f"{result.stdout.str()}\n{result.stderr.str()}"
        assert result.ret == 0, output
        return output


def check_kept(run: Path, count: int) -> None:
    """Each trial that is there can be read."""
    files = sorted((run / "trials").rglob("seed*.parquet"))
    assert len(files) == count, files
    for file in files:
        assert len(read_trial(file)) > 1


def check_finished(run: Path, undisturbed: Mapping[tuple[str, str, str], str]) -> None:
    """A run is whole, as an undisturbed one, and nothing unfinished lies in it."""
    assert hashes_of(run) == undisturbed
    check_kept(run, len(undisturbed))
    assert not list(run.rglob(".*"))
    assert not (run / "missing.csv").exists()
    assert (run / "report.html").is_file()


def end(process: subprocess.Popen[bytes]) -> None:
    """Whatever a test has started is gone when it ends."""
    if process.poll() is None:
        os.killpg(process.pid, 9)
        process.wait()


def expect(name: str, output: str) -> None:
    """The user sees what the table says, and no traceback."""
    for text in CRASHES[name]:
        assert text in output, output
    assert "Traceback" not in output
    assert "INTERNALERROR" not in output
