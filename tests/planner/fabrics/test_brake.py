"""The brake: no distance shrinks by more than itself, less the margin, over the brake's time; all else stays."""

from __future__ import annotations

from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.planner.fabrics.brake import Damping
from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.fabrics.planner import _composed_for
from tests.planner import problems
from tests.planner.scene.making import Array, Entry, act, goal, obstacle, planar, problem_of

PERIOD, BRAKE = 0.05, 0.4  # [s]
POINT = planar(problems.POINT)  # a disc of 0.2 m
ARM = planar(problems.arm(0.6, 0.5), limits={"position": [[-1.0, 1.0]] * 2})


def after(robot: Entry, q: list[float], u: list[float], goals: list[Entry], *things: Entry, **parameters: Any) -> Array:
    """The inputs' velocity after a period."""
    return np.array(u) + PERIOD * act(robot, q, u, goals, things, period=PERIOD, **parameters)


def along(distance: float, rate: float, own: float = 0.0, mobility: float = 1.0, horizon: float = 2.0) -> Damping:
    jacobian = casadi.DM([[0.6, 0.8]]) * np.sqrt(mobility)
    return Damping.along(distance, jacobian, rate, own, mobility, horizon)


@pytest.mark.parametrize("mobility", [0.04, 1.0, 25.0])
@pytest.mark.parametrize(("wanted", "left"), [(-0.2, -0.2), (0.0, 0.0), (0.7, 0.7), (-0.5, -0.25), (-4.0, -0.25)])
def test_a_distance_of_half_a_metre_shrinks_by_a_quarter_of_a_metre_per_second(
    wanted: float, left: float, mobility: float
) -> None:
    # x / T = 0.5 / 2; along (0.6, 0.8), whatever the velocity across.
    scale = np.sqrt(mobility)
    velocity = wanted / scale * np.array([0.6, 0.8]) + 0.3 * np.array([-0.8, 0.6])
    damping = along(0.5, wanted, mobility=mobility)
    found = np.array(casadi.evalf(damping.velocity(casadi.SX(casadi.DM(velocity))))).ravel()
    assert scale * found @ [0.6, 0.8] == pytest.approx(left, abs=1e-4)
    assert found @ [-0.8, 0.6] == pytest.approx(0.3, abs=1e-9)


def test_distances_of_zero_stop_what_approaches() -> None:
    damping = along(-0.1, -1.0)
    found = np.array(casadi.evalf(damping.velocity(casadi.SX(casadi.DM([-0.6, -0.8]))))).ravel()
    assert found == pytest.approx([0.0, 0.0], abs=1e-5)


@given(st.floats(0.05, 1.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-1.0, 1.0))
def test_what_moves_towards_a_robot_is_made_way_for(distance: float, first: float, second: float, own: float) -> None:
    # The distance's rate is J w + own; it is to be x / T at most, also where the robot must move back for that.
    wanted = 0.6 * first + 0.8 * second + own
    damping = along(distance, wanted, own)
    found = np.array(casadi.evalf(damping.velocity(casadi.SX(casadi.DM([first, second]))))).ravel()
    assert found @ [0.6, 0.8] + own == pytest.approx(max(wanted, -distance / 2.0), abs=1e-4)


@pytest.mark.parametrize("distance", ["relative", "metric"])
@pytest.mark.parametrize(("margin", "left"), [(0.0, 0.25), (0.04, 0.15)])
def test_a_point_comes_no_nearer_to_a_disc_than_the_brake_lets_it(distance: str, margin: float, left: float) -> None:
    # 0.1 m of air, T = 0.4 s: 0.25 m/s towards it. Across, it moves as it would.
    disc, goals = obstacle("circle", [0.6, 0.0], radius=0.3), [goal("position", [2.0, 0.0], link="body")]
    told: Entry = {"distance": distance, "obstacle_geometry": "none"}
    free = after(POINT, [0, 0], [0.8, 0.3], goals, disc, **told)
    found = after(POINT, [0, 0], [0.8, 0.3], goals, disc, brake=BRAKE, margin=margin, **told)
    assert free[0] > 0.5
    assert found == pytest.approx([left, free[1]], abs=1e-4)


