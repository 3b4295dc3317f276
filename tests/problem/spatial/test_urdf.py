"""URDF files: what is read, what is refused, and that PyBullet loads what is written."""

from __future__ import annotations

from math import inf
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.library import known_robots, library_robot
from pytest_lpb.problem.spatial.rotations import matrix_of_rpy, rpy_of_matrix
from pytest_lpb.problem.spatial.tree import KinematicTree
from pytest_lpb.problem.spatial.urdf import UrdfModel
from pytest_lpb.problem.spatial.urdf_reader import load_urdf
from pytest_lpb.problem.spatial.urdf_writer import possible, urdf_text
from tests.problem.spatial.entries import write_torus

ARM = """<?xml version="1.0"?>
<robot name="two">
  <material name="blue"><color rgba="0 0 1 1"/></material>
  <link name="foot">
    <visual><geometry><box size="0.2 0.2 0.1"/></geometry><material name="blue"/></visual>
    <collision><origin xyz="0 0 0.05"/><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
  </link>
  <link name="upper"><collision><geometry><cylinder radius="0.05" length="0.4"/></geometry></collision></link>
  <link name="hand"><collision><geometry><mesh filename="{mesh}" scale="0.1 0.1 0.1"/></geometry></collision>
    <inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="2"/></inertial></link>
  <joint name="lift" type="prismatic"><parent link="foot"/><child link="upper"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 0 2"/><limit lower="0" upper="0.5" velocity="0.3" effort="100"/></joint>
  <joint name="turn" type="continuous"><parent link="upper"/><child link="hand"/>
    <origin xyz="0.1 0 0.4" rpy="0 1.5707963 0"/><axis xyz="1 0 0"/></joint>
</robot>
"""


