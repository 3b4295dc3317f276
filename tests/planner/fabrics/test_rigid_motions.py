"""Where a scene is, how it is turned and whether it is seen in a mirror makes no difference to what is done in it."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.planner.fabrics.planner import Fabrics
from pytest_lpb.problem.spatial.rotations import from_axis_angle, matrix_of, multiply
from tests.planner import problems
from tests.planner.scene.making import Array, Entry, goal, observed, obstacle, planar, problem_of, spatial
from tests.problem.spatial.robots import POINT as SPATIAL_POINT

ANGLES = st.floats(-pi, pi)
OFFSETS = st.lists(st.floats(-20.0, 20.0), min_size=2, max_size=2)
POINT, CART, ARM = planar(problems.POINT), planar(problems.CART), planar(problems.arm(0.6, 0.5, 0.4))

THINGS = [
    obstacle("circle", [0.9, 0.2], radius=0.3, name="disc", velocity=[-0.2, 0.3], acceleration=[0.1, -0.4]),
    obstacle("circle", [-0.4, 0.9], radius=0.2, name="other"),
    obstacle("rectangle", [0.3, -0.9], size=[0.6, 0.3], orientation=0.4, name="box"),
]
Q, U, TARGET = np.array([0.1, -0.2]), np.array([0.5, 0.2]), np.array([1.6, 0.5])
CART_Q, CART_U = np.array([0.1, -0.2, 0.3]), np.array([0.5, 0.2])
ARM_Q, ARM_U = np.array([1.3, -0.3, 0.3]), np.array([0.3, -0.2, 0.4])


def reach(link: str, target: Array) -> list[Entry]:
    return [goal("position", target, link=link)]


# One planner per robot: composed once, set up once.
PLANNERS = {name: Fabrics() for name in ("point", "cart", "arm")}
for name, robot, link in (("point", POINT, "body"), ("cart", CART, "base"), ("arm", ARM, "end")):
    PLANNERS[name].setup(problem_of(robot, reach(link, TARGET), THINGS))


def action(name: str, q: Array, u: Array, target: Array, things: list[Entry]) -> Array:
    return PLANNERS[name].compute_action(observed(q, u, reach("", target), things))


def turned(things: list[Entry], turn: Array, angle: float, offset: Array) -> list[Entry]:
    """Obstacles in the plane after a rigid motion."""
    return [
        {
            **thing,
            "position": turn @ thing["position"] + offset,
            "velocity": turn @ thing["velocity"],
            "acceleration": turn @ thing["acceleration"],
            "orientation": thing["orientation"] + angle,
        }
        for thing in things
    ]


def rotation(angle: float) -> Array:
    return np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])


@given(ANGLES, OFFSETS)
def test_a_point_s_action_turns_with_the_scene(angle: float, offset: list[float]) -> None:
    turn, shift = rotation(angle), np.array(offset)
    found = action("point", turn @ Q + shift, turn @ U, turn @ TARGET + shift, turned(THINGS, turn, angle, shift))
    assert found == pytest.approx(turn @ action("point", Q, U, TARGET, THINGS), abs=1e-9)


@given(ANGLES, OFFSETS)
def test_a_cart_acts_the_same_wherever_the_scene_is(angle: float, offset: list[float]) -> None:
    turn, shift = rotation(angle), np.array(offset)
    q = np.array([*(turn @ CART_Q[:2] + shift), CART_Q[2] + angle])
    found = action("cart", q, CART_U, turn @ TARGET + shift, turned(THINGS, turn, angle, shift))
    assert found == pytest.approx(action("cart", CART_Q, CART_U, TARGET, THINGS), abs=1e-9)


@given(ANGLES)
def test_an_arm_acts_the_same_when_all_is_turned_about_its_base(angle: float) -> None:
    turn, nothing = rotation(angle), np.zeros(2)
    found = action(
        "arm", ARM_Q + np.array([angle, 0.0, 0.0]), ARM_U, turn @ TARGET, turned(THINGS, turn, angle, nothing)
    )
    assert found == pytest.approx(action("arm", ARM_Q, ARM_U, TARGET, THINGS), abs=1e-9)


def mirrored(things: list[Entry]) -> list[Entry]:
    """Obstacles on the other side of the x-axis."""
    mirror = np.diag([1.0, -1.0])
    return [{**thing, "orientation": -thing["orientation"]} for thing in turned(things, mirror, 0.0, np.zeros(2))]


def test_a_cart_in_a_mirror_turns_the_other_way() -> None:
    mirror = np.array([1.0, -1.0])
    found = action("cart", CART_Q * [1.0, -1.0, -1.0], CART_U * mirror, TARGET * mirror, mirrored(THINGS))
    expected = action("cart", CART_Q, CART_U, TARGET, THINGS)
    assert found == pytest.approx(mirror * expected, abs=1e-9)
    assert abs(expected[1]) > 0.1


def test_an_arm_in_a_mirror_turns_the_other_way() -> None:
    found = action("arm", -ARM_Q, -ARM_U, TARGET * [1.0, -1.0], mirrored(THINGS))
    assert found == pytest.approx(-action("arm", ARM_Q, ARM_U, TARGET, THINGS), abs=1e-9)


BODIES = [
    obstacle("sphere", [0.9, 0.2, 0.1], radius=0.3, name="ball", velocity=[-0.2, 0.3, 0.1]),
    obstacle("box", [0.2, -0.8, 0.3], size=[0.4, 0.3, 0.8], name="box"),
    obstacle("capsule", [-0.5, 0.3, 0.6], radius=0.1, length=0.5, name="capsule"),
    obstacle("cylinder", [0.1, 0.8, -0.3], radius=0.2, length=0.4, name="cylinder"),
]
AT, SPEED, THERE = np.array([0.1, 0.0, 0.1]), np.array([0.5, 0.2, -0.1]), np.array([1.6, 0.5, 0.3])
IN_SPACE = Fabrics()
IN_SPACE.setup(problem_of(spatial(SPATIAL_POINT), reach("body", THERE), BODIES))


@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).filter(lambda axis: np.linalg.norm(axis) > 0.1), ANGLES)
def test_a_point_s_action_in_space_turns_with_the_scene(axis: list[float], angle: float) -> None:
    quaternion = from_axis_angle((np.array(axis) / np.linalg.norm(axis)).tolist(), angle)
    turn = np.array(matrix_of(quaternion))
    moved = [
        {
            **thing,
            "position": turn @ thing["position"],
            "velocity": turn @ thing["velocity"],
            "orientation": multiply(quaternion, thing["orientation"]),
        }
        for thing in BODIES
    ]
    found = IN_SPACE.compute_action(observed(turn @ AT, turn @ SPEED, reach("", turn @ THERE), moved))
    expected = IN_SPACE.compute_action(observed(AT, SPEED, reach("", THERE), BODIES))
    assert found == pytest.approx(turn @ expected, abs=1e-9)
