"""Files of ROS packages: found beside what names them, by AMENT_PREFIX_PATH and by ROS_PACKAGE_PATH."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.packages import MAX_FOLDERS, PackageFinder
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.trial.assets import recorded, restored
from tests.scenario.urdfs import BOX, TETRAHEDRON, mesh, write_arm

MESH = "package://tool_description/meshes/tool.obj"
SCENARIO = """\
version: 1
robot: {urdf: "URDF"}
environment: {engine: pybullet}
goal: [{name: reach, type: joint, joints: [j1], target: [0.0], tolerance: 0.1}]
"""


@pytest.fixture(autouse=True)
def no_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever this machine has."""
    for name in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH", "LPB_ALLOW_PATHS"):
        monkeypatch.delenv(name, raising=False)


def package(folder: Path, name: str, *files: str, manifest: bool = True) -> Path:
    """A package with meshes."""
    for file in files:
        path = folder / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(TETRAHEDRON)
    folder.mkdir(parents=True, exist_ok=True)
    if manifest:
        (folder / "package.xml").write_text(f"<package><name> {name} </name></package>")
    return folder


def workspace(tmp_path: Path, urdf: str = "package://arm_description/urdf/arm.urdf") -> Path:
    """An arm and a tool in packages, installed as colcon does, and a scenario in a package of its own."""
    package(tmp_path / "install/tool/share/tool_description", "tool_description", "meshes/tool.obj")
    package(tmp_path / "src/robots/arm", "arm_description")
    write_arm(tmp_path / "src/robots/arm/urdf/arm.urdf", mesh(MESH))
    package(tmp_path / "src/bench", "bench")
    scenario = tmp_path / "src/bench/scenarios/a.yaml"
    scenario.parent.mkdir()
    scenario.write_text(SCENARIO.replace("URDF", urdf))
    return scenario


def ros(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, *, allowed: bool = True) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path}/nowhere:{tmp_path}/install/tool")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}/src")
    if allowed:
        monkeypatch.setenv("LPB_ALLOW_PATHS", str(tmp_path))


def test_robots_and_meshes_of_packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = workspace(tmp_path)
    ros(monkeypatch, tmp_path)
    problem = Problem.from_dict(load_scenario(scenario).concrete)
    assert problem.robot.urdf_path == str(tmp_path / "src/robots/arm/urdf/arm.urdf")
    assert load_scenario(workspace(tmp_path / "b", "../../robots/arm/urdf/arm.urdf")).concrete["robot"]["joints"]


def test_packages_that_are_not_allowed_or_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = workspace(tmp_path)
    with pytest.raises(ScenarioError) as refused:
        load_scenario(scenario)
    assert str(refused.value).endswith(
        "a.yaml:2: robot.urdf: package://arm_description/urdf/arm.urdf is not there; looked for the package "
        f"'arm_description' in the folders above, from {scenario.parent} on, AMENT_PREFIX_PATH (not set), "
        "ROS_PACKAGE_PATH (not set)"
    )
    ros(monkeypatch, tmp_path, allowed=False)
    with pytest.raises(ScenarioError, match=r"arm\.urdf lies outside of .*bench; allowed are .* LPB_ALLOW_PATHS names"):
        load_scenario(scenario)
    monkeypatch.setenv("LPB_ALLOW_PATHS", str(tmp_path / "src"))
    with pytest.raises(ScenarioError, match=r"arm\.urdf:1: the mesh .*/tool\.obj lies outside of .*bench; allowed"):
        load_scenario(scenario)
    scenario.write_text(SCENARIO.replace("URDF", "package://arm_description/arm.urdf"))
    with pytest.raises(
        ScenarioError, match=r"the package 'arm_description' in .*/src/robots/arm has no file 'arm\.urdf'"
    ):
        load_scenario(scenario)


def test_a_visual_of_a_package_that_is_not_allowed_is_not_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = workspace(tmp_path, "../arm.urdf")
    seen = f'{BOX}<visual><geometry><mesh filename="{MESH}"/></geometry></visual>'
    write_arm(tmp_path / "src/bench/arm.urdf", seen)
    ros(monkeypatch, tmp_path, allowed=False)
    robot = Problem.from_dict(load_scenario(scenario).concrete).robot
    assert "tool.obj' lies outside of" in robot.notes[0]  # type: ignore[attr-defined] # of robots in space
    assert robot.urdf.meshes == ()  # type: ignore[attr-defined]


def test_where_packages_are_looked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    beside = tmp_path / "own/urdf/x.urdf"
    package(beside.parents[1], "mine", "meshes/a.obj")
    finder = PackageFinder(beside)
    assert finder.find("package://mine/meshes/a.obj") == tmp_path / "own/meshes/a.obj"
    assert finder.find("package://own/meshes/a.obj") == tmp_path / "own/meshes/a.obj"
    assert finder.find("package://yours/meshes/a.obj") is None  # another package's name
    sources = tmp_path / "ws"
    package(sources / "stack/deep/down/pkg_folder", "pkg", "a.obj")
    package(sources / "stack/twin", "twin", "first.obj")
    package(sources / "zoo/below/twin", "twin", "second.obj")
    package(sources / "ignored/old", "old", "a.obj")
    (sources / "ignored/COLCON_IGNORE").write_text("")
    (sources / "stack/deep/loop").symlink_to(sources)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path}/nowhere:{sources}")
    finder = PackageFinder(beside)
    assert finder.find("package://pkg/a.obj") == sources / "stack/deep/down/pkg_folder/a.obj"
    assert finder.find("package://twin/first.obj") is not None
    assert [finder.find(name) for name in ("package://twin/second.obj", "package://old/a.obj")] == [None, None]
    assert MAX_FOLDERS > 1000


def test_copies_of_packages_stand_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = workspace(tmp_path)
    ros(monkeypatch, tmp_path)
    concrete = load_scenario(scenario).concrete
    run = tmp_path / "run"
    run.mkdir()
    (run / "run.json").write_text("{}")
    copied = recorded(concrete, run)
    assert copied["robot"]["urdf"].startswith("assets/")
    digest = Problem.from_dict(concrete).problem_hash
    (tmp_path / "install").rename(tmp_path / "gone")
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    monkeypatch.delenv("LPB_ALLOW_PATHS")
    assert Problem.from_dict(restored(copied, run)).problem_hash == digest