def written(folder: Path, text: str, name: str = "arm.urdf") -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A URDF in a folder with a blank in its name, and its mesh."""
    folder = tmp_path / "my robot"
    folder.mkdir()
    write_torus(folder / "ring.obj", 1.0, 0.2)
    return written(folder, ARM.format(mesh="ring.obj"))


def test_links_joints_limits_and_geometry_are_read(arm: Path) -> None:
    model = load_urdf(arm)
    assert (model.name, model.root, model.movable) == ("two", "foot", ("lift", "turn"))
    assert [link.name for link in model.links] == ["foot", "upper", "hand"]
    lift, turn = model.joint("lift"), model.joint("turn")
    assert (lift.kind, lift.axis, lift.lower, lift.upper, lift.velocity, lift.effort) == (
        "prismatic",
        (0.0, 0.0, 1.0),
        0.0,
        0.5,
        0.3,
        100.0,
    )
    assert (turn.kind, turn.lower, turn.upper, turn.velocity, turn.effort) == ("revolute", -inf, inf, inf, inf)
    box = model.link("foot").collisions[0]
    assert (box.kind, box.size, box.origin[2, 3]) == ("box", (0.2, 0.2, 0.1), 0.05)
    assert model.link("foot").visuals[0].color == (0.0, 0.0, 1.0, 1.0)
    mesh = model.link("hand").collisions[0]
    assert (mesh.file, mesh.size) == (arm.parent / "ring.obj", (0.1, 0.1, 0.1))
    assert model.meshes == (arm.parent / "ring.obj",)
    assert model.link("hand").inertial.mass == 2.0  # type: ignore[union-attr] # it has one


def test_a_file_that_has_not_changed_is_read_once(arm: Path) -> None:
    assert load_urdf(arm) is load_urdf(arm)
    before = load_urdf(arm)
    arm.write_text(arm.read_text(encoding="utf-8") + "<!-- changed -->\n", encoding="utf-8")
    assert load_urdf(arm) is not before


@pytest.mark.parametrize(
    "mesh", ["package://mine/meshes/ring.obj", "file://{folder}/meshes/ring.obj", "../meshes/ring.obj"]
)
def test_meshes_are_found_in_packages_and_beside_the_file(mesh: str, tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    (folder / "meshes").mkdir(parents=True)
    write_torus(folder / "meshes" / "ring.obj", 1.0, 0.2)
    path = written(folder / "urdf", ARM.format(mesh=mesh.format(folder=folder)))
    assert load_urdf(path).meshes == (folder / "meshes" / "ring.obj",)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("</robot>", "", "arm.urdf:16: is no XML: no element found"),
        ("<robot name", "<sdf name", "is no XML: mismatched tag"),
        ('<?xml version="1.0"?>', '<!DOCTYPE robot [<!ENTITY a "b">]>', "arm.urdf:1: found a DOCTYPE"),
        (
            'parent link="upper"',
            'parent link="uper"',
            "arm.urdf:13: joint 'turn': its parent 'uper' is no link; did you mean 'upper'?",
        ),
        ('child link="hand"', 'child link="upper"', "link 'upper' is the child of two joints, 'lift' and 'turn'"),
        ('parent link="foot"', 'parent link="hand"', "links in a loop: hand, upper; a URDF robot is a tree"),
        (
            'type="continuous"',
            'type="floating"',
            "arm.urdf:13: joint 'turn' is of type 'floating'; allowed: continuous, fixed",
        ),
        ('xyz="1 0 0"', 'xyz="0 0 0"', "arm.urdf:14: found an axis of zeros; it has no direction"),
        (
            'radius="0.05"',
            'radius="thin"',
            "arm.urdf:8: <cylinder> radius: found 'thin'; 1 finite numbers are required",
        ),
        (
            'radius="0.05"',
            'radius="-1"',
            "arm.urdf:8: found the size [-1.0, 0.4]; lengths above 0 m and up to 10000 m are required",
        ),
        ('radius="0.05"', 'radius="nan"', "arm.urdf:8: <cylinder> radius: found 'nan'"),
        ("<cylinder", "<cone", "arm.urdf:8: found <cone>; allowed: box, capsule, cylinder, mesh, sphere"),
        ('name="upper"', 'name="foot"', "arm.urdf:8: <link> 'foot' is there twice; names are unique"),
        ('<joint name="turn"', "<joint", "arm.urdf:13: <joint> has no name"),
        (
            '<axis xyz="1 0 0"/>',
            '<axis xyz="1 0 0"/><mimic joint="lft"/>',
            "mimics 'lft', which is no joint; did you mean 'lift'?",
        ),
    ],
)
def test_faults_are_told_with_their_place(arm: Path, old: str, new: str, message: str) -> None:
    text = arm.read_text(encoding="utf-8")
    assert old in text
    changed = text.replace(old, new, 1)
    if new.startswith("<sdf"):
        changed = text.replace("<robot name", "<sdf name", 1)
    arm.write_text(changed, encoding="utf-8")
    with pytest.raises(ScenarioError) as caught:
        load_urdf(arm)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "arm.urdf:1: is empty; a URDF file has elements"),
        (" \n\n", "arm.urdf:1: is empty"),
        ("<sdf/>", "found <sdf>; a URDF file has a <robot>"),
        ("<robot name='a'/>", "found no <link>"),
        ("<robot name='a'><link name='b'/><link name='c'/></robot>", "several links are no joint's child: b, c"),
        (
            "<robot xmlns:xacro='x' name='a'><xacro:include filename='b'/><link name='c'/></robot>",
            "found xacro macros; run xacro on it first",
        ),
    ],
)
def test_files_that_are_no_robots(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load_urdf(written(tmp_path, text))
    assert message in str(caught.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"none.urdf: cannot be read: No such file or directory"):
        load_urdf(tmp_path / "none.urdf")


TOO_MANY = 128  # joints, with which PyBullet loads a robot but tells no state


def robots() -> list[UrdfModel]:
    """Every robot of the library that is installed."""
    models = []
    for name in known_robots():
        try:
            models.append(load_urdf(library_robot(name).path))
        except ScenarioError:
            continue
    return [model for model in models if len(model.joints) < TOO_MANY]  # worlds merge links of others


@pytest.mark.parametrize("model", robots(), ids=lambda model: model.name)
def test_pybullet_has_the_frames_of_what_is_written(model: UrdfModel, tmp_path: Path) -> None:
    path = written(tmp_path, urdf_text(model, margin=0.001))
    client = Client()
    body = client.call("loadURDF", str(path), useFixedBase=True, flags=pybullet.URDF_IGNORE_VISUAL_SHAPES)
    tree = KinematicTree(model, model.movable, {})
    q = np.random.default_rng(2).uniform(-0.5, 0.5, len(model.movable))
    frames = dict(zip(tree.names, tree.frames_along(q[None])[0], strict=True))
    followers = {j.name: j.mimic for j in model.joints if j.mimic is not None}
    values = dict(zip(model.movable, q.tolist(), strict=True))
    values |= {name: values[source] * factor + offset for name, (source, factor, offset) in followers.items()}
    for index in range(client.call("getNumJoints", body)):
        name = client.call("getJointInfo", body, index)[1].decode()
        if name in values:
            client.call("resetJointState", body, index, values[name])
    for index in range(client.call("getNumJoints", body)):
        link = client.call("getJointInfo", body, index)[12].decode()
        position = client.call("getLinkState", body, index, computeForwardKinematics=True)[4]
        assert frames[link][:3, 3] - frames[model.root][:3, 3] == pytest.approx(
            np.array(position) - base_offset(client, body), abs=1e-5
        )
    client.close()


def base_offset(client: Client, body: int) -> NDArray[np.float64]:
    """Where PyBullet has the root link's frame: it places the centre of mass at the origin's offset."""
    position, _ = client.call("getBasePositionAndOrientation", body)
    local = client.call("getDynamicsInfo", body, -1)[3]
    offset: NDArray[np.float64] = np.subtract(position, local)
    return offset


@given(*[st.floats(-3.1, 3.1)] * 3)
@settings(max_examples=50, deadline=None)
def test_angles_of_a_matrix_give_the_matrix(roll: float, pitch: float, yaw: float) -> None:
    matrix = matrix_of_rpy(roll, pitch, yaw)
    assert matrix_of_rpy(*rpy_of_matrix(matrix)) == pytest.approx(matrix, abs=1e-9)


def test_impossible_inertias_become_a_ball_s() -> None:
    fine = np.diag([1.0, 2.0, 2.5])
    assert possible(fine) is fine
    assert possible(np.diag([0.1, 0.1, 1.0])) == pytest.approx(0.4 * np.eye(3))
    assert possible(np.zeros((3, 3)))[0, 0] > 0.0
