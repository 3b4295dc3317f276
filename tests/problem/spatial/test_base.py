"""Motion of bases over a step: against closed forms and a general solver."""

from __future__ import annotations

from math import cos, isfinite, pi, sin, tan
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.base import BASES, Base, BicycleBase, FixedBase, HolonomicBase

WHEEL_BASE_M = 0.325
MOVING = [name for name in BASES if name != "fixed"]

speeds = st.floats(-3.0, 3.0, allow_subnormal=False)
steering = st.floats(-0.6, 0.6, allow_subnormal=False)
steps = st.floats(1e-3, 0.2)


def base_of(name: str, control: str = "acceleration", wheel_base: float = WHEEL_BASE_M) -> Base:
    return BASES[name](control, wheel_base)


def drawn(data: st.DataObject, base: Base) -> tuple[list[float], list[float], list[float]]:
    """q, u and an action; the steering angle and its changes are those of a car."""
    q = [data.draw(steering if name == "delta" else speeds) for name in base.joints]
    u, action = ([data.draw(steering if name == "delta_rate" else speeds) for name in base.actions] for _ in range(2))
    return q, u, action


def solved(base: Base, q: list[float], u: list[float], rates: list[float], dt: float) -> FloatArray:
    """The end of the motion under constant rates of u, by a general solver."""

    def rate(t: float, state: FloatArray) -> list[float]:
        return base.joint_velocity(state.tolist(), [ui + ri * t for ui, ri in zip(u, rates, strict=True)])

    solution = solve_ivp(rate, (0.0, dt), q, method="DOP853", rtol=1e-13, atol=1e-14)
    assert solution.success
    end: FloatArray = solution.y[:, -1]
    return end


@pytest.mark.parametrize("name", BASES)
def test_names_and_kinds_belong_together(name: str) -> None:
    base = base_of(name)
    assert len(base.joints) == len(base.kinds)
    assert len(base.actions) == len(base.action_kinds)
    assert set(base.kinds) | set(base.action_kinds) <= {"prismatic", "revolute"}


def test_sizes_of_q_and_u() -> None:
    sizes = {name: (len(BASES[name].joints), len(BASES[name].actions)) for name in BASES}
    assert sizes == {"fixed": (0, 0), "holonomic": (3, 3), "differential_drive": (3, 2), "bicycle": (4, 2)}


@pytest.mark.parametrize("name", MOVING)
@settings(max_examples=30, deadline=None)
@given(data=st.data(), dt=steps)
def test_accelerations_against_a_general_solver(name: str, data: st.DataObject, dt: float) -> None:
    base = base_of(name)
    q, u, action = drawn(data, base)
    after, velocity = base.integrate(q, u, action, dt)
    assert_allclose(after, solved(base, q, u, action, dt), atol=1e-12)
    assert_allclose(velocity, np.array(u) + dt * np.array(action), atol=1e-15)


@pytest.mark.parametrize("name", MOVING)
@settings(max_examples=30, deadline=None)
@given(data=st.data(), dt=steps)
def test_velocities_against_a_general_solver(name: str, data: st.DataObject, dt: float) -> None:
    base = base_of(name, "velocity")
    q, u, action = drawn(data, base)
    after, velocity = base.integrate(q, u, action, dt)
    assert_allclose(after, solved(base, q, action, [0.0] * len(action), dt), atol=1e-12)
    assert velocity == action


@pytest.mark.parametrize("name", BASES)
@pytest.mark.parametrize("control", ["acceleration", "velocity"])
@given(data=st.data(), dt=steps)
def test_one_step_equals_two_halves(name: str, control: str, data: st.DataObject, dt: float) -> None:
    base = base_of(name, control)
    q, u, action = drawn(data, base)
    whole = base.integrate(q, u, action, dt)
    halves = base.integrate(*base.integrate(q, u, action, 0.5 * dt), action, 0.5 * dt)
    assert_allclose(halves[0], whole[0], atol=1e-12)
    assert_allclose(halves[1], whole[1], atol=1e-14)


@pytest.mark.parametrize("name", BASES)
@given(data=st.data())
def test_the_action_map_gives_joint_velocities(name: str, data: st.DataObject) -> None:
    base = base_of(name)
    q, u, _ = drawn(data, base)
    matrix = base.action_map(q)
    assert matrix.shape == (len(base.joints), len(base.actions))
    assert_allclose(matrix @ np.array(u), base.joint_velocity(q, u), atol=1e-15)


@given(steering.filter(lambda angle: abs(angle) > 1e-3), speeds, st.floats(-pi, pi), steps)
def test_a_held_steering_angle_is_an_arc_of_the_rear_axle(delta: float, v: float, heading: float, dt: float) -> None:
    radius = WHEEL_BASE_M / tan(delta)
    turn = v * dt / radius
    (x, y, theta, held), _ = base_of("bicycle", "velocity").integrate(
        [1.0, 2.0, heading, delta], [9.0, 9.0], [v, 0.0], dt
    )
    expected = [
        1.0 + radius * (sin(heading + turn) - sin(heading)),
        2.0 - radius * (cos(heading + turn) - cos(heading)),
        heading + turn,
        delta,
    ]
    assert_allclose([x, y, theta, held], expected, atol=1e-11)  # the circle's radius is up to 325 m


