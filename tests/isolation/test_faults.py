"""What takes a process down ends one trial with a useful message; the next trial has a fresh process."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from .planners import FAULT_AT
from .trials import HOSTILE, here, isolated, pair

ROOT = Path(__file__).parents[2]
SOUND: dict[str, Any] = {"fault": "none"}


@pytest.fixture(scope="module")
def reference() -> str:
    """Hash of the sound planner's trial in this process."""
    return str(here(HOSTILE, SOUND).metadata["trajectory_hash"])


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("segfaults", "was ended by SIGSEGV (signal 11); its last words: about to crash"),
        ("leaves", "ended with exit code 7; its last words: leaving for good"),
    ],
)
def test_the_end_of_its_process_is_one_trials_planner_error(fault: str, message: str, reference: str) -> None:
    broken, after = pair({"fault": fault}, SOUND)
    assert broken.outcome == "planner_error"
    assert broken.metadata["message"] == f"planner error at t = 0.3 s: the planner's process {message}"
    assert len(broken.t) == round(FAULT_AT / 0.05) + 1  # what it did before is kept
    assert after.metadata["trajectory_hash"] == reference
    assert set(after.planner("trials")[:-1]) == {1.0}
    assert after.planner("pid")[0] != broken.planner("pid")[0]


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_what_it_leaves_behind_ends_with_it(reference: str) -> None:
    """A child that keeps all descriptors open, the one for calls too."""
    broken, after = pair({"fault": "leaves_a_child"}, SOUND)
    message, _, child = broken.metadata["message"].rpartition(" ")
    assert message.endswith("the planner's process ended with exit code 5; its last words: child")
    assert after.metadata["trajectory_hash"] == reference
    assert has_ended(int(child))


@pytest.mark.parametrize("fault", ["hangs", "spins_in_c"])
def test_a_call_that_hangs_is_a_deadline(fault: str, reference: str) -> None:
    broken, after = pair({"fault": fault}, SOUND, deadline_s=0.5)
    assert broken.outcome == "deadline"
    assert broken.metadata["message"] == (
        "deadline at t = 0.3 s: compute_action took longer than deadline_s = 0.5 s; the planner's process was ended"
    )
    assert broken.solver_wall_ms[6] >= 500.0
    assert after.metadata["trajectory_hash"] == reference
    with pytest.raises(ProcessLookupError):
        _signal_nothing(int(broken.planner("pid")[0]))


def test_a_setup_that_hangs_is_a_deadline(reference: str) -> None:
    started = time.monotonic()
    broken, after = pair({"fault": "hangs", "in_setup": True}, SOUND, setup_deadline_s=3.0)
    assert broken.outcome == "deadline"
    assert "start and setup took longer than setup_deadline_s = 3 s" in broken.metadata["message"]
    assert len(broken.t) == 1
    assert after.metadata["trajectory_hash"] == reference
    assert time.monotonic() - started < 50.0  # the planner would sleep for a minute


def test_too_much_memory_is_a_planner_error(reference: str) -> None:
    broken, after = pair({"fault": "fills", "megabytes": 3000}, SOUND, memory_mb=1500)
    assert broken.outcome == "planner_error"
    assert "MemoryError" in broken.metadata["message"]
    assert "(memory_mb: 1500)" in broken.metadata["message"]
    assert after.metadata["trajectory_hash"] == reference
    fits = isolated(HOSTILE, {"fault": "fills", "megabytes": 100}, memory_mb=1500)
    assert fits.metadata["trajectory_hash"] == reference


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_too_little_memory_is_told_each_time() -> None:
    """Of a process that could not begin nothing is expected any more."""
    for trajectory in pair(SOUND, SOUND, memory_mb=30):
        message = trajectory.metadata["message"]
        assert message.startswith(
            "planner error at t = 0 s: memory_mb: found 30; an interpreter with NumPy alone takes "
        )
        assert trajectory.metadata["details"] == ""


@pytest.mark.parametrize("fault", ["prints", "forks"])
def test_what_does_no_harm(fault: str, reference: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert isolated(HOSTILE, {"fault": fault}).metadata["trajectory_hash"] == reference
    assert capfd.readouterr() == ("", "")


def test_nobody_answers_a_planner_that_asks() -> None:
    trajectory = isolated(HOSTILE, {"fault": "asks"}, deadline_s=5.0)
    assert trajectory.outcome == "planner_error"
    assert "EOFError" in trajectory.metadata["message"]


def test_a_constructor_that_raises() -> None:
    trajectory = isolated("tests.isolation.planners:BadStart")
    assert trajectory.outcome == "planner_error"
    assert trajectory.metadata["message"].startswith("planner error at t = 0 s: OSError: library missing (")
    lines = trajectory.metadata["details"].splitlines()
    assert lines[0].startswith("Traceback")
    assert "planners.py" in lines[1]  # none of the far side's


@pytest.mark.skipif(sys.platform != "linux", reason="prctl is Linux's")
def test_it_ends_with_whoever_started_it() -> None:
    """Even killed, and even while the planner's process is busy in C."""
    assert ends_with_its_parent({"fault": "spins_in_c"}, {})


def ends_with_its_parent(parameters: dict[str, Any], keys: dict[str, Any]) -> bool:
    """Whether the planner's process ends when the one that called it is killed, in the middle of a call."""
    program = (
        "from tests.isolation.planners import Hostile\n"
        "from tests.isolation.trials import *\n"
        "from pytest_lpb.planner.base import PlannerProblem\n"
        "from pytest_lpb.problem.problem import Problem\n"
        f"made = specification(HOSTILE, {parameters!r}, {keys!r})\n"
        "planner = made.planner.build()\n"
        "planner.setup(PlannerProblem.of(Problem.from_dict(made.problem, 'x'), 0.05))\n"
        "import numpy as np\n"
        "planner.compute_action({'t': np.zeros(())})\n"
        "print(int(planner.diagnostics['pid']), flush=True)\n"
        "planner.compute_action({'t': np.ones(())})\n"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, cwd=ROOT, text=True) as process:
        assert process.stdout is not None
        pid = int(process.stdout.readline())
        _signal_nothing(pid)
        process.kill()
    return has_ended(pid)


def has_ended(pid: int) -> bool:
    """Whether a process ends within some seconds; nobody may have asked yet how it did."""
    for _ in range(100):
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except FileNotFoundError:
            return True
        if state == "Z":
            return True
        time.sleep(0.1)
    return False


def _signal_nothing(pid: int) -> None:
    import os

    assert np.isfinite(pid)
    os.kill(pid, 0)
