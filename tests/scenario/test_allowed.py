"""Scenario files name files of their own project only."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pytest_lpb.errors import ScenarioError
from pytest_lpb.scenario.allowed import project_of
from pytest_lpb.scenario.load import load_scenario

SCENARIO = """\
version: 1
robot: {model: point, body_radius: 0.2}
goal: [{name: reach, type: position, link: body, target: [1.0, 0.0], tolerance: 0.1}]
certified: {path: PATH, clearance_m: 0.1, by: hand}
"""
SPATIAL = """\
version: 1
robot: {urdf: PATH}
environment: {engine: pybullet}
goal: [{name: reach, type: joint, target: [0.0], tolerance: 0.1}]
"""
OUTSIDE = r"x\.yaml:2: robot\.urdf: .*secret\.urdf lies outside of .*; a scenario names files of its own project"


def project(tmp_path: Path, path: str) -> Path:
    """A project in a folder beside a file that is nobody's business."""
    (tmp_path / "secret.urdf").write_text("<robot name='s'><link name='base'/></robot>")
    scenario = tmp_path / "mine/scenarios/arm/x.yaml"
    scenario.parent.mkdir(parents=True)
    (tmp_path / "mine/pytest.ini").write_text("[pytest]\n")
    scenario.write_text(SPATIAL.replace("PATH", path))
    return scenario


@pytest.mark.parametrize("kind", ["relative", "absolute", "by a link"])
def test_files_outside_are_refused_unread(tmp_path: Path, kind: str) -> None:
    path = {"relative": "../../../secret.urdf", "absolute": str(tmp_path / "secret.urdf"), "by a link": "link.urdf"}[
        kind
    ]
    scenario = project(tmp_path, path)
    if kind == "by a link":
        (scenario.parent / "link.urdf").symlink_to(tmp_path / "secret.urdf")
    with pytest.raises(ScenarioError, match=OUTSIDE if kind != "by a link" else r"link\.urdf lies outside"):
        load_scenario(scenario)


def test_folders_can_be_allowed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = project(tmp_path, "../../../secret.urdf")
    monkeypatch.setenv("LPB_ALLOW_PATHS", os.pathsep.join(["/nowhere", str(tmp_path)]))
    with pytest.raises(ScenarioError) as refused:
        load_scenario(scenario)
    assert "outside" not in str(refused.value)  # read now: it has no joint


def test_files_of_the_project_are_allowed(tmp_path: Path) -> None:
    scenario = project(tmp_path, "../../robots/missing.urdf")
    with pytest.raises(ScenarioError, match=r"robots/missing\.urdf") as refused:
        load_scenario(scenario)
    assert "outside" not in str(refused.value)


@pytest.mark.parametrize(
    ("mark", "expected"),
    [("pytest.ini", "a"), ("a/b/run.json", "a/b"), (None, "a/b/c"), ("a/b/c/d/conftest.py", "a/b/c/d")],
)
def test_project(tmp_path: Path, mark: str | None, expected: str) -> None:
    (tmp_path / "a/b/c/d").mkdir(parents=True)
    if mark is not None:
        file = tmp_path / ("a" if mark == "pytest.ini" else ".") / mark
        file.write_text("")
    assert project_of(tmp_path / "a/b/c/d/x.yaml") == (tmp_path / expected).resolve()


def test_every_place_of_a_path(tmp_path: Path) -> None:
    scenario = tmp_path / "a/b/x.yaml"
    scenario.parent.mkdir(parents=True)
    obstacle = "\nobstacles: [{name: m, shape: mesh, file: /etc/hostname, position: [1, 1]}]\n"
    scenario.write_text(SCENARIO.replace("PATH", "/etc/passwd") + obstacle)
    with pytest.raises(ScenarioError) as refused:
        load_scenario(scenario)
    text = str(refused.value)
    assert "x.yaml:4: certified.path: /etc/passwd lies outside" in text
    assert "obstacles[0].file: /etc/hostname lies outside" in text