def test_what_is_left_behind_is_not_braked() -> None:
    disc, goals = obstacle("circle", [-0.6, 0.0], radius=0.3), [goal("position", [2.0, 0.0], link="body")]
    free = after(POINT, [0, 0], [0.8, 0.3], goals, disc)
    assert after(POINT, [0, 0], [0.8, 0.3], goals, disc, brake=BRAKE) == pytest.approx(free, abs=1e-9)


def test_the_brake_reckons_with_the_velocity_of_what_approaches() -> None:
    goals = [goal("position", [0.0, 0.0], link="body")]
    coming = obstacle("circle", [0.6, 0.0], radius=0.3, velocity=[-0.7, 0.0])
    told: Entry = {"brake": BRAKE, "obstacle_geometry": "none", "distance": "metric"}
    # 0.25 m/s of approach are left: at 0.45 m/s it goes out of its way.
    assert after(POINT, [0, 0], [0.0, 0.0], goals, coming, **told)[0] == pytest.approx(-0.45, abs=1e-4)
    unseen = after(POINT, [0, 0], [0.0, 0.0], goals, coming, obstacle_motion=False, **told)
    assert unseen == pytest.approx([0.0, 0.0], abs=1e-9)


def test_joints_are_braked_before_their_limits() -> None:
    goals = [goal("joint", [0.9, 0.0], joints=["joint1", "joint2"])]
    found = after(ARM, [0.9, 0.0], [2.0, 0.5], goals, brake=BRAKE, limit_geometry="none")
    free = after(ARM, [0.9, 0.0], [2.0, 0.5], goals, limit_geometry="none")
    assert found == pytest.approx([0.1 / BRAKE, free[1]], abs=1e-4)


def test_balls_are_braked_before_planes() -> None:
    goals = [goal("position", [0.0, 0.0], link="body")]
    told: Entry = {"planes": ((0.0, 1.0, -0.3),), "plane_geometry": "none"}
    assert after(POINT, [0, 0], [0.0, -1.0], goals, brake=BRAKE, **told)[1] == pytest.approx(-0.1 / BRAKE, abs=1e-4)


def test_bodies_of_a_robot_are_braked_before_each_other() -> None:
    robot = planar(problems.arm(0.5, 0.5, 0.5), self_collision_pairs=[["base", "link3"]])
    names = ["joint1", "joint2", "joint3"]
    # Bent so far that the last link comes back to the base. A geometry of `none` would leave such pairs out.
    q, u = [0.0, 1.8, 1.8], [0.0, 1.5, 1.5]
    goals = [goal("joint", q, joints=names)]
    told: Entry = {"self_collision_geometry": "1e-9 * xdot", "self_collision_reach": 10.0}

    def distance(at: Array) -> float:
        angles = np.cumsum(at)
        joints = np.cumsum(0.5 * np.column_stack([np.cos(angles), np.sin(angles)]), axis=0)
        start, along = joints[1], joints[2] - joints[1]
        share = np.clip(-start @ along / (along @ along), 0.0, 1.0)
        return float(np.linalg.norm(start + share * along)) - 0.1

    def rate(velocity: Array) -> float:
        return (distance(np.array(q) + 1e-6 * velocity) - distance(np.array(q) - 1e-6 * velocity)) / 2e-6

    horizon = 2.0
    assert rate(after(robot, q, u, goals, **told)) < -distance(np.array(q)) / horizon - 0.05
    braked = rate(after(robot, q, u, goals, brake=horizon, **told))
    assert braked == pytest.approx(-distance(np.array(q)) / horizon, abs=1e-4)


def test_no_brake_is_none() -> None:
    disc, goals = obstacle("circle", [0.6, 0.1], radius=0.3), [goal("position", [2.0, 0.0], link="body")]
    plain, weak = (after(POINT, [0, 0], [0.3, 0.3], goals, disc, brake=brake) for brake in (0.0, 1e-6))
    assert weak == pytest.approx(plain, abs=1e-9)


def test_what_is_composed_depends_on_the_period_with_a_brake_only() -> None:
    goals = [goal("position", [2.0, 0.0], link="body")]
    short, long = (problem_of(POINT, goals, period=period) for period in (0.05, 0.1))
    for brake, same in ((0.0, True), (BRAKE, False)):
        parameters = FabricsParameters(brake=brake)
        assert (_composed_for(short, parameters) is _composed_for(long, parameters)) is same
