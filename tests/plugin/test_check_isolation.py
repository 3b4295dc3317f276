"""`--lpb-check-isolation`: trials run again alone and in reverse, scenes moved; what planners must not do is told."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pytest_lpb.fairness import check as check_module
from tests.isolation.test_faults import has_ended

from .projects import SCENARIO, Project, text_of

# An obstacle that no trial comes near.
WATCHED = SCENARIO + "obstacles: [{name: far, shape: circle, radius: 0.1, position: [3.0, 0.0]}]\ntrials: 3\n"

PLANNERS = """\
import numpy as np
from pytest_lpb import Planner


class Towards(Planner):
    name = "towards"

    def compute_action(self, observation):
        away = observation["q"] - observation["obstacle_position"][0]
        return observation["goal_position"] - observation["q"] - observation["u"] + 0.001 * away


class Remembering(Towards):
    name = "remembering"
    trials = 0

    def setup(self, problem):
        Remembering.trials += 1

    def compute_action(self, observation):
        return super().compute_action(observation) * (1.0 + 0.001 * Remembering.trials)


class Unseeded(Towards):
    name = "unseeded"

    def setup(self, problem):
        self.noise = np.random.default_rng().uniform(0.0, 0.001, 2)

    def compute_action(self, observation):
        return super().compute_action(observation) + self.noise


class Stale(Towards):
    name = "stale"
    scene = None

    def compute_action(self, observation):
        if self.scene is None:
            self.scene = {key: array.copy() for key, array in observation.items() if key[:4] in ("goal", "obst")}
        return super().compute_action({**observation, **self.scene})


class LeavingWhenAlone(Towards):
    name = "leaving_when_alone"

    def setup(self, problem):
        import os, sys
        if "pytest" not in sys.modules:
            os.write(2, b"the licence server is not there\\n")
            os._exit(3)
"""


@pytest.fixture
def watched(project: Project) -> Project:
    """A project with those planners, registered by its conftest.py, and one scenario with three trials."""
    project.write("conftest.py", PLANNERS)
    project.scenario(content=WATCHED)
    return project


def check(project: Project, *arguments: str, planners: str) -> tuple[pytest.RunResult, str]:
    result = project.run("--lpb-check-isolation", "--lpb-assert=none", *arguments, "scenarios", planners=planners)
    return result, text_of(result)


def report_again(run: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pytest_lpb.cli", str(run)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_what_is_in_order(watched: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    result, text = check(watched, "--lpb-check-trials=2", planners="towards,pd")
    assert result.ret == pytest.ExitCode.OK
    assert (
        "Isolation checked: 4 trials (2 of pd, 2 of towards) run again in processes of their own and in reverse "
        "order came out the same to the last bit." in text
    )
    assert "The first action of pd depends on no obstacle's place in point/x." in text
    assert "warning" not in text
    report = (watched.runs()[-1] / "report.html").read_text("utf-8")
    assert "came out the same to the last bit" in report
    assert list((tmp_path / "temporary").iterdir()) == []


def test_what_planners_must_not_do(watched: Project) -> None:
    """With workers, as studies are run; the report made again still tells it."""
    result, text = check(
        watched,
        *("--lpb-check-trials=2", "-n", "2"),
        planners="remembering,unseeded,stale,leaving_when_alone",
    )
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    run = watched.runs()[-1]
    again = report_again(run)
    assert again.returncode == 1
    for sentence in (
        "these trials came out otherwise when they were run alone or in another order, so they depend on the trials "
        "before them (setup must forget): point/x :: remembering :: seed",
        "these trials come out otherwise each time, even alone (random numbers that are not seeded, the clock, "
        "the order of a set): point/x :: unseeded :: seed1, point/x :: unseeded :: seed2",
        "the first action of stale stays the same wherever goal and obstacles are moved, in point/x: it looks at "
        "neither, or remembers an old scene",
        "point/x :: leaving_when_alone :: seed2 could not be run again: the licence server is not there",
        "point/x :: leaving_when_alone :: seed2, its scene moved, could not be run again",
    ):
        assert sentence in text
        assert sentence in again.stderr
        assert sentence in (run / "report.html").read_text("utf-8")
    assert text.count("warning: ") == 6
    assert "Isolation checked" not in text


def test_a_run_that_was_interrupted_is_not_checked(watched: Project) -> None:
    ending = "\n\ndef pytest_runtest_setup(item):\n    if item.name == 'seed1':\n        raise KeyboardInterrupt\n"
    watched.write("conftest.py", PLANNERS + ending)
    started = watched.start("--lpb-check-isolation", "scenarios", planners="towards")
    assert started.wait() == pytest.ExitCode.INTERRUPTED
    assert "checking isolation" not in watched.output.read_text("utf-8")
    assert not (watched.runs()[-1] / "fairness.json").exists()


def test_nothing_is_checked_unasked(watched: Project) -> None:
    watched.run("scenarios", planners="towards")
    assert not (watched.runs()[-1] / "fairness.json").exists()


def test_a_damaged_file(watched: Project) -> None:
    watched.run("scenarios", planners="towards")
    run = watched.runs()[-1]
    (run / "fairness.json").write_text("{", "utf-8")
    again = report_again(run)
    assert f"cannot read {run / 'fairness.json'}" in again.stderr
    assert "Traceback" not in again.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--lpb-check-trials=2"], "--lpb-check-trials says how many trials --lpb-check-isolation runs again"),
        (["--lpb-check-isolation", "--lpb-check-trials=0"], "--lpb-check-trials: found 0; allowed are 1 and more"),
    ],
)
def test_options(watched: Project, arguments: list[str], message: str) -> None:
    result = watched.run(*arguments, "scenarios", planners="towards")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert message in "\n".join(result.errlines)


HANGING = """

