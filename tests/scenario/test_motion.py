"""Motions: shapes, splines, and what is refused."""

import pickle
from math import pi
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion import (
    ExpressionMotion,
    FixedMotion,
    Motion,
    NormalisedMotion,
    SplineMotion,
    angle_motion,
    motion_from,
    turning_motion,
)
from pytest_lpb.motion.motion import MAX_CHECKED_TIMES, sampled_times

ROWS = [[1.0, 0.0, 5.0], [2.0, 1.0, 4.0], [4.0, -1.0, 6.0]]
LOOP = [[0.0, 1.0], [1.0, 3.0], [2.5, 0.0], [4.0, 1.0]]
MOTIONS = {
    "fixed": FixedMotion([1.0, 2.0, 3.0]),
    "expressions": ExpressionMotion(["cos(t)", "2"]),
    "spline": SplineMotion(ROWS),
    "loop": SplineMotion(LOOP, periodic=True),
    "normalised": NormalisedMotion(ExpressionMotion(["1 + t", "2 - t**2", "sin(t)", "-3"])),
    "normalised spline": NormalisedMotion(SplineMotion(ROWS)),
    "turn": turning_motion({"axis": [1.0, -2.0, 2.0], "angle": "t**2"}),
    "quaternion": turning_motion([1.0, -1.0, 1.0, 1.0]),
}


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_shapes_and_pickling(motion: Motion) -> None:
    t = np.linspace(0.0, 6.0, 13)
    states = motion.evaluate(t)
    assert [state.shape for state in states] == [(13, motion.size)] * 3
    for state, again in zip(states, pickle.loads(pickle.dumps(motion)).evaluate(t), strict=True):
        assert_array_equal(state, again)
        assert state.dtype == np.float64
        state[:] = 0.0  # the caller's own arrays
    assert_array_equal(motion.evaluate(t)[0], pickle.loads(pickle.dumps(motion)).evaluate(t)[0])


@pytest.mark.parametrize("motion", [motion for motion in MOTIONS.values() if motion.moving])
def test_velocity_and_acceleration_are_derivatives(motion: Motion) -> None:
    t = np.linspace(1.05, 3.95, 30)
    step = 1e-5  # [s]
    position, velocity, acceleration = motion.evaluate(t)
    before, after = motion.evaluate(t - step), motion.evaluate(t + step)
    assert_allclose((after[0] - before[0]) / (2 * step), velocity, atol=1e-6)
    assert_allclose((after[1] - before[1]) / (2 * step), acceleration, atol=1e-4)
    assert np.ptp(position) > 0.0


def test_whether_it_moves() -> None:
    assert [name for name, motion in MOTIONS.items() if not motion.moving] == ["fixed", "quaternion"]
    assert not ExpressionMotion(["1", "2*pi"]).moving
    assert not SplineMotion([[0.0, 1.0], [1.0, 1.0]]).moving


def test_spline_is_clamped_and_held() -> None:
    position, velocity, acceleration = SplineMotion(ROWS).evaluate(np.array([0.0, 1.0, 2.0, 4.0, 9.0]))
    assert_allclose(position, [[0, 5], [0, 5], [1, 4], [-1, 6], [-1, 6]], atol=1e-15)
    assert_allclose(velocity[[0, 1, 3, 4]], 0.0, atol=1e-12)
    assert np.all(np.abs(velocity[2]) > 0.1)
    assert_array_equal(acceleration[[0, 4]], 0.0)


def test_periodic_spline_wraps_and_is_smooth() -> None:
    motion = SplineMotion(LOOP, periodic=True)
    t = np.linspace(0.0, 3.9, 20)
    for state, later, earlier in zip(
        motion.evaluate(t), motion.evaluate(t + 8.0), motion.evaluate(t - 4.0), strict=True
    ):
        assert_allclose(later, state, atol=1e-9)
        assert_allclose(earlier, state, atol=1e-9)
    for before, after in zip(
        motion.evaluate(np.array([4.0 - 1e-9])), motion.evaluate(np.array([4.0 + 1e-9])), strict=True
    ):
        assert_allclose(before, after, atol=1e-6)


