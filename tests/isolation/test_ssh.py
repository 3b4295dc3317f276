"""Trials of planners on another host, which is this one: over a real ssh, to a server of the test's own."""

from __future__ import annotations

import sys
import time
import venv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.settings import isolation_of
from pytest_lpb.planner.configuration import PlannerConfiguration

from .ssh_server import client_config, ssh_server
from .test_faults import ROOT, ends_with_its_parent, has_ended
from .trials import HOSTILE, here, isolated, pair

SOUND: dict[str, Any] = {"fault": "none"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of a server that runs."""
    path = tmp_path_factory.mktemp("ssh")
    with ssh_server(path):
        yield path


def at(folder: Path, host: str = "cell", python: str = sys.executable, **keys: Any) -> dict[str, Any]:
    """Keys of a planner file for a planner that is there."""
    return {"ssh": f"-F {client_config(folder)} {host}", "python": python, "working_dir": str(ROOT), **keys}


@pytest.fixture(scope="module")
def reference() -> str:
    """Hash of the sound planner's trial in this process."""
    return str(here(HOSTILE, SOUND).metadata["trajectory_hash"])


def test_the_same_trial_over_ssh(folder: Path, reference: str) -> None:
    """Of a planner that prints megabytes, too."""
    trajectory = isolated(HOSTILE, {"fault": "prints"}, **at(folder))
    assert trajectory.metadata["trajectory_hash"] == reference, trajectory.metadata["message"]
    assert (trajectory.columns["planner_round_trip_ms"][:-1] > 0.0).all()


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("segfaults", "the planner's process was ended by a signal, or the connection was lost; its last words: about"),
        ("leaves_a_child", "the planner's process ended with exit code 5; its last words: child"),
    ],
)
def test_the_end_of_its_process_is_one_trials_planner_error(folder: Path, fault: str, message: str) -> None:
    broken = isolated(HOSTILE, {"fault": fault}, deadline_s=20.0, **at(folder))
    assert message in broken.metadata["message"]
    assert broken.outcome == "planner_error"
    assert len(broken.t) == 7  # what it did before is kept
    if fault == "leaves_a_child":
        assert has_ended(int(broken.metadata["message"].rpartition(" ")[2]))


def test_a_deadline_ends_it_there(folder: Path, reference: str) -> None:
    broken, after = pair({"fault": "spins_in_c"}, SOUND, deadline_s=0.5, **at(folder))
    assert broken.outcome == "deadline"
    assert has_ended(int(broken.planner("pid")[0]))
    assert after.metadata["trajectory_hash"] == reference


def test_too_much_memory_there(folder: Path) -> None:
    trajectory = isolated(HOSTILE, {"fault": "fills", "megabytes": 3000}, memory_mb=1500, **at(folder))
    assert trajectory.outcome == "planner_error"
    assert "(memory_mb: 1500)" in trajectory.metadata["message"]


def test_it_ends_with_whoever_started_it(folder: Path) -> None:
    """Even killed, and even while the planner there is busy in C."""
    assert ends_with_its_parent({"fault": "spins_in_c"}, at(folder))


@pytest.fixture(scope="module")
def without_numpy(tmp_path_factory: pytest.TempPathFactory) -> str:
    """An interpreter that has nothing."""
    path = tmp_path_factory.mktemp("empty")
    venv.create(path / "venv", symlinks=True)
    return str(path / "venv" / "bin" / "python")


@pytest.mark.parametrize(
    ("host", "python", "message"),
    [
        ("closed", "python3", r"closed: cannot be reached by ssh \(.*Connection refused\)"),
        ("stranger", "python3", r"stranger: cannot be reached by ssh \(.*Permission denied \(publickey.*\)"),
        ("impostor", "python3", r"impostor: cannot be reached by ssh \(Host key verification failed.\)"),
        ("cell", "python9", r"cell: has no python9 that can be run \(.*No such file.*\); name another with `python`"),
        ("cell", "false", r"false at .*cell did not start as a Python interpreter \(exit code 1\)"),
        ("cell", "echo", r"cell: did not start as a Python interpreter: it printed .* in place of a version; what"),
        ("cell", "without_numpy", r"cell: has no NumPy, which is needed there \(missing: No module named"),
    ],
)
def test_what_cannot_be_had_is_told_within_seconds(
    folder: Path, request: pytest.FixtureRequest, host: str, python: str, message: str
) -> None:
    if python == "without_numpy":
        python = request.getfixturevalue(python)
    isolation = isolation_of(at(folder, host, python), Path.cwd())
    started = time.monotonic()
    with pytest.raises(ConfigurationError, match=message):
        PlannerConfiguration("it", HOSTILE, isolation=isolation).check()
    assert time.monotonic() - started < 10.0
