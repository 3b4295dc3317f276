"""Frames and Jacobians of trees: against PyBullet, finite differences, closed forms, and each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.rotations import matrix_of, matrix_of_rpy
from pytest_lpb.problem.spatial.tree import KinematicTree
from pytest_lpb.problem.spatial.urdf import Joint, Link, UrdfModel
from pytest_lpb.problem.spatial.urdf_writer import urdf_text
from tests.problem.spatial.robots import ENTRIES, KUKA, PANDA, mimic_robot, spatial_robot

EXACT = 1e-13
STEP = 1e-6  # [rad or m] of central differences
FLAGS = pybullet.URDF_IGNORE_VISUAL_SHAPES | pybullet.URDF_IGNORE_COLLISION_SHAPES


def configurations(dof: int, count: int) -> FloatArray:
    return np.random.Generator(np.random.PCG64(3)).uniform(-2.0, 2.0, (count, dof))


class Peer:
    """The same robot in PyBullet; only names and numbers of `robot` are used."""

    def __init__(self, robot: SpatialRobot, path: str) -> None:
        self.client = Client()
        self.body = self.client.call("loadURDF", path, useFixedBase=True, flags=FLAGS)
        count = self.client.call("getNumJoints", self.body)
        information = [self.client.call("getJointInfo", self.body, index) for index in range(count)]
        self.links = {item[12].decode(): item[0] for item in information}
        joints = {joint.name: joint for joint in robot.urdf.joints}
        self.moving = [item[0] for item in information if item[2] != pybullet.JOINT_FIXED]
        self.rules = []
        for index in self.moving:
            joint = joints[information[index][1].decode()]
            self.rules.append(joint.mimic or (joint.name, 1.0, 0.0))
        self.names = robot.joint_names
        self.locked = robot.locked

    def put(self, q: FloatArray) -> list[float]:
        values = {**self.locked, **dict(zip(self.names, q.tolist(), strict=True))}
        positions = [multiplier * values[source] + offset for source, multiplier, offset in self.rules]
        self.client.call("resetJointStatesMultiDof", self.body, self.moving, [[value] for value in positions])
        return positions

    def frame(self, link: str) -> FloatArray:
        """From the centre of mass's frame: PyBullet rounds the link's own to single precision."""
        state = self.client.call("getLinkState", self.body, self.links[link], computeForwardKinematics=1)
        centre, inside = (matrix_of([w, x, y, z]) for x, y, z, w in (state[1], state[3]))
        pose = np.eye(4)
        pose[:3, :3] = centre @ inside.T
        pose[:3, 3] = state[0] - pose[:3, :3] @ state[2]
        return pose

    def jacobian(self, link: str, positions: list[float]) -> FloatArray:
        """Of the link's frame, with the columns of joints that mimic added to those they follow."""
        rest = [0.0] * len(positions)
        parts = self.client.call(
            "calculateJacobian", self.body, self.links[link], [0.0, 0.0, 0.0], positions, rest, rest
        )
        columns = np.vstack(parts)
        result = np.zeros((6, len(self.names)))
        for column, (source, multiplier, _) in enumerate(self.rules):
            if source in self.names:
                result[:, self.names.index(source)] += multiplier * columns[:, column]
        return result


def compare(robot: SpatialRobot, path: str) -> None:
    peer = Peer(robot, path)
    compared = set()
    for q in configurations(robot.dof, 5):
        positions = peer.put(q)
        for link in robot.link_names:
            if link not in peer.links:  # the root has no joint above it
                continue
            assert_allclose(robot.forward_kinematics(q, link), peer.frame(link), atol=EXACT, err_msg=link)
            assert_allclose(robot.jacobian(q, link), peer.jacobian(link, positions), atol=EXACT, err_msg=link)
            compared.add(link)
    peer.client.close()
    assert len(compared) >= len(robot.link_names) - 1


@pytest.mark.parametrize("entry", [PANDA, KUKA], ids=["panda", "kuka"])
def test_a_robots_own_file_has_the_frames_that_pybullet_finds(entry: dict[str, object]) -> None:
    robot = spatial_robot(entry)
    assert robot.urdf_path is not None
    compare(robot, robot.urdf_path)


@pytest.mark.parametrize("name", ENTRIES)
def test_the_composed_robot_has_the_frames_that_pybullet_finds(name: str, tmp_path: Path) -> None:
    robot = spatial_robot(ENTRIES[name])
    path = tmp_path / "robot.urdf"
    path.write_text(urdf_text(robot.urdf), encoding="utf-8")
    compare(robot, str(path))


