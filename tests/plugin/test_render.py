"""`--lpb-render`: trials in a window."""

from __future__ import annotations

import pytest

from tests.environment.displays import virtual_display

from .projects import Project

IN_SPACE = """\
version: 1
robot: {model: point_3d, body_radius: 0.2}
environment: {engine: pybullet, dt: 0.05, duration: 0.5}
start: {q: [0, 0, 0]}
goal:
  - {name: reach, type: position, link: body, target: [0.05, 0.0, 0.0], tolerance: 0.1}
success: {hold_time: 0.2}
"""


def test_a_window_needs_a_display(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    project.scenario()
    result = project.run("--lpb-render", "scenarios")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*--lpb-render (render_mode 'human') needs a display, and there is none*"])
    assert not project.runs()


def test_a_trial_in_a_window_is_the_same_trial(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    project.scenario("scenarios/space/x.yaml", IN_SPACE)
    hashes = []
    with virtual_display() as (name, _):
        monkeypatch.setenv("DISPLAY", name)
        for option in ([], ["--lpb-render"]):
            project.run(*option, "scenarios").assert_outcomes(passed=1)
            hashes.append(project.row()["trajectory_hash"])
    assert hashes[0] == hashes[1]
