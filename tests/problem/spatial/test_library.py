"""Robots known by name, generated robots, files and meshes."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pytest_lpb.errors import MissingRobotsError, ScenarioError
from pytest_lpb.problem.spatial import library
from pytest_lpb.problem.spatial.assets import assets_digest
from pytest_lpb.problem.spatial.generated import BASE_BODY, GENERATED, Sizes, base_body
from pytest_lpb.problem.spatial.library import known_robots, library_robot
from pytest_lpb.problem.spatial.meshes import capsule_of, covering_capsule, mesh_vertices, surface_points
from pytest_lpb.problem.spatial.triangles import mesh_triangles
from pytest_lpb.problem.spatial.urdf import Geometry, translation
from pytest_lpb.problem.spatial.urdf_reader import load_urdf
from tests.problem.spatial.entries import write_torus
from tests.problem.spatial.test_urdf import ARM, written


@pytest.mark.parametrize("name", known_robots())
def test_each_known_robot_is_there_with_the_joints_it_names(name: str) -> None:
    try:
        robot = library_robot(name)
    except MissingRobotsError as error:
        pytest.skip(str(error))
    model = load_urdf(robot.path)
    named = {*(robot.joints or ()), *robot.steering}
    assert named <= set(model.movable)
    assert set(robot.locked) <= {joint.name for joint in model.joints}
    assert (robot.wheel_base is None) == (robot.base == "fixed")


def test_a_robot_of_a_package_that_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "_example_robot_data_folder", lambda: None)
    with pytest.raises(MissingRobotsError, match=r"the robot ur5 comes with .* pip install 'pytest-lpb\[robots\]'"):
        library_robot("ur5")


def test_an_unknown_robot_has_a_suggestion() -> None:
    with pytest.raises(ScenarioError, match=r"unknown robot 'pandas'; did you mean 'panda'\?; known: "):
        library_robot("pandas")


def test_generated_robots_measure_what_they_are_asked_to() -> None:
    arm = GENERATED["arm_3d"].build(Sizes(links=(0.5, 0.3), body_radius=0.04))
    assert [link.name for link in arm.links] == ["base", "link1", "link2", "end"]
    assert [joint.axis for joint in arm.joints[:2]] == [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0)]
    assert arm.joint("tip").origin[0, 3] == 0.3
    assert arm.link("link1").collisions[0].size == (0.04, 0.5)
    point = GENERATED["point_3d"].build(Sizes(body_radius=0.3))
    assert point.movable == ("x", "y", "z")
    assert point.link("body").collisions[0].size == (0.3,)
    box = base_body([0.8, 0.6, 0.4])
    assert box.name == BASE_BODY
    assert box.collisions[0].origin[2, 3] == 0.2  # it stands on the ground


def copied(folder: Path) -> Path:
    folder.mkdir(parents=True)
    write_torus(folder / "ring.obj", 1.0, 0.2)
    return written(folder, ARM.format(mesh="ring.obj"))


def test_the_digest_follows_the_files_not_their_place(tmp_path: Path) -> None:
    first = copied(tmp_path / "here")
    shutil.copytree(first.parent, tmp_path / "elsewhere" / "deep")
    other = tmp_path / "elsewhere" / "deep" / first.name
    assert assets_digest(first) == assets_digest(other)
    with (other.parent / "ring.obj").open("a", encoding="utf-8") as file:
        file.write("# changed\n")
    assert assets_digest(first) != assets_digest(other)


@given(arrays(float, st.tuples(st.integers(1, 30), st.just(3)), elements=st.floats(-2.0, 2.0)))
@settings(max_examples=200, deadline=None)
def test_covering_capsules_hold_their_points(points: np.ndarray[Any, Any]) -> None:
    capsule = covering_capsule(points)
    start, end, radius = np.array(capsule[:3]), np.array(capsule[3:6]), capsule[6]
    axis = end - start
    length = float(axis @ axis)
    for point in points:
        share = np.clip((point - start) @ axis / length, 0.0, 1.0) if length > 0.0 else 0.0
        assert np.linalg.norm(point - start - share * axis) <= radius + 1e-9


def test_a_covering_capsule_of_a_long_box_is_long_and_thin() -> None:
    capsule = capsule_of(Geometry("box", (0.1, 0.1, 1.0), translation(0.0, 0.0, 0.5)))
    start, end = np.array(capsule[:3]), np.array(capsule[3:6])
    assert capsule[6] < 0.1
    assert 0.8 < np.linalg.norm(end - start) <= 1.0
    assert 0.5 * (start + end) == pytest.approx([0.0, 0.0, 0.5])


def test_spheres_and_capsules_are_their_own_capsules() -> None:
    assert capsule_of(Geometry("sphere", (0.2,), translation(1.0, 2.0, 3.0))) == (1, 2, 3, 1, 2, 3, 0.2)
    assert capsule_of(Geometry("capsule", (0.1, 0.6))) == pytest.approx((0, 0, -0.3, 0, 0, 0.3, 0.1))


STL = """solid one
facet normal 0 0 1
 outer loop
  vertex 0 0 0
  vertex 1 0 0
  vertex 0 1 0
 endloop
endfacet
endsolid one
"""


def test_triangles_of_obj_and_stl_files(tmp_path: Path) -> None:
    corners = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]
    ascii_stl = written(tmp_path, STL, "a.stl")
    assert mesh_triangles(ascii_stl).tolist() == corners
    binary = tmp_path / "b.stl"
    numbers = np.array([0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0], dtype="<f4").tobytes()
    binary.write_bytes(bytes(80) + (1).to_bytes(4, "little") + numbers + bytes(2))
    assert mesh_triangles(binary).tolist() == corners
    square = written(tmp_path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2/2/2 3 4\nf -4 -3 -2\n", "c.obj")
    assert mesh_triangles(square).shape == (3, 3, 3)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.obj", "f 1 2 3\n", "cannot be read as OBJ"),
        ("a.obj", "v 0 0\nv x\n", "cannot be read as OBJ"),
        ("a.obj", "", "has no triangles"),
        ("a.dae", "", "triangles are read from .obj and .stl files"),
    ],
)
def test_meshes_that_are_none(tmp_path: Path, name: str, text: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        mesh_triangles(written(tmp_path, text, name))


def test_points_on_a_concave_mesh_lie_on_it_and_close_together(tmp_path: Path) -> None:
    path = write_torus(tmp_path / "ring.obj", 0.5, 0.1)
    points = surface_points(str(path), 2.0, 0.05, concave=True)
    around = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1.0, points[:, 2])
    assert around.max() < 0.203  # the mesh itself is made of flat triangles
    assert around.min() > 0.19
    hull = surface_points(str(path), 2.0, 0.05, concave=False)
    assert (np.linalg.norm(hull[:, :2], axis=1) < 0.3).any()  # a hull has no hole


def test_a_mesh_that_pybullet_cannot_read(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="PyBullet cannot read this mesh"):
        mesh_vertices(written(tmp_path, "nothing", "a.ply"), (1.0, 1.0, 1.0))


def test_every_mesh_of_a_known_robot_gives_a_capsule() -> None:
    for name in ("panda", "kinova"):
        try:
            model = load_urdf(library_robot(name).path)
        except MissingRobotsError as error:
            pytest.skip(str(error))
        for link in model.links:
            for shape in link.collisions:
                assert capsule_of(shape)[6] > 0.0