@pytest.mark.parametrize(
    ("rows", "periodic", "message"),
    [
        ([[0.0, 1.0]], False, "found 1 rows; a spline needs at least 2"),
        ([[0.0, 1.0], [1.0, 1.0]], True, "found 2 rows; a periodic spline needs at least 3"),
        (
            [[0.0, 1.0], [1.0, 1.0, 2.0]],
            False,
            "row 1 has 3 numbers; every row is [t, x, ...] as long as the first",
        ),
        ([[0.0], [1.0]], False, "row 0 has 1 numbers; every row is [t, x, ...] as long as the first"),
        ([[0.0, 1.0], [0.0, 2.0]], False, "row 1 has the time 0.0, not after 0.0; times must increase"),
        (
            [[0.0, 1.0], [1.0, 3.0], [2.0, 1.5]],
            True,
            "the last row [1.5] differs from the first [1.0]; a periodic spline ends where it begins",
        ),
    ],
)
def test_wrong_splines(rows: list[list[float]], periodic: bool, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        SplineMotion(rows, periodic)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["1", "1/(t - 1)"], "'1/(t - 1)' has the value inf at t = 1 s"),
        (["sqrt(t)"], "'sqrt(t)' has the velocity inf at t = 0 s"),
        (["t**1.5"], "'t**1.5' has the acceleration inf at t = 0 s"),
        (["sqrt(-1 - t)"], "'sqrt(-1 - t)' has the value nan at t = 0 s"),
        (["9**9**9"], "'9**9**9' has the value inf at t = 0 s"),
        (["1e5*exp(t)"], "'1e5*exp(t)' has the value 1.21825e+06 at t = 2.5 s"),
    ],
)
def test_undefined_motions_are_named(texts: list[str], message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        ExpressionMotion(texts).check_finite(sampled_times(0.5, 10))
    bound = "1e+06" if "value" in message else "1e+12"
    assert str(caught.value) == f"{message}; allowed are finite numbers within ±{bound}"


def test_sampled_times_hold_both_ends_and_are_bounded() -> None:
    assert_array_equal(sampled_times(0.25, 4), [0.0, 0.25, 0.5, 0.75, 1.0])
    many = sampled_times(0.001, 1_000_000)
    assert len(many) == MAX_CHECKED_TIMES
    assert (many[0], many[-1]) == (0.0, 1000.0)
    assert np.all(np.diff(many) > 0.0)


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ({"target": [1, 2]}, [1.0, 2.0]),
        ({"target": [1, 2], "trajectory": None}, [1.0, 2.0]),
        ({"trajectory": ["t", "t**2"]}, [0.5, 0.25]),
        ({"spline": [[0, 0, 1], [1, 2, 3]]}, [1.0, 2.0]),
        ({"spline": [[0, 0], [1, 2], [2, 0]], "periodic": True}, [1.0]),
    ],
)
def test_forms_of_a_goal(entry: dict[str, Any], expected: list[float]) -> None:
    position, _, _ = motion_from(entry, key="target").evaluate(np.array([0.5]))
    assert_allclose(position, [expected], atol=1e-12)


@pytest.mark.parametrize("entry", [{}, {"position": [1], "trajectory": ["t"]}, {"target": [1]}])
def test_exactly_one_form(entry: dict[str, Any]) -> None:
    with pytest.raises(ScenarioError, match="of position, trajectory, spline; exactly one is required"):
        motion_from(entry, key="position")


def test_angles() -> None:
    assert not angle_motion(0.3).moving
    position, velocity, _ = angle_motion("2*t").evaluate(np.array([1.0]))
    assert (position[0, 0], velocity[0, 0]) == (2.0, 2.0)


def test_a_normalised_motion_has_length_one_and_moves_across_itself() -> None:
    t = np.linspace(0.0, 4.0, 40)
    for name in ("normalised", "normalised spline", "turn", "quaternion"):
        value, velocity, acceleration = MOTIONS[name].evaluate(t)
        assert_allclose(np.linalg.norm(value, axis=1), 1.0, rtol=1e-15)
        assert_allclose((value * velocity).sum(axis=1), 0.0, atol=1e-12)
        # The second derivative of |n|^2 = 1.
        assert_allclose((value * acceleration + velocity * velocity).sum(axis=1), 0.0, atol=1e-12)


