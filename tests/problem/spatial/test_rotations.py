"""Rotations against SciPy, and where formulas are delicate: near the identity, half turns and a pitch of ±pi/2."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from pytest_lpb.problem.spatial.rotations import (
    Quaternion,
    angle_between,
    from_axis_angle,
    from_matrix,
    inverse,
    matrix_of,
    matrix_of_rpy,
    multiply,
    normalised,
    quaternions_of,
    rotate,
    rotation_vector,
    rpy_of_matrix,
    turned,
)

numbers = st.floats(-1.0, 1.0, allow_subnormal=False)
vectors = st.tuples(numbers, numbers, numbers)
axes = vectors.filter(lambda v: sqrt(sum(x * x for x in v)) > 0.1)
quaternions = (
    st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: sum(x * x for x in q) > 0.01).map(normalised)
)
angles = st.floats(-pi, pi)


def of(q: Quaternion) -> Rotation:
    """SciPy's rotation; its quaternions are xyzw."""
    return Rotation.from_quat([*q[1:], q[0]])


@given(quaternions, quaternions, vectors)
def test_products_and_turned_vectors(p: Quaternion, q: Quaternion, v: tuple[float, float, float]) -> None:
    assert_allclose(of(multiply(p, q)).as_matrix(), (of(p) * of(q)).as_matrix(), atol=1e-14)
    assert_allclose(rotate(q, v), of(q).apply(v), atol=1e-14)
    assert_allclose(rotate(multiply(p, q), v), rotate(p, rotate(q, v)), atol=1e-14)
    assert_allclose(rotate(inverse(q), rotate(q, v)), v, atol=1e-14)


@given(quaternions)
def test_matrices(q: Quaternion) -> None:
    matrix = matrix_of(q)
    assert_allclose(matrix, of(q).as_matrix(), atol=1e-14)
    back = from_matrix(matrix)
    assert back[0] >= 0.0
    assert_allclose(abs(np.dot(back, q)), 1.0, atol=1e-14)  # q and -q are the same rotation


@given(st.lists(quaternions, min_size=1, max_size=6))
def test_quaternions_of_many_matrices(many: list[Quaternion]) -> None:
    found = quaternions_of(np.stack([matrix_of(q) for q in many]))
    assert_allclose(found, [from_matrix(matrix_of(q)) for q in many], atol=1e-15)
    assert_allclose(np.linalg.norm(found, axis=1), 1.0, atol=1e-15)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, -0.8)])
def test_half_turns_have_quaternions(axis: tuple[float, float, float]) -> None:
    """Where w vanishes the matrix's trace says nothing."""
    matrix = 2.0 * np.outer(axis, axis) - np.eye(3)
    assert_allclose(matrix_of(from_matrix(matrix)), matrix, atol=1e-15)


def test_no_matrices_have_no_quaternions() -> None:
    assert quaternions_of(np.empty((0, 3, 3))).shape == (0, 4)


@given(axes, angles)
def test_a_turn_about_an_axis(axis: tuple[float, float, float], angle: float) -> None:
    length = sqrt(sum(x * x for x in axis))
    unit = [x / length for x in axis]
    expected = Rotation.from_rotvec(angle * np.array(unit)).as_matrix()
    assert_allclose(matrix_of(from_axis_angle(axis, angle)), expected, atol=1e-14)
    assert_allclose(turned(unit, np.array([0.0, angle])), [np.eye(3), expected], atol=1e-14)


@given(axes, st.one_of(st.floats(1e-6, pi), st.floats(1e-100, 1e-6), st.floats(pi - 1e-6, pi)), quaternions)
def test_angles_are_accurate_near_zero_and_half_turns(
    axis: tuple[float, float, float], angle: float, q: Quaternion
) -> None:
    turn = from_axis_angle(axis, angle)
    assert angle_between(turn, (1.0, 0.0, 0.0, 0.0)) == pytest.approx(angle, rel=1e-14, abs=0.0)
    assert angle_between(multiply(turn, q), q) == pytest.approx(angle, abs=2e-15)
    assert_allclose(np.linalg.norm(rotation_vector(turn)), angle, rtol=1e-14)


@given(axes, st.floats(1e-12, pi - 1e-9))
def test_the_rotation_vector_is_axis_times_angle(axis: tuple[float, float, float], angle: float) -> None:
    unit = np.array(axis) / np.linalg.norm(axis)
    turn = from_axis_angle(axis, angle)
    assert_allclose(rotation_vector(turn), angle * unit, rtol=1e-13, atol=1e-15 * angle)
    w, x, y, z = turn
    assert_array_equal(rotation_vector((-w, -x, -y, -z)), rotation_vector(turn))  # the same rotation


def test_no_turn_has_no_rotation_vector() -> None:
    assert rotation_vector((1.0, 0.0, 0.0, 0.0)) == (0.0, 0.0, 0.0)
    assert angle_between((1.0, 0.0, 0.0, 0.0), (-1.0, 0.0, 0.0, 0.0)) == 0.0


@given(angles, angles, angles)
def test_roll_pitch_yaw_turn_about_fixed_axes(roll: float, pitch: float, yaw: float) -> None:
    matrix = matrix_of_rpy(roll, pitch, yaw)
    assert_allclose(matrix, Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix(), atol=1e-14)
    near_pole = abs(cos(pitch)) < 1e-3  # roll and yaw come from entries of this size
    assert_allclose(matrix_of_rpy(*rpy_of_matrix(matrix)), matrix, atol=2e-8 if near_pole else 1e-12)


@given(st.sampled_from([-0.5 * pi, 0.5 * pi]), angles, angles)
def test_a_vertical_pitch_keeps_its_matrix(pitch: float, roll: float, yaw: float) -> None:
    matrix = matrix_of_rpy(roll, pitch, yaw)
    assert_allclose(matrix_of_rpy(*rpy_of_matrix(matrix)), matrix, atol=1e-14)


def test_by_hand() -> None:
    quarter = from_axis_angle((0.0, 0.0, 5.0), 0.5 * pi)  # the axis has any length
    assert_allclose(quarter, [cos(pi / 4), 0.0, 0.0, sin(pi / 4)], atol=1e-16)
    assert_allclose(rotate(quarter, (1.0, 0.0, 0.0)), [0.0, 1.0, 0.0], atol=1e-15)
    assert normalised((0.0, 0.0, 0.0, -4.0)) == (0.0, 0.0, 0.0, -1.0)
    with pytest.raises(ZeroDivisionError):
        normalised((0.0, 0.0, 0.0, 0.0))