@pytest.mark.parametrize("name", ["differential_drive", "bicycle"])
def test_straight_ahead_by_hand(name: str) -> None:
    base = base_of(name)
    rest = [0.0] * (len(base.joints) - 3)
    after, velocity = base.integrate([1.0, 2.0, 0.5 * pi, *rest], [1.0, 0.0], [2.0, 0.0], 0.5)
    assert_allclose(after, [1.0, 2.75, 0.5 * pi, *rest], atol=1e-15)
    assert velocity == [2.0, 0.0]


def test_a_holonomic_base_moves_in_the_worlds_axes() -> None:
    base = HolonomicBase("acceleration", 0.0)
    after, velocity = base.integrate([1.0, 2.0, 3.0], [1.0, -1.0, 0.0], [0.0, 2.0, 4.0], 0.5)
    assert (after, velocity) == ([1.5, 1.75, 3.5], [1.0, 0.0, 2.0])
    assert_array_equal(base.action_map([1.0, 2.0, 3.0]), np.eye(3))


def test_a_fixed_base_stands() -> None:
    assert FixedBase("acceleration", 0.0).integrate([], [], [], 0.1) == ([], [])


def test_steering_to_the_left_turns_to_the_left() -> None:
    rates = base_of("bicycle", wheel_base=0.5).joint_velocity([0.0, 0.0, 0.0, 0.3], [2.0, 0.1])
    assert_allclose(rates, [2.0, 0.0, 4.0 * tan(0.3), 0.1])


@pytest.mark.parametrize(
    ("q", "u", "action", "dt"),
    [
        ([0.0, 0.0, 0.0, 1.4], [2.0, 0.2], [1.0, 0.5], 0.1),  # close to where the tangent diverges
        ([0.0, 0.0, 1.0, 0.2], [20.0, 0.5], [5.0, 1.0], 0.5),  # tens of radians in one step
        ([0.0, 0.0, 1.0, -0.6], [20.0, 1.0], [5.0, 2.0], 0.5),  # tens of radians in one step
        ([0.0, 0.0, 1.0, 0.0], [0.0, -2.0], [0.0, 4.0], 1.0),  # steering there and back, at rest
        ([0.0, 0.0, 1.0, 0.2], [1.0, -4.0], [-2.0, 16.0], 0.25),
    ],
)
def test_sharp_turns_against_a_general_solver(q: list[float], u: list[float], action: list[float], dt: float) -> None:
    base = base_of("bicycle")
    after, _ = base.integrate(q, u, action, dt)
    assert_allclose(after, solved(base, q, u, action, dt), atol=1e-11)


@pytest.mark.parametrize("control", ["acceleration", "velocity"])
@pytest.mark.parametrize("rate", [40.0, -40.0, 1e300])
def test_steering_across_is_refused_with_the_angle(control: str, rate: float) -> None:
    with pytest.raises(ValueError, match=r"a steering angle of .* rad; allowed are ±1\.5"):
        base_of("bicycle", control).integrate([0.0, 0.0, 0.0, 0.0], [1.0, rate], [1.0, rate], 0.1)


@pytest.mark.parametrize("value", [float("inf"), float("-inf"), float("nan")])
@pytest.mark.parametrize("entry", [0, 1])
def test_what_is_no_number_ends_in_an_error_or_is_seen(value: float, entry: int) -> None:
    """The engine ends trials whose state is not finite; nothing is returned that looks like a state."""
    action = [1.0, 0.1]
    action[entry] = value
    for name in ("differential_drive", "bicycle"):
        base = base_of(name)
        try:
            q, u = base.integrate([0.0] * len(base.joints), [1.0, 0.1], action, 0.1)
        except (OverflowError, ValueError):
            continue
        assert not all(map(isfinite, q + u))


def test_a_diverging_speed_takes_a_bounded_number_of_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Turns that a step cannot resolve must not stop the clock."""
    base = BicycleBase("acceleration", WHEEL_BASE_M)
    calls: list[float] = []
    piece = base._piece

    def counted(*arguments: Any) -> tuple[float, float, float]:
        calls.append(arguments[-1])
        return piece(*arguments)

    monkeypatch.setattr(base, "_piece", counted)
    after, velocity = base.integrate([0.0, 0.0, 0.0, 0.3], [1.0, 0.0], [1e12, 0.0], 0.05)
    assert 1 < len(calls) <= 1000
    assert sum(calls) == pytest.approx(0.05)  # no part of the step is left out
    assert all(map(isfinite, after + velocity))