class Hanging(Towards):
    name = "hanging"

    def setup(self, problem):
        import os, pathlib, subprocess, sys, time
        if "pytest" not in sys.modules:
            subprocess.Popen(["sleep", "90"])
            pathlib.Path(__file__).with_name(f"{os.getpid()}.pid").touch()
            time.sleep(SECONDS)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL], ids=lambda number: number.name)
def test_its_processes_end_when_it_is_interrupted(watched: Project, number: signal.Signals) -> None:
    """At once, although what they run hangs; when pytest is killed, too."""
    watched.write("conftest.py", PLANNERS + HANGING.replace("SECONDS", "600"))
    started = watched.start("--lpb-check-isolation", "--lpb-check-trials=3", "scenarios", planners="hanging")
    pids: list[int] = []
    until = time.monotonic() + 60.0
    while not pids:
        assert time.monotonic() < until, watched.output.read_text("utf-8")
        pids = [int(path.stem) for path in watched.path.glob("*.pid")]
        time.sleep(0.05)
    started.send_signal(number)
    code = started.wait(30.0)
    assert all(has_ended(pid) for pid in pids)
    if number == signal.SIGINT:
        assert code == pytest.ExitCode.TESTS_FAILED
        assert "isolation was not checked: interrupted" in watched.output.read_text("utf-8")
        assert len(list(watched.path.glob("*.pid"))) == len(pids)


def test_what_planners_leave_running_is_not_waited_for(watched: Project) -> None:
    watched.write("conftest.py", PLANNERS + HANGING.replace("SECONDS", "0"))
    before = time.monotonic()
    _, text = check(watched, "--lpb-check-trials=1", planners="hanging")
    assert "Isolation checked: 1 trial (1 of hanging)" in text
    assert time.monotonic() - before < 60.0


def test_a_damaged_trial_costs_the_check_only(watched: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    def damaged(*_: object) -> None:
        raise KeyError("trajectory_hash")

    monkeypatch.setattr(check_module, "sample", damaged)
    result, text = check(watched, planners="towards")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert "isolation could not be checked: KeyError: 'trajectory_hash'" in text
    assert (watched.runs()[-1] / "report.html").is_file()
