"""PyBullet's window, on a display without a screen."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest
from PIL import ImageGrab, features

from pytest_lpb.environment import picture as picture_module
from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.picture import RealTime, picture_for
from pytest_lpb.environment.spatial_window import SpatialWindow
from pytest_lpb.errors import LpbError
from pytest_lpb.problem.problem import Problem
from tests.environment.displays import virtual_display
from tests.problem.spatial.entries import point_entry, problem_of

Server = subprocess.Popen[bytes]
PATIENCE_S = 60.0  # [s]


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    """An X server whose display is this process's."""
    with virtual_display() as (name, process):
        monkeypatch.setenv("DISPLAY", name)
        yield process


@pytest.fixture
def problem(tmp_path: Path) -> Problem:
    """A ball, a goal and an obstacle."""
    goal = {"name": "reach", "type": "position", "link": "body", "target": [1.0, 0.0, 0.5], "tolerance": 0.2}
    turn = {"name": "turn", "type": "orientation", "link": "body", "target": [1, 0, 0, 0]}
    box = {"name": "box", "shape": "box", "size": [0.4, 0.4, 0.4], "position": [0.5, 1.0, 0.2]}
    return problem_of(tmp_path, point_entry(0.3, [box], goal=[goal, turn]))


def robot_column(other_than: float | None = None) -> float:
    """Where the blue robot is seen on the display [px], once that is somewhere else: windows draw when they like."""
    deadline = monotonic() + PATIENCE_S
    while monotonic() < deadline:
        red, green, blue = np.moveaxis(np.asarray(ImageGrab.grab()).astype(int), -1, 0)
        columns = np.nonzero((blue > green + 30) & (green > red + 30))[1]
        if len(columns) > 300 and (other_than is None or abs(columns.mean() - other_than) > 5.0):
            return float(columns.mean())
        sleep(0.05)
    raise AssertionError(f"no robot is seen that has moved from {other_than}")


@pytest.mark.usefixtures("server")
def test_the_window_shows_the_robot_as_it_moves(problem: Problem) -> None:
    if not features.check("xcb"):
        pytest.skip("Pillow cannot look at this display")
    environment = ScenarioEnvironment(problem=problem, render_mode="human")
    environment.reset()
    assert environment.render() is None
    before = robot_column()
    for _ in range(60):
        environment.step(np.array([9.0, 0.0, 0.0]))
    robot_column(other_than=before)
    environment.close()


def test_a_window_that_is_closed_does_not_end_the_trial(server: Server, problem: Problem) -> None:
    """Closing PyBullet's window, which has no close protocol, breaks its connection to the X server: as here."""
    environment = ScenarioEnvironment(problem=problem, render_mode="human")
    environment.reset()
    environment.step(np.zeros(3))
    server.kill()
    server.wait()
    for _ in range(30):
        environment.step(np.array([1.0, 0.0, 0.0]))
    assert environment.row == 31
    assert environment.running_engine.q[0] > 0
    environment.close()
    environment.close()


def test_no_display(monkeypatch: pytest.MonkeyPatch, problem: Problem) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    environment = ScenarioEnvironment(problem=problem, render_mode="human")
    with pytest.raises(LpbError, match=r"needs a display, and there is none \(DISPLAY is not set\).*--video out.mp4"):
        environment.reset()
    environment.close()


def test_a_display_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":987")
    with pytest.raises(LpbError, match=r"cannot open PyBullet's window: .*cannot connect to X server"):
        picture_for(3, show=True)


@pytest.mark.usefixtures("server")
def test_faults_in_the_windows_process_are_told(problem: Problem) -> None:
    window = SpatialWindow()
    window.load(problem)
    with pytest.raises(LpbError, match=r"PyBullet's window failed: .*"):
        window.show(0.0, [0.0])
    assert not window.open
    window.close()


def test_real_time(monkeypatch: pytest.MonkeyPatch) -> None:
    now, slept = [100.0], []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        now[0] += seconds

    monkeypatch.setattr(picture_module, "sleep", sleep)
    monkeypatch.setattr(picture_module, "perf_counter", lambda: now[0])
    time = RealTime()
    time.restart(2.0)
    now[0] += 0.3
    time.wait_for(3.0)
    assert slept == pytest.approx([0.7])
    now[0] += 5.0
    time.wait_for(4.0)  # late: nothing to wait for
    time.wait_for(4.5)
    assert slept == pytest.approx([0.7, 0.5])


def test_problems_can_be_told_as_json(problem: Problem) -> None:
    assert Problem.from_dict(json.loads(json.dumps(problem.to_dict()))).problem_hash == problem.problem_hash
