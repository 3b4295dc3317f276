"""Scenario files name files of their own project only."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.allowed import project_of
from pytest_lpb.problem.spatial.library import library_robot
from pytest_lpb.problem.spatial.urdf_reader import load_urdf
from pytest_lpb.scenario.load import load_scenario
from tests.scenario.urdfs import TETRAHEDRON, write_arm
from tests.scenario.urdfs import mesh as mesh_of

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
OUTSIDE = r"x\.yaml:2: robot\.urdf: .*secret\.urdf lies outside of .*"


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


def with_mesh(tmp_path: Path, mesh: str) -> Path:
    """A scenario whose robot has a mesh, in a project beside a file that is nobody's business."""
    scenario = project(tmp_path, "../../robots/arm.urdf")
    scenario.write_text(scenario.read_text().replace("type: joint,", "type: joint, joints: [j1],"))
    write_arm(tmp_path / "mine/robots/arm.urdf", f"\n{mesh_of(mesh)}")
    for folder in ("mine/meshes", ""):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "part.obj").write_text(TETRAHEDRON)
    (tmp_path / "mine/meshes/out.obj").symlink_to(tmp_path / "part.obj")
    return scenario


ARM_OUTSIDE = r"x\.yaml:2: robot\.urdf: .*/arm\.urdf:2: the mesh .*part\.obj lies outside of .*/mine; allowed"


@pytest.mark.parametrize(
    "mesh",
    [
        "../../part.obj",
        "{tmp_path}/part.obj",
        "file://{tmp_path}/part.obj",
        "package://robots/../../part.obj",
        "../meshes/out.obj",
    ],
)
def test_meshes_of_a_urdf_outside_are_refused_unread(tmp_path: Path, mesh: str) -> None:
    scenario = with_mesh(tmp_path, mesh.format(tmp_path=tmp_path))
    (tmp_path / "part.obj").chmod(0)
    with pytest.raises(ScenarioError, match=ARM_OUTSIDE) as refused:
        load_scenario(scenario)
    assert len(refused.value.faults) == 1


def test_meshes_of_a_urdf_can_be_allowed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = with_mesh(tmp_path, "../../part.obj")
    monkeypatch.setenv("LPB_ALLOW_PATHS", str(tmp_path))
    assert load_scenario(scenario).concrete["robot"]["joints"] == ["j1", "j2"]


def test_meshes_of_the_project_and_of_installed_robots_are_allowed(tmp_path: Path) -> None:
    installed = load_urdf(library_robot("xarm6").path).meshes[0]
    for mesh in ("../meshes/part.obj", f"file://{installed}"):
        folder = tmp_path / str(len(mesh))
        folder.mkdir()
        assert load_scenario(with_mesh(folder, mesh)).concrete["robot"]["joints"] == ["j1", "j2"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("f 1 2 3\n", "cannot be read as OBJ: found 'f 1 2 3'; names vertex 1 of 0 before this line"),
        ("mtllib ../../secret.urdf\n" + TETRAHEDRON, "'../../secret.urdf' lies outside of"),
    ],
)
def test_damaged_meshes_are_told_with_the_lines_that_name_them(tmp_path: Path, content: str, message: str) -> None:
    scenario = with_mesh(tmp_path, "../meshes/part.obj")
    (tmp_path / "mine/meshes/part.obj").write_text(content)
    with pytest.raises(ScenarioError) as refused:
        load_scenario(scenario)
    place = r".*x\.yaml:2: robot\.urdf: .*arm\.urdf:2: .*part\.obj:1: "
    assert re.match(place + re.escape(message), str(refused.value))


def test_a_pipe_is_no_mesh_and_no_robot(tmp_path: Path) -> None:
    scenario = with_mesh(tmp_path, "../meshes/pipe.obj")
    os.mkfifo(tmp_path / "mine/meshes/pipe.obj")
    with pytest.raises(ScenarioError, match=r"the mesh '\.\./meshes/pipe\.obj' is not there"):
        load_scenario(scenario)
    scenario.write_text(SPATIAL.replace("PATH", "pipe.urdf"))
    os.mkfifo(scenario.with_name("pipe.urdf"))
    with pytest.raises(ScenarioError, match=r"x\.yaml:2: robot\.urdf: there is no file"):
        load_scenario(scenario)
    scenario.write_text(SPATIAL.replace("PATH", "loop.urdf"))
    scenario.with_name("loop.urdf").symlink_to("loop.urdf")
    with pytest.raises(ScenarioError, match=r"x\.yaml:2: robot\.urdf: .*loop\.urdf is a link that leads to itself"):
        load_scenario(scenario)
