"""Robots in space: names, composition with bases, motion, collision bodies, identity."""

from __future__ import annotations

import json
import subprocess
import sys
from math import cos, inf, pi, sin
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.errors import LpbError, ScenarioError
from pytest_lpb.problem.robot import robot_from
from pytest_lpb.problem.spatial.base import BASES
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.rotations import matrix_of, matrix_of_rpy
from tests.problem.entries import ARM as PLANAR_ARM
from tests.problem.entries import make_robot, problem_entry
from tests.problem.spatial.robots import (
    ARM,
    CAR,
    CART,
    ENTRIES,
    HUSKY,
    KUKA,
    MOUNTED,
    PANDA,
    POINT,
    RACECAR,
    TILTED,
    mimic_robot,
    robot_entry,
    spatial_robot,
)

EXACT = 1e-13


def random_q(robot: SpatialRobot, count: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    return np.random.Generator(np.random.PCG64(5)).uniform(-1.0, 1.0, (count, robot.dof))


def world_pose(entry: dict[str, list[float]]) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    pose = np.eye(4)
    pose[:3, :3] = matrix_of(entry["orientation"])
    pose[:3, 3] = entry["position"]
    return pose


def test_names_in_the_order_of_q_and_u() -> None:
    robot = spatial_robot({**MOUNTED, "base": "bicycle", "wheel_base": 0.5})
    assert robot.joint_names == ("x", "y", "theta", "delta", *PANDA["joints"])
    assert robot.joint_types == ("prismatic", "prismatic", *["revolute"] * 9)
    assert robot.action_kinds == ("prismatic", *["revolute"] * 8)
    assert (robot.dof, robot.n_actions, robot.dimension, robot.base) == (11, 9, 3, "bicycle")
    assert robot.link_names[:3] == ("mobile_base", "panda_link0", "panda_link1")
    assert not any(name.startswith("lpb_") for name in robot.link_names)


@pytest.mark.parametrize("name", ENTRIES)
def test_sizes_agree(name: str) -> None:
    robot = spatial_robot(ENTRIES[name])
    assert len(robot.joint_names) == len(robot.joint_types) == robot.dof
    assert len(robot.action_kinds) == robot.n_actions
    assert robot.limits.position.shape == (robot.dof, 2)
    assert robot.limits.velocity.shape == robot.limits.effort.shape == (robot.n_actions, 2)
    assert robot.headings == (() if robot.base == "fixed" else (2,))
    assert robot.non_holonomic == (robot.dof > robot.n_actions)


def test_limits_are_those_of_the_entry() -> None:
    limits = spatial_robot(ARM, limits={"position": [[-1.0, 2.0], None, [0.0, 1.0]], "velocity": None}).limits
    assert_array_equal(limits.position, [[-1.0, 2.0], [-inf, inf], [0.0, 1.0]])
    assert_array_equal(limits.velocity, [[-inf, inf]] * 3)


def test_a_fixed_robot_stands_at_its_base_pose() -> None:
    there, here = spatial_robot(PANDA, base_pose=TILTED), spatial_robot(PANDA)
    assert_allclose(there.base_pose, world_pose(TILTED), atol=EXACT)
    for q in random_q(there, 3):
        assert_allclose(there.link_frames(q), there.base_pose @ here.link_frames(q), atol=EXACT)


@pytest.mark.parametrize("base", ["holonomic", "differential_drive", "bicycle"])
def test_a_mounted_robot_moves_with_its_base(base: str) -> None:
    robot, arm = spatial_robot({**MOUNTED, "base": base, "wheel_base": 0.5}), spatial_robot(PANDA)
    for q in random_q(robot, 3):
        moving = np.eye(4)
        moving[:3, :3] = matrix_of_rpy(0.0, 0.0, q[2])
        moving[:2, 3] = q[:2]
        frames = robot.link_frames(q)
        assert_allclose(frames[0], moving, atol=EXACT)  # mobile_base
        assert_allclose(frames[1:], moving @ robot.base_pose @ arm.link_frames(q[-7:]), atol=EXACT)


def test_the_racecars_front_wheels_follow_the_steering_angle() -> None:
    robot = spatial_robot(RACECAR)
    straight, left = (robot.link_frames([0.0, 0.0, 0.0, delta]) for delta in (0.0, 0.3))
    turned = {
        name
        for index, name in enumerate(robot.link_names)
        if not np.allclose(straight[index, :3, :3], left[index, :3, :3])
    }
    assert {"left_steering_hinge", "right_steering_hinge"} <= turned
    assert {"left_front_wheel", "right_front_wheel"} <= turned
    assert not {"chassis", "left_rear_wheel", "right_rear_wheel"} & turned
    hinge = robot.link_index("left_steering_hinge")
    expected = matrix_of_rpy(0.0, 0.0, 0.3) @ straight[hinge, :3, :3]
    assert_allclose(left[hinge, :3, :3], expected, atol=1e-5)  # the file's right angles are 1.5708


@pytest.mark.parametrize(("entry", "q"), [(CART, [1.0, 2.0, 0.5]), (CAR, [1.0, 2.0, 0.5, 0.3])], ids=["cart", "car"])
def test_vehicles_by_hand(entry: dict[str, object], q: list[float]) -> None:
    robot = spatial_robot(entry)
    assert robot.link_names == ("base",)
    expected = np.eye(4)
    expected[:3, :3] = matrix_of_rpy(0.0, 0.0, 0.5)
    expected[:2, 3] = (1.0, 2.0)
    assert_allclose(robot.forward_kinematics(q, "base"), expected, atol=EXACT)


def test_the_point_by_hand() -> None:
    robot = spatial_robot(POINT, base_pose={"position": [1.0, 2.0, 3.0], "orientation": [1.0, 0.0, 0.0, 0.0]})
    assert (robot.joint_names, robot.link_names) == (("x", "y", "z"), ("body",))
    assert_allclose(robot.forward_kinematics([0.1, 0.2, 0.3], "body")[:3, 3], [1.1, 2.2, 3.3], atol=EXACT)
    assert_array_equal(robot.jacobian([0.1, 0.2, 0.3], "body"), np.eye(6)[:, :3])
    (body,) = robot.collision_bodies
    assert_allclose(body.capsules, [(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2)])


def test_the_arm_has_capsules_along_its_links() -> None:
    robot = spatial_robot(ARM)
    assert robot.link_names == ("base", "link1", "link2", "link3", "end")
    assert robot.body_names == ("base", "link1", "link2", "link3")
    for body, length in zip(robot.collision_bodies[1:], ARM["links"], strict=True):
        ends = sorted([body.capsules[0][:3], body.capsules[0][3:6]])
        assert_allclose(ends, [[0.0] * 3, [length, 0.0, 0.0]], atol=EXACT)
        assert body.capsules[0][6] == pytest.approx(0.05)


@pytest.mark.parametrize("name", ENTRIES)
def test_frames_are_positions_and_quaternions(name: str) -> None:
    robot = spatial_robot(ENTRIES[name])
    for q in random_q(robot, 3):
        frames, poses = robot.frames(q.tolist()), robot.link_frames(q)
        assert len(frames) == len(robot.link_names)
        for frame, pose in zip(frames, poses, strict=True):
            assert all(type(number) is float for number in frame)
            assert_allclose(frame[:3], pose[:3, 3], atol=EXACT)
            assert_allclose(matrix_of(frame[3:]), pose[:3, :3], atol=EXACT)


@pytest.mark.parametrize("name", ENTRIES)
def test_positions_along_a_trajectory_are_those_of_the_frames(name: str) -> None:
    robot = spatial_robot(ENTRIES[name])
    trajectory = random_q(robot, 4)
    positions = robot.link_positions(trajectory)
    assert positions.shape == (4, len(robot.link_names), 3)
    for q, expected in zip(trajectory, positions, strict=True):
        assert_allclose([robot.forward_kinematics(q, link)[:3, 3] for link in robot.link_names], expected, atol=EXACT)


def test_an_unknown_link_names_the_nearest() -> None:
    robot = spatial_robot(PANDA)
    for call in (robot.forward_kinematics, robot.jacobian, robot.frame_and_jacobian):
        with pytest.raises(ValueError, match=r"no link 'panda_hnd' in panda.*did you mean 'panda_hand'"):
            call(np.zeros(7), "panda_hnd")


@pytest.mark.parametrize("name", ENTRIES)
def test_the_action_map_gives_joint_velocities(name: str) -> None:
    robot = spatial_robot(ENTRIES[name])
    u = np.linspace(-1.0, 1.0, robot.n_actions)
    for q in random_q(robot, 3):
        matrix = robot.action_map(q)
        assert matrix.shape == (robot.dof, robot.n_actions)
        assert_allclose(matrix @ u, robot.joint_velocity(q.tolist(), u.tolist()), atol=1e-15)


@pytest.mark.parametrize("control", ["acceleration", "velocity"])
@pytest.mark.parametrize("base", BASES)
def test_the_base_and_the_arm_move_each_by_itself(base: str, control: str) -> None:
    robot = spatial_robot({**ARM, "base": base, "wheel_base": 0.5, "control": control})
    moving = BASES[base](control, 0.5)
    joints, actions = len(moving.joints), len(moving.actions)
    q, u, action = ([0.1 * (index + 1) for index in range(size)] for size in (robot.dof, *[robot.n_actions] * 2))
    after, velocity = robot.integrate(q, u, action, 0.1)
    expected = moving.integrate(q[:joints], u[:actions], action[:actions], 0.1)
    assert (after[:joints], velocity[:actions]) == expected
    rate = np.array(action if control == "velocity" else u)[actions:]
    bend = np.zeros(3) if control == "velocity" else np.array(action[actions:])
    assert_allclose(after[joints:], np.array(q[joints:]) + 0.1 * rate + 0.005 * bend, atol=1e-15)
    assert_allclose(velocity[actions:], rate + 0.1 * bend, atol=1e-15)


def test_torques_have_no_closed_form() -> None:
    with pytest.raises(LpbError, match="dynamics: true"):
        spatial_robot(ARM, control="torque").integrate([0.0] * 3, [0.0] * 3, [0.0] * 3, 0.1)


@pytest.mark.parametrize("entry", [PANDA, KUKA, ARM], ids=["panda", "kuka", "arm"])
def test_no_link_is_beyond_reach(entry: dict[str, object]) -> None:
    robot = spatial_robot(entry, base_pose=TILTED)
    trajectory = np.random.Generator(np.random.PCG64(6)).uniform(-pi, pi, (2000, robot.dof))
    distances = np.linalg.norm(robot.link_positions(trajectory) - TILTED["position"], axis=2)
    assert distances.max() <= robot.reach < 2.0


def test_reach_of_the_arm_is_its_length_and_others_have_none() -> None:
    assert spatial_robot(ARM).reach == pytest.approx(1.2)
    assert [spatial_robot(entry).reach for entry in (POINT, CART, CAR, HUSKY, RACECAR)] == [inf] * 5


def test_reach_counts_sliding_joints(tmp_path: Path) -> None:
    robot = mimic_robot(tmp_path, limits={"position": [[0.0, 1.0], [0.0, 0.1]]})
    ends = robot.link_positions(np.array([[lift, opening] for lift in (0.0, 1.0) for opening in (0.0, 0.1)]))
    assert np.linalg.norm(ends, axis=2).max() <= robot.reach < 3.0


def test_reach_follows_the_limits_of_the_entry(tmp_path: Path) -> None:
    """They may be wider than those of the file."""
    robot = mimic_robot(tmp_path, limits={"position": [[0.0, 4.0], [0.0, 0.1]]})
    assert robot.reach >= np.linalg.norm(robot.forward_kinematics([4.0, 0.1], "left")[:3, 3])
    assert mimic_robot(tmp_path, limits={"position": [None, [0.0, 0.1]]}).reach == inf


def test_spheres_at_link_frames() -> None:
    robot = spatial_robot(PANDA, collision={"link_spheres": 0.15})
    assert robot.body_names == robot.link_names
    for body in robot.collision_bodies:
        assert_allclose(body.capsules, [(0.0,) * 6 + (0.15,)])


def test_spheres_of_some_links() -> None:
    spheres = {"link2": [[0.1, 0.0, 0.0, 0.06], [0.3, 0.0, 0.1, 0.05]]}
    robot = spatial_robot(ARM, collision={"spheres": spheres})
    (body,) = robot.collision_bodies
    assert (body.name, body.link) == ("link2", "link2")
    assert_allclose(body.capsules, [(0.1, 0.0, 0.0) * 2 + (0.06,), (0.3, 0.0, 0.1) * 2 + (0.05,)])


def test_default_pairs_leave_out_neighbours() -> None:
    robot = spatial_robot({**ARM, "links": [0.5, 0.4, 0.3]}, self_collision_pairs=None)
    assert robot.self_collision_pairs == (("base", "link2"), ("base", "link3"), ("link1", "link3"))
    assert robot.left_out_pairs == ()


def test_pairs_that_always_overlap_are_left_out_and_listed() -> None:
    """A first link shorter than the body's radius: the base is inside the second link in every configuration."""
    robot = spatial_robot({**ARM, "links": [0.04, 0.4, 0.4]}, self_collision_pairs=None)
    assert robot.left_out_pairs == (("base", "link2"),)
    assert robot.self_collision_pairs == (("base", "link3"), ("link1", "link3"))


def test_links_that_move_as_one_make_no_pairs() -> None:
    assert spatial_robot(HUSKY, self_collision_pairs=None).self_collision_pairs == ()


def test_a_mounted_arms_root_belongs_to_its_base() -> None:
    robot = spatial_robot(
        {**ARM, "base": "holonomic", "base_size": [0.3, 0.3, 0.02]},
        base_pose={"position": [0.0, 0.0, 0.3], "orientation": [1.0, 0.0, 0.0, 0.0]},
        self_collision_pairs=None,
    )
    pairs = {frozenset(pair) for pair in robot.self_collision_pairs}
    assert {frozenset({"mobile_base", "link2"}), frozenset({"mobile_base", "link3"})} <= pairs
    assert not pairs & {frozenset({"mobile_base", "base"}), frozenset({"mobile_base", "link1"})}


def test_given_pairs_are_taken_as_they_are() -> None:
    robot = spatial_robot(ARM, self_collision_pairs=[["base", "link1"]])
    assert robot.self_collision_pairs == (("base", "link1"),)
    assert robot.left_out_pairs == ()


@pytest.mark.parametrize("name", ENTRIES)
def test_a_robot_is_rebuilt_from_its_dictionary(name: str) -> None:
    robot = spatial_robot(ENTRIES[name])
    again = robot_from(json.loads(json.dumps(robot.to_dict())))
    q = np.linspace(0.1, 0.9, robot.dof)
    for link in robot.link_names:
        assert_array_equal(again.forward_kinematics(q, link), robot.forward_kinematics(q, link))
    assert (again.to_dict(), again.hashed()) == (robot.to_dict(), robot.hashed())


def test_robots_of_one_file_differ_in_what_is_planned() -> None:
    """What is kept between constructions belongs to its entry alone."""
    free, held = spatial_robot(ENTRIES["panda with its fingers"]), spatial_robot(PANDA)
    assert (free.dof, held.dof) == (8, 7)
    wide, narrow = (spatial_robot(PANDA, locked_joints={"panda_finger_joint1": width}) for width in (0.04, 0.0))
    gap = [robot.forward_kinematics(np.zeros(7), "panda_leftfinger")[:3, 3] for robot in (wide, narrow)]
    assert np.linalg.norm(gap[0] - gap[1]) == pytest.approx(0.04)


def test_what_robots_share_cannot_be_changed() -> None:
    """Robots of equal entries have their model, and with it their poses, in common."""
    first, second = (spatial_robot(PANDA, base_pose=TILTED) for _ in range(2))
    assert first.urdf is second.urdf
    assert not first.base_pose.flags.writeable
    assert not any(joint.origin.flags.writeable for joint in first.urdf.joints)


def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    robot = mimic_robot(tmp_path)
    assert robot.urdf_path is not None
    path, identity = Path(robot.urdf_path), robot.hashed()
    path.write_text(path.read_text(encoding="utf-8").replace('0 0 1"/><axis', '0 0 1.75"/><axis'), encoding="utf-8")
    again = spatial_robot({"urdf": str(path), "joints": ["lift", "open"]})
    assert again.forward_kinematics([0.0, 0.0], "lifted")[2, 3] == 1.75
    assert again.hashed() != identity


def test_identity_is_that_of_the_files_wherever_they_lie(tmp_path: Path) -> None:
    folders = [tmp_path / "here", tmp_path / "there"]
    for folder in folders:
        folder.mkdir()
    here, there = (mimic_robot(folder) for folder in folders)
    assert here.urdf_path != there.urdf_path
    assert here.hashed() == there.hashed()
    assert str(tmp_path) not in json.dumps(here.hashed())
    assert mimic_robot(folders[0], control="velocity").hashed() != here.hashed()


def test_a_robot_known_by_name_is_identified_by_name_and_files() -> None:
    identity = spatial_robot(PANDA).hashed()
    assert identity["model"] == "panda"
    assert len(identity["assets"]) == 64
    assert spatial_robot(ARM).hashed() == robot_entry(ARM)  # made here: there are no files


def test_planar_robots_are_identified_by_their_entries() -> None:
    robot = make_robot(PLANAR_ARM)
    assert robot.hashed() == robot.to_dict() == problem_entry(PLANAR_ARM)["robot"]


def test_paths_are_those_of_the_files_that_were_read(tmp_path: Path) -> None:
    assert mimic_robot(tmp_path).urdf_path == str(tmp_path / "gripper.urdf")
    assert spatial_robot(ARM).urdf_path is None
    path = spatial_robot(PANDA).urdf_path
    assert path is not None
    assert Path(path).is_file()


def test_joints_of_the_base_and_of_the_file_must_have_different_names(tmp_path: Path) -> None:
    path = tmp_path / "stage.urdf"
    path.write_text(
        '<robot name="stage"><link name="a"/><link name="b"/><joint name="theta" type="continuous">'
        '<parent link="a"/><child link="b"/></joint></robot>',
        encoding="utf-8",
    )
    spatial_robot({"urdf": str(path), "joints": ["theta"]})
    with pytest.raises(ScenarioError, match="stage has joints called theta, as its base has"):
        spatial_robot({"urdf": str(path), "joints": ["theta"], "base": "holonomic"})


def test_kinematics_need_no_simulator() -> None:
    """Planners that only ask for frames load no PyBullet."""
    code = (
        "import json, sys\n"
        "from pytest_lpb.problem.robot import robot_from\n"
        "robot = robot_from(json.loads(sys.argv[1]))\n"
        "robot.frames([0.1] * 7), robot.jacobian([0.1] * 7, 'panda_link8'), robot.hashed(), robot.body_names\n"
        "assert 'pybullet' not in sys.modules and 'casadi' not in sys.modules\n"
    )
    entry = json.dumps(robot_entry(PANDA, self_collision_pairs=None))
    done = subprocess.run([sys.executable, "-c", code, entry], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_cart_drives_ahead_in_space() -> None:
    robot = spatial_robot(CART, control="velocity")
    (x, y, theta), _ = robot.integrate([0.0, 0.0, 0.3], [0.0, 0.0], [2.0, 0.0], 0.5)
    assert_allclose([x, y, theta], [cos(0.3), sin(0.3), 0.3], atol=EXACT)