def test_normalising_keeps_the_direction() -> None:
    value, velocity, _ = NormalisedMotion(FixedMotion([3.0, 0.0, -4.0])).evaluate(np.zeros(2))
    assert_allclose(value, [[0.6, 0.0, -0.8]] * 2, rtol=1e-15)
    assert_array_equal(velocity, np.zeros((2, 3)))


def test_what_passes_through_zero_has_no_direction_there() -> None:
    through = NormalisedMotion(ExpressionMotion(["1 - t", "0"]))
    assert_allclose(through.evaluate(np.array([0.5, 1.5]))[0], [[1.0, 0.0], [-1.0, 0.0]])
    with pytest.raises(ScenarioError, match=r"^'1 - t' has the value nan at t = 1 s"):
        through.check_finite(sampled_times(0.5, 10))


@pytest.mark.parametrize("angle", [0.0, 0.7, pi, -2.0, 5.0 * pi])
def test_a_turn_about_an_axis(angle: float) -> None:
    turn = turning_motion({"axis": [0.0, 3.0, -4.0], "angle": angle})
    assert not turn.moving
    value, velocity, acceleration = turn.evaluate(np.array([0.0, 2.0]))
    half = 0.5 * angle
    assert_allclose(value, [[np.cos(half), 0.0, 0.6 * np.sin(half), -0.8 * np.sin(half)]] * 2, atol=1e-15)
    assert not velocity.any()
    assert not acceleration.any()


def test_an_axis_has_a_direction() -> None:
    with pytest.raises(ScenarioError, match="zeros"):
        turning_motion({"axis": [0.0, 0.0, 0.0], "angle": "t"})


def test_a_wrong_angle_of_a_turn_is_named_as_written() -> None:
    turn = turning_motion({"axis": [0.0, 0.0, 1.0], "angle": "1/(t - 1)"})
    with pytest.raises(ScenarioError, match=r"^'1/\(t - 1\)' has the value nan at t = 1 s"):
        turn.check_finite(sampled_times(0.5, 10))


SPEEDS = {
    **MOTIONS,
    "products": ExpressionMotion(["t*sin(5*t) - cos(t)/(2 + t)", "exp(-t)*tan(t/4)"]),
    "powers": ExpressionMotion(["(t - 2)**3 + (t - 3)**2", "t**0.5 + (1 + t)**-2", "2**t - t**(t/3)"]),
    "kinks": ExpressionMotion(["abs(t - 2.3) + sqrt(1 + abs(sin(3*t)))", "abs(abs(t - 3) - 1)"]),
}
del SPEEDS["normalised"], SPEEDS["normalised spline"]  # no obstacle moves like that


@pytest.mark.parametrize("motion", SPEEDS.values(), ids=SPEEDS)
@pytest.mark.parametrize("length", [0.01, 0.3])
def test_speeds_stay_within_their_bounds(motion: Motion, length: float) -> None:
    """Between any two times of a span a motion gets no farther than its bound; and those of short spans are tight."""
    start = np.arange(0.5, 5.5, length)
    bound = motion.speed_bound(start, start + length)
    assert bound.shape == start.shape
    inside = start[:, None] + length * np.linspace(0.0, 1.0, 41)
    points = motion.evaluate(inside.ravel())[0].reshape(*inside.shape, -1)
    speed = np.linalg.norm(np.diff(points, axis=1), axis=2).max(axis=1) / (length / 40)
    assert (speed <= bound * (1 + 1e-9) + 1e-9).all()
    if length < 0.1:
        assert np.median(bound - 1.1 * speed) < 0.01


@pytest.mark.parametrize("text", ["1/(t - 2)", "sqrt(abs(t - 2))", "tan(pi*t/4)", "abs(t - 2)**0.3", "(t - 2)**-1"])
def test_poles_have_no_bound(text: str) -> None:
    bound = ExpressionMotion([text]).speed_bound(np.array([0.1, 1.99]), np.array([0.2, 2.01]))
    assert np.isfinite(bound[0])
    assert np.isinf(bound[1])
