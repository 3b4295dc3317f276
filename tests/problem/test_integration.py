"""Motion over a step, against closed forms and a general solver."""

from math import cos, hypot, isfinite, pi, sin
from time import perf_counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from pytest_lpb.problem.planar.robot import PlanarRobot

from .entries import ARM, CART, POINT, Entry, make_robot

ROBOTS = {"point": POINT, "arm": ARM, "cart": CART}
speeds = st.floats(-3.0, 3.0, allow_subnormal=False)
steps = st.floats(1e-3, 0.5)


def vectors(size: int) -> st.SearchStrategy[list[float]]:
    return st.lists(speeds, min_size=size, max_size=size)


@pytest.mark.parametrize("entry", [POINT, ARM], ids=["point", "arm"])
@given(data=st.data(), dt=steps)
def test_constant_acceleration_of_joints(entry: Entry, data: st.DataObject, dt: float) -> None:
    robot = make_robot(entry)
    q, u, a = (data.draw(vectors(robot.dof)) for _ in range(3))
    after, velocity = robot.integrate(q, u, a, dt)
    assert_allclose(after, np.polyval([0.5 * np.array(a), np.array(u), np.array(q)], dt), atol=1e-14)
    assert_allclose(velocity, np.array(u) + dt * np.array(a), atol=1e-14)


def test_point_by_hand() -> None:
    after, velocity = make_robot(POINT).integrate([1.0, 2.0], [3.0, -1.0], [2.0, 4.0], 0.5)
    assert (after, velocity) == ([2.75, 2.0], [4.0, 1.0])


@pytest.mark.parametrize("entry", [POINT, ARM], ids=["point", "arm"])
def test_velocity_control_moves_at_the_action(entry: Entry) -> None:
    robot = make_robot(entry, control="velocity")
    action = [1.0, -2.0, 0.5][: robot.dof]
    after, velocity = robot.integrate([0.5] * robot.dof, [9.0] * robot.dof, action, 0.1)
    assert_allclose(after, 0.5 + 0.1 * np.array(action))
    assert velocity == action


@given(speeds, st.floats(0.01, 300.0), st.sampled_from([-1.0, 1.0]), st.floats(-7.0, 7.0), steps)
def test_a_constant_turn_is_an_arc(v: float, rate: float, sense: float, heading: float, dt: float) -> None:
    w, radius = sense * rate, v / (sense * rate)
    (x, y, theta), u = make_robot(CART, control="velocity").integrate([1.0, 2.0, heading], [0.0, 0.0], [v, w], dt)
    centre = (1.0 - radius * sin(heading), 2.0 + radius * cos(heading))
    assert (x, y) == pytest.approx(
        (centre[0] + radius * sin(heading + w * dt), centre[1] - radius * cos(heading + w * dt)), abs=1e-10
    )
    assert hypot(x - centre[0], y - centre[1]) == pytest.approx(abs(radius), abs=1e-10)
    assert theta == pytest.approx(heading + w * dt)  # never wrapped
    assert u == [v, w]


@pytest.mark.parametrize("w", [0.0, 1e-12, 1e-6, 3.9e-3, 4.1e-3, -4.1e-3])
def test_almost_straight_is_almost_straight(w: float) -> None:
    """Around the switch to the series of sin(x)/x: against the arc's series in w."""
    (x, y, _), _ = make_robot(CART, control="velocity").integrate([0.0] * 3, [0.0, 0.0], [2.0, w], 0.05)
    turn = 0.05 * w
    assert x == pytest.approx(0.1 * (1.0 - turn**2 / 6.0), rel=1e-14)
    assert y == pytest.approx(0.1 * (turn / 2.0 - turn**3 / 24.0), rel=1e-12, abs=1e-18)


def test_a_full_circle_comes_back() -> None:
    q = [0.0, 0.0, 0.0]
    robot = make_robot(CART, control="velocity")
    for _ in range(100):
        q, _ = robot.integrate(q, [0.0, 0.0], [1.0, 2.0 * pi], 0.01)
    assert q == pytest.approx([0.0, 0.0, 2.0 * pi], abs=1e-12)


def reference(robot: PlanarRobot, q: list[float], u: list[float], a: list[float], dt: float) -> NDArray[np.float64]:
    def rate(t: float, state: NDArray[np.float64]) -> list[float]:
        return robot.joint_velocity(state.tolist(), [u[0] + a[0] * t, u[1] + a[1] * t])

    solution = solve_ivp(rate, (0.0, dt), q, method="DOP853", rtol=1e-12, atol=1e-13)
    assert solution.success
    end: NDArray[np.float64] = solution.y[:, -1]
    return end


@settings(max_examples=30)
@given(vectors(3), vectors(2), vectors(2), steps)
def test_accelerations_against_a_general_solver(q: list[float], u: list[float], a: list[float], dt: float) -> None:
    robot = make_robot(CART)
    after, velocity = robot.integrate(q, u, a, dt)
    assert_allclose(after, reference(robot, q, u, a, dt), atol=1e-9)
    assert_allclose(velocity, [u[0] + a[0] * dt, u[1] + a[1] * dt])


@pytest.mark.parametrize(
    ("u", "a"), [([2.0, 40.0], [1.0, -300.0]), ([-1.0, 0.0], [5.0, 400.0]), ([0.0, -80.0], [3.0, 320.0])]
)
def test_large_turn_rates_against_a_general_solver(u: list[float], a: list[float]) -> None:
    robot = make_robot(CART)
    after, _ = robot.integrate([0.5, -1.0, 2.0], u, a, 0.5)
    assert_allclose(after, reference(robot, [0.5, -1.0, 2.0], u, a, 0.5), atol=1e-9)


@given(vectors(3), vectors(2), st.floats(1e-3, 0.2))
def test_a_vanishing_acceleration_is_an_arc(q: list[float], u: list[float], dt: float) -> None:
    """The two formulas agree: quadrature for accelerations, chords for constant velocities."""
    robot = make_robot(CART)
    straight, _ = robot.integrate(q, u, [0.0, 0.0], dt)
    bent, _ = robot.integrate(q, u, [1e-300, 1e-300], dt)
    assert_allclose(bent, straight, atol=1e-13)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("control", ["acceleration", "velocity"])
@given(data=st.data(), dt=steps)
def test_one_step_equals_two_halves(name: str, control: str, data: st.DataObject, dt: float) -> None:
    robot = make_robot(ROBOTS[name], control=control)
    q = data.draw(vectors(robot.dof))
    u, action = data.draw(vectors(robot.n_actions)), data.draw(vectors(robot.n_actions))
    whole = robot.integrate(q, u, action, dt)
    halves = robot.integrate(*robot.integrate(q, u, action, 0.5 * dt), action, 0.5 * dt)
    assert_allclose(halves[0], whole[0], atol=1e-12)
    assert_allclose(halves[1], whole[1], atol=1e-12)


def test_a_diverging_turn_rate_does_not_stop_the_clock() -> None:
    started = perf_counter()
    after, _ = make_robot(CART).integrate([0.0, 0.0, 0.0], [1.0, 0.0], [0.0, 1e12], 0.05)
    assert perf_counter() - started < 5.0  # it took hours when every turn was resolved
    assert all(map(isfinite, after))
    assert hypot(after[0], after[1]) <= 0.05 + 1e-9  # no farther than the way driven


def test_wheel_speeds() -> None:
    robot = make_robot(CART)
    left, right = robot.wheel_speeds([1.0, 2.0])  # type: ignore[attr-defined] # of the cart only
    assert (left, right) == (0.5, 1.5)