def test_joints_that_mimic_have_the_frames_that_pybullet_finds(tmp_path: Path) -> None:
    robot = mimic_robot(tmp_path)
    assert robot.urdf_path is not None
    compare(robot, robot.urdf_path)


def test_joints_that_mimic_by_hand(tmp_path: Path) -> None:
    robot = mimic_robot(tmp_path)
    lift, opening = 0.4, 0.03
    c, s = np.cos(0.5 * lift + 0.1), np.sin(0.5 * lift + 0.1)
    for link, y in (("left", opening), ("right", -opening)):
        pose = robot.forward_kinematics([lift, opening], link)
        assert_allclose(pose[:3, 3], [0.2 + 0.1 * c - y * s, 0.1 * s + y * c, 1.0 + lift], atol=EXACT)
        # The lift raises the finger and turns the wrist at half its rate.
        columns = robot.jacobian([lift, opening], link)
        assert_allclose(columns[:, 0], [*(0.5 * np.array([-0.1 * s - y * c, 0.1 * c - y * s])), 1.0, 0.0, 0.0, 0.5])
        side = np.sign(y)
        assert_allclose(columns[:, 1], [-side * s, side * c, 0.0, 0.0, 0.0, 0.0], atol=EXACT)


def test_a_locked_joint_holds_those_that_mimic_it(tmp_path: Path) -> None:
    free = mimic_robot(tmp_path)
    held = spatial_robot({"urdf": free.urdf_path, "joints": ["open"], "locked_joints": {"lift": 0.4}})
    for opening in (0.0, 0.03):
        expected = free.link_frames([0.4, opening])
        assert_allclose(held.link_frames([opening]), expected, atol=EXACT)
        assert_array_equal(held.jacobian([opening], "wrist"), np.zeros((6, 1)))


def test_the_arm_in_space_by_hand() -> None:
    robot = spatial_robot(ENTRIES["arm"])
    for turn, second, third in configurations(3, 20):
        radius = 0.5 + 0.4 * np.cos(second) + 0.3 * np.cos(second + third)
        height = -0.4 * np.sin(second) - 0.3 * np.sin(second + third)  # a turn about y lowers x
        pose = robot.forward_kinematics([turn, second, third], "end")
        assert_allclose(pose[:3, 3], [radius * np.cos(turn), radius * np.sin(turn), height], atol=EXACT)
        assert_allclose(pose[:3, :3], matrix_of_rpy(0.0, second + third, turn), atol=EXACT)


def central_difference(robot: SpatialRobot, q: FloatArray, link: str) -> FloatArray:
    columns = []
    for joint in range(robot.dof):
        step = STEP * np.eye(robot.dof)[joint]
        ahead, behind = (robot.forward_kinematics(q + sign * step, link) for sign in (1.0, -1.0))
        rate = (ahead - behind) / (2.0 * STEP)
        spin = rate[:3, :3] @ robot.forward_kinematics(q, link)[:3, :3].T
        columns.append([*rate[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]])
    return np.array(columns).T


@pytest.mark.parametrize("name", ENTRIES)
def test_jacobians_are_derivatives(name: str) -> None:
    robot = spatial_robot(ENTRIES[name])
    for q in configurations(robot.dof, 2):
        for link in robot.link_names:
            assert_allclose(robot.jacobian(q, link), central_difference(robot, q, link), atol=1e-8)


@pytest.mark.parametrize("name", ENTRIES)
def test_all_at_once_is_one_by_one(name: str) -> None:
    robot = spatial_robot(ENTRIES[name])
    trajectory = configurations(robot.dof, 4)
    along = robot.link_frames_along(trajectory)
    assert along.shape == (4, len(robot.link_names), 4, 4)
    for row, q in enumerate(trajectory):
        frames, jacobians = robot.frames_and_jacobians(q)
        assert jacobians.shape == (len(robot.link_names), 6, robot.dof)
        assert_allclose(frames, along[row], atol=EXACT)
        for index, link in enumerate(robot.link_names):
            pose, jacobian = robot.frame_and_jacobian(q, link)
            assert_allclose(pose, robot.forward_kinematics(q, link), atol=EXACT)
            assert_allclose(frames[index], pose, atol=EXACT)
            assert_allclose(jacobians[index], jacobian, atol=EXACT)


def test_joints_that_mimic_at_once_are_one_by_one(tmp_path: Path) -> None:
    robot = mimic_robot(tmp_path)
    jacobians = robot.frames_and_jacobians([0.4, 0.03])[1]
    for index, link in enumerate(robot.link_names):
        assert_allclose(jacobians[index], robot.jacobian([0.4, 0.03], link), atol=EXACT)


