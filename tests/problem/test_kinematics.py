"""Frames, Jacobians and actuation of every planar robot."""

from math import atan2, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from pytest_lpb.problem.planar.robot import PlanarRobot

from .entries import ARM, CART, POINT, make_robot

ROBOTS: dict[str, PlanarRobot] = {
    "point": make_robot(POINT),
    "arm1": make_robot(ARM, links=[0.7]),
    "arm3": make_robot(ARM),
    "arm7": make_robot(ARM, links=[1.0, 0.3, 0.4, 1.2, 0.1, 0.8, 0.6]),
    "cart": make_robot(CART),
}
LINKS = [(name, link) for name, robot in ROBOTS.items() for link in robot.link_names]
STEP = 1e-6  # [rad or m] of central differences


def configurations(dof: int) -> st.SearchStrategy[list[float]]:
    return st.lists(st.floats(-7.0, 7.0), min_size=dof, max_size=dof)


def pose(robot: PlanarRobot, q: NDArray[np.float64], link: str) -> NDArray[np.float64]:
    """Position and angle (3,); the angle within ±pi."""
    matrix = robot.forward_kinematics(q, link)
    return np.array([matrix[0, 2], matrix[1, 2], atan2(matrix[1, 0], matrix[0, 0])])


def test_names() -> None:
    arm = ROBOTS["arm3"]
    assert arm.link_names == ("base", "link1", "link2", "link3", "end")
    assert arm.joint_names == ("joint1", "joint2", "joint3")
    assert ROBOTS["point"].link_names == ("body",)
    assert ROBOTS["cart"].joint_names == ("x", "y", "theta")
    assert {robot.n_actions for robot in (ROBOTS["cart"], ROBOTS["point"])} == {2}
    assert (ROBOTS["cart"].dof, arm.dof, arm.n_actions) == (3, 3, 3)


def test_arm_by_hand() -> None:
    arm = make_robot(ARM, links=[1.0, 0.5])
    end = arm.forward_kinematics([pi / 2, -pi / 2], "end")
    assert_allclose(end, [[1.0, 0.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]], atol=1e-15)
    assert_allclose(pose(arm, np.array([pi / 2, -pi / 2]), "link2"), [0.0, 1.0, 0.0], atol=1e-15)
    assert_allclose(pose(arm, np.array([pi / 4, 0.0]), "end"), [1.5 / sqrt(2), 1.5 / sqrt(2), pi / 4])
    # Turning the first joint swings the tip about the origin, turning the second about the elbow.
    assert_allclose(arm.jacobian([pi / 2, -pi / 2], "end"), [[-1.0, 0.0], [0.5, 0.5], [1.0, 1.0]], atol=1e-15)
    assert_array_equal(arm.jacobian([0.3, 0.4], "base"), np.zeros((3, 2)))


def test_cart_and_point_by_hand() -> None:
    assert_allclose(pose(ROBOTS["cart"], np.array([1.0, 2.0, 0.5]), "base"), [1.0, 2.0, 0.5])
    assert_allclose(pose(ROBOTS["point"], np.array([1.0, 2.0]), "body"), [1.0, 2.0, 0.0])


def test_an_unknown_link_names_the_nearest() -> None:
    for robot in ROBOTS.values():
        for call in (robot.forward_kinematics, robot.jacobian):
            with pytest.raises(ValueError, match=r"no link 'bse' in .*links: "):
                call(np.zeros(robot.dof), "bse")
    with pytest.raises(ValueError, match="did you mean 'base'"):
        ROBOTS["arm3"].link_index("bse")


@pytest.mark.parametrize(("name", "link"), LINKS)
@given(data=st.data())
def test_jacobians_are_derivatives(name: str, link: str, data: st.DataObject) -> None:
    robot = ROBOTS[name]
    q = np.array(data.draw(configurations(robot.dof)))
    jacobian = robot.jacobian(q, link)
    assert jacobian.shape == (3, robot.dof)
    for joint in range(robot.dof):
        ahead, behind = q.copy(), q.copy()
        ahead[joint] += STEP
        behind[joint] -= STEP
        change = pose(robot, ahead, link) - pose(robot, behind, link)
        change[2] = (change[2] + pi) % (2.0 * pi) - pi
        assert_allclose(jacobian[:, joint], change / (2.0 * STEP), atol=1e-7)


@pytest.mark.parametrize("name", ROBOTS)
@given(data=st.data())
def test_positions_along_a_trajectory_are_those_of_the_frames(name: str, data: st.DataObject) -> None:
    robot = ROBOTS[name]
    q = np.array(data.draw(st.lists(configurations(robot.dof), min_size=1, max_size=4)))
    positions = robot.link_positions(q)
    assert positions.shape == (len(q), len(robot.link_names), 2)
    for row, expected in zip(q, positions, strict=True):
        frames = [robot.forward_kinematics(row, link)[:2, 2] for link in robot.link_names]
        assert_allclose(expected, frames, atol=1e-13)


@pytest.mark.parametrize("name", ROBOTS)
def test_positions_along_no_trajectory(name: str) -> None:
    robot = ROBOTS[name]
    assert robot.link_positions(np.zeros((0, robot.dof))).shape == (0, len(robot.link_names), 2)


@pytest.mark.parametrize("name", ROBOTS)
@given(data=st.data())
def test_the_action_map_gives_joint_velocities(name: str, data: st.DataObject) -> None:
    robot = ROBOTS[name]
    q, u = data.draw(configurations(robot.dof)), data.draw(configurations(robot.n_actions))
    matrix = robot.action_map(q)
    assert matrix.shape == (robot.dof, robot.n_actions)
    assert_allclose(matrix @ np.array(u), robot.joint_velocity(q, u), atol=1e-14)


def test_the_cart_drives_forward_and_turns_left() -> None:
    assert_allclose(ROBOTS["cart"].joint_velocity([0.0, 0.0, pi / 2], [2.0, 0.3]), [0.0, 2.0, 0.3], atol=1e-15)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_is_rebuilt_from_its_dictionary(name: str) -> None:
    robot = ROBOTS[name]
    again = make_robot(robot.to_dict())
    q = np.linspace(0.1, 0.9, robot.dof)
    for link in robot.link_names:
        assert_array_equal(again.forward_kinematics(q, link), robot.forward_kinematics(q, link))
    assert again.to_dict() == robot.to_dict()
    assert again.self_collision_pairs == robot.self_collision_pairs


def test_limits_are_infinite_where_none_are_given() -> None:
    limits = make_robot(POINT, limits={"position": [[-5.0, 5.0], None], "velocity": None}).limits
    assert_array_equal(limits.position, [[-5.0, 5.0], [-np.inf, np.inf]])
    assert_array_equal(limits.velocity, [[-np.inf, np.inf]] * 2)
    assert ROBOTS["cart"].limits.position.shape == (3, 2)
    assert ROBOTS["cart"].limits.velocity.shape == ROBOTS["cart"].limits.acceleration.shape == (2, 2)