def test_no_trajectory_has_no_frames() -> None:
    robot = spatial_robot(ENTRIES["panda"])
    assert robot.link_frames_along(np.zeros((0, 7))).shape == (0, len(robot.link_names), 4, 4)


def test_what_is_returned_is_the_callers_own() -> None:
    robot = spatial_robot(ENTRIES["panda"])
    q = np.full(7, 0.3)
    first = robot.forward_kinematics(q, "panda_link0"), robot.jacobian(q, "panda_link8"), robot.link_frames(q)
    kept = [array.copy() for array in first]
    for array in first:
        array[:] = 7.0
    again = robot.forward_kinematics(q, "panda_link0"), robot.jacobian(q, "panda_link8"), robot.link_frames(q)
    for array, expected in zip(again, kept, strict=True):
        assert_array_equal(array, expected)
    assert_array_equal(q, np.full(7, 0.3))


@st.composite
def trees(draw: st.DrawFn) -> tuple[UrdfModel, list[str], dict[str, float]]:
    """A tree of up to seven links, what q moves of it, and what is locked."""
    small = st.floats(-1.5, 1.5, allow_subnormal=False)
    links, joints = [Link("link0")], []
    roles: dict[str, list[str]] = {"planned": [], "locked": []}
    for index in range(1, draw(st.integers(2, 7))):
        origin = np.eye(4)
        origin[:3, :3] = matrix_of_rpy(draw(small), draw(small), draw(small))
        origin[:3, 3] = [draw(small) for _ in range(3)]
        axis = np.array([draw(small), draw(small), 2.0])
        x, y, z = (axis / np.linalg.norm(axis)).tolist()
        role = draw(st.sampled_from(["fixed", "planned", "locked", "mimic"]))
        kind = "fixed" if role == "fixed" else draw(st.sampled_from(["revolute", "prismatic"]))
        followed = [name for names in roles.values() for name in names]
        mimic = None
        if role == "mimic" and followed:
            mimic = (draw(st.sampled_from(followed)), draw(small), draw(small))
        elif role != "fixed":
            roles["planned" if role == "mimic" else role].append(f"joint{index}")
        parent = f"link{draw(st.integers(0, index - 1))}"
        joints.append(Joint(f"joint{index}", kind, parent, f"link{index}", origin, (x, y, z), mimic=mimic))
        links.append(Link(f"link{index}"))
    order = draw(st.permutations(roles["planned"]))
    return UrdfModel("tree", tuple(links), tuple(joints)), list(order), {name: draw(small) for name in roles["locked"]}


def naive_frames(model: UrdfModel, values: dict[str, float]) -> dict[str, FloatArray]:
    """Frames of all links, joint by joint, turns by the exponential of the axis's cross product."""
    from scipy.linalg import expm

    frames = {model.root: np.eye(4)}
    for joint in model.joints:
        source, multiplier, offset = joint.mimic or (joint.name, 1.0, 0.0)
        motion = np.zeros((4, 4))
        if joint.kind == "revolute":
            x, y, z = joint.axis
            motion[:3, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        elif joint.kind == "prismatic":
            motion[:3, 3] = joint.axis
        value = 0.0 if joint.kind == "fixed" else multiplier * values[source] + offset
        frames[joint.child] = frames[joint.parent] @ joint.origin @ expm(value * motion)
    return frames


@settings(max_examples=60, deadline=None)
@given(trees(), st.data())
def test_any_tree_against_matrix_exponentials(
    tree: tuple[UrdfModel, list[str], dict[str, float]], data: st.DataObject
) -> None:
    model, planned, locked = tree
    q = np.array(data.draw(st.lists(st.floats(-3.0, 3.0), min_size=len(planned), max_size=len(planned))))
    kinematics = KinematicTree(model, planned, locked)
    expected = naive_frames(model, {**locked, **dict(zip(planned, q.tolist(), strict=True))})
    frames = kinematics.frames_along(q[None])[0]
    jacobians = kinematics.jacobians(frames)
    for index, name in enumerate(kinematics.names):
        pose, jacobian = kinematics.frame_and_jacobian(q, index)
        assert_allclose(frames[index], expected[name], atol=1e-12)
        assert_allclose(kinematics.frame(q, index), expected[name], atol=1e-12)
        assert_allclose(pose, expected[name], atol=1e-12)
        assert_allclose(jacobians[index], jacobian, atol=1e-12)
