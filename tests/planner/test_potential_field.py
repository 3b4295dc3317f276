"""Khatib's potential field: forces by hand and as slopes of the potential, and what they make robots do."""

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pytest_lpb.planner.potential_field import PotentialField, firas

from .problems import CART, POINT, Array, Entry, arm, circle, observed, problem_of, reach, ready, rectangle

ETA, RHO_0 = 0.01, 0.4
TINY = 1e-6  # regularisation that changes nothing [m]
HERE = [reach("body", 0.0, 0.0)]


def field(**parameters: float) -> PotentialField:
    defaults: dict[str, float] = {"repulsion": ETA, "influence": RHO_0, "regularisation": TINY, "closest": 1e-3}
    return PotentialField(PotentialField.Parameters(**{**defaults, **parameters}))


def potential(rho: float) -> float:
    return 0.5 * ETA * (1.0 / rho - 1.0 / RHO_0) ** 2 if rho < RHO_0 else 0.0


@pytest.mark.parametrize(
    ("rho", "push"), [(0.1, 7.5), (0.2, 0.625), (0.25, 0.24), (0.4, 0.0), (0.5, 0.0), (0.05, 70.0)]
)
def test_firas_by_hand(rho: float, push: float) -> None:
    assert firas(np.array([rho]), ETA, RHO_0)[0] == pytest.approx(push, abs=1e-12)


@given(st.floats(0.02, 0.6))
def test_firas_is_minus_the_potential_s_slope(rho: float) -> None:
    assume(abs(rho - RHO_0) > 1e-4)
    step = 1e-6
    slope = (potential(rho + step) - potential(rho - step)) / (2.0 * step)
    assert firas(np.array([rho]), ETA, RHO_0)[0] == pytest.approx(-slope, rel=1e-5, abs=1e-8)


def act(planner: PotentialField, robot: Entry, goal: list[Entry], q: Any, u: Any = None, **others: Any) -> Array:
    """The action at a state; `obstacles`, `targets`, `velocities` go to the observation, others to the problem."""
    seen = {key: others.pop(key) for key in ("targets", "velocities") if key in others}
    obstacles = others.pop("obstacles", [])
    problem = problem_of(robot, goal, obstacles, **others)
    return ready(planner, problem).compute_action(observed(problem, q, u, obstacles=obstacles, **seen))


def test_a_point_is_pushed_off_a_disc_as_computed_by_hand() -> None:
    # 0.1 m of air between a disc of 0.5 m and a body of 0.2 m; the point rests at its goal.
    action = act(field(), POINT, HERE, [0.0, 0.0], obstacles=[circle(0.8, 0.0, 0.5)])
    assert action == pytest.approx([-7.5, 0.0], abs=1e-6)


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_repulsion_is_the_slope_of_all_potentials(x: float, y: float) -> None:
    obstacles = [circle(0.9, 0.2, 0.3), rectangle(-0.5, -0.6, 0.8, 0.5, 0.4), circle(-0.6, 0.9, 0.2)]
    problem = problem_of(POINT, HERE, obstacles)
    planner = ready(field(), problem)
    assert isinstance(planner, PotentialField)
    assert planner._obstacles is not None

    def total(at: Array) -> float:
        assert planner._obstacles is not None
        seen = observed(problem, at, obstacles=obstacles)
        distance, _ = planner._obstacles.distances(at[None], seen)
        return sum(potential(float(rho) - 0.2) for rho in distance[0])

    q = np.array([x, y])
    distance, _ = planner._obstacles.distances(q[None], observed(problem, q, obstacles=obstacles))
    assume(np.all(distance > 0.25))
    step = 1e-6
    slope = [(total(q + step * axis) - total(q - step * axis)) / (2.0 * step) for axis in np.eye(2)]
    action = planner.compute_action(observed(problem, q, targets={"reach": q}, obstacles=obstacles))
    assert action == pytest.approx(-np.array(slope), rel=1e-4, abs=1e-3)


def test_the_goal_asks_for_no_more_than_its_speed() -> None:
    planner = field(stiffness=4.0, damping=2.0, speed=0.5)
    far = {"targets": {"reach": [30.0, 40.0]}}
    assert act(planner, POINT, HERE, [0, 0], **far) == pytest.approx([2.0 * 0.3, 2.0 * 0.4])
    assert act(planner, POINT, HERE, [0, 0], [0.3, 0.4], **far) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert act(planner, POINT, HERE, [0, 0], control="velocity", **far) == pytest.approx([0.3, 0.4])


def test_near_the_goal_the_attraction_is_a_spring_with_a_damper() -> None:
    action = act(field(stiffness=4.0, damping=3.0), POINT, HERE, [0.05, -0.1], [0.2, 0.1])
    assert action == pytest.approx([-4.0 * 0.05 - 3.0 * 0.2, 4.0 * 0.1 - 3.0 * 0.1])


def test_a_moving_goal_is_followed_without_lag() -> None:
    goal = [{**reach("body"), "trajectory": ["0.5*t", "0"]}]
    del goal[0]["target"]
    action = act(field(), POINT, goal, [0, 0], [0.5, 0.0], velocities={"reach": [0.5, 0.0]})
    assert action == pytest.approx([0.0, 0.0], abs=1e-12)


def test_each_sub_goal_has_a_speed_of_its_own() -> None:
    turn = {"name": "turn", "type": "orientation", "link": "end", "target": [2.0], "tolerance": 0.1}
    robot, q = arm(0.6, 0.5, 0.4), [0.3, 0.4, 0.5]
    goal = [reach("end", 0, 0), turn]
    targets = {"reach": [-9.0, 0.0], "turn": [2.0]}
    problem = problem_of(robot, goal, control="velocity")
    action = ready(field(speed=0.5), problem).compute_action(observed(problem, q, targets=targets))
    moved = problem.robot.jacobian(q, "end") @ action
    assert np.linalg.norm(moved[:2]) == pytest.approx(0.5, rel=1e-3)
    assert moved[2] == pytest.approx(0.5, rel=1e-3)


def test_velocity_control_is_where_damping_balances_the_forces() -> None:
    obstacles = [circle(0.8, 0.0, 0.5), rectangle(0.0, -0.6, 0.4, 0.4, 0.2)]
    others = {"obstacles": obstacles, "targets": {"reach": [0.1, 0.1]}}
    force = act(field(damping=3.0), POINT, HERE, [0, 0], **others)
    assert act(field(damping=3.0), POINT, HERE, [0, 0], control="velocity", **others) == pytest.approx(force / 3.0)


def test_position_limits_push_back_inside() -> None:
    limits = {"position": [[-1.0, 1.0], None]}
    planner = field(limit_repulsion=ETA, limit_influence=RHO_0)
    for q, push in ((-0.9, 7.5), (0.9, -7.5), (0.0, 0.0)):
        action = act(planner, POINT, HERE, [q, 0.0], targets={"reach": [q, 0.0]}, limits=limits)
        assert action == pytest.approx([push, 0.0], abs=1e-9)


def test_the_force_is_bounded_where_an_obstacle_is_touched() -> None:
    obstacles = [circle(0.3, 0.0, 0.5)]
    action = act(field(closest=0.05), POINT, HERE, [0.0, 0.0], obstacles=obstacles)
    assert action == pytest.approx([-70.0, 0.0], abs=1e-3)


def test_an_arm_s_link_is_pushed_by_its_nearest_point() -> None:
    obstacles = [circle(0.3, 0.25, 0.1)]  # above the middle of link 1, 0.1 m of air
    bend = {"name": "bend", "type": "joint", "joints": ["joint1", "joint2"], "target": [0.0, 0.0], "tolerance": 0.1}
    problem = problem_of(arm(0.6, 0.5), [bend], obstacles)
    action = ready(field(spacing=0.1), problem).compute_action(observed(problem, [0, 0], obstacles=obstacles))
    # Link 1 at x = 0.3: J = [[0, 0], [0.3, 0]]. The base (0.2405 m away) cannot move; link 2 is pushed at its joint.
    at_joint = np.hypot(0.3, 0.25) - 0.15
    push = float(firas(np.array([at_joint]), ETA, RHO_0)[0]) * -0.25 / np.hypot(0.3, 0.25)
    assert action == pytest.approx([-7.5 / 0.3 + push / 0.6, 0.0], rel=1e-6)


def test_bodies_of_an_arm_keep_apart() -> None:
    bend = {"name": "bend", "type": "joint", "joints": ["joint1", "joint2", "joint3"], "target": [0.0] * 3}
    q = np.array([0.0, 2.3, 2.3])
    problem = problem_of(arm(0.5, 0.5, 0.5), [{**bend, "tolerance": 0.1}])
    planner = ready(field(spacing=0.05, self_influence=0.3, stiffness=0.0, regularisation=0.1), problem)
    assert isinstance(planner, PotentialField)
    assert planner._own is not None

    def gap(at: Array) -> float:
        assert planner._own is not None
        return float(planner._own.nearest(planner._points.at(at)[0], 0.5)[2].min())

    action = planner.compute_action(observed(problem, q, targets={"bend": q}))
    assert np.abs(action).max() > 0.1
    assert gap(q + 1e-3 * action / np.linalg.norm(action)) > gap(q)


def test_motion_that_the_goal_does_not_see_is_damped() -> None:
    robot, q = arm(0.6, 0.5, 0.4), np.array([0.3, 0.4, 0.5])
    problem = problem_of(robot, [reach("end", 0, 0)])
    end = problem.robot.forward_kinematics(q, "end")[:2, 2]
    jacobian = problem.robot.jacobian(q, "end")[:2]
    unseen = np.linalg.svd(jacobian)[2][2]
    planner = ready(field(joint_damping=3.0), problem)
    action = planner.compute_action(observed(problem, q, unseen, targets={"reach": end}))
    assert action == pytest.approx(-3.0 * unseen, abs=1e-6)


def test_a_cart_brakes_before_an_obstacle_and_turns_from_one_beside() -> None:
    goal, targets = [reach("base", 0, 0)], {"targets": {"reach": [5.0, 0.0]}}
    free = act(field(), CART, goal, [0, 0, 0], **targets)
    ahead = act(field(), CART, goal, [0, 0, 0], obstacles=[circle(0.9, 0.0, 0.3)], **targets)
    left = act(field(), CART, goal, [0, 0, 0], obstacles=[circle(0.5, 0.6, 0.3)], **targets)
    right = act(field(), CART, goal, [0, 0, 0], obstacles=[circle(0.5, -0.6, 0.3)], **targets)
    assert ahead[0] < free[0]
    assert ahead[1] == pytest.approx(0.0, abs=1e-9)
    assert left[1] < -0.1
    assert right == pytest.approx(left * [1, -1], abs=1e-9)


def test_a_robot_without_collision_geometry_meets_nothing() -> None:
    bare = {**POINT, "collision": {"spheres": {}}}
    assert act(field(), bare, HERE, [0.0, 0.0], obstacles=[circle(0.1, 0.0, 0.5)]) == pytest.approx([0.0, 0.0])


def test_obstacles_out_of_reach_change_nothing() -> None:
    far = act(field(), POINT, HERE, [0, 0], obstacles=[circle(2.0, 0.0, 0.5)], targets={"reach": [1.0, 0.0]})
    assert np.array_equal(far, act(field(), POINT, HERE, [0, 0], targets={"reach": [1.0, 0.0]}))


def test_setup_forgets_the_last_trial() -> None:
    obstacles = [circle(0.7, 0.4, 0.2), rectangle(-0.4, 0.6, 0.3, 0.2, 0.5)]
    problem = problem_of(arm(0.6, 0.5, 0.4), [reach("end", 0.5, 0.5)], obstacles)
    other = problem_of(POINT, HERE)
    planner = field()
    states = np.random.default_rng(0).uniform(-1.0, 1.0, (6, 3))

    def run() -> list[Array]:
        planner.setup(problem)
        return [
            planner.compute_action(observed(problem, q, targets={"reach": [0.5, 0.5]}, obstacles=obstacles))
            for q in states
        ]

    first = run()
    planner.setup(other)
    planner.compute_action(observed(other, [0.0, 0.0]))
    assert np.array_equal(first, run())


@pytest.mark.parametrize("control", ["acceleration", "velocity"])
@pytest.mark.parametrize("robot", [POINT, arm(0.6, 0.5, 0.4), CART], ids=["point", "arm", "cart"])
def test_actions_are_finite_even_within_obstacles(robot: Entry, control: str) -> None:
    obstacles = [circle(0.0, 0.0, 0.5), rectangle(0.0, 0.0, 1.0, 1.0, 0.0)]
    link = {"point": "body", "planar_arm": "end", "differential_drive": "base"}[robot["model"]]
    problem = problem_of(robot, [reach(link, 0, 0)], obstacles, control=control)
    action = ready(field(regularisation=0.1), problem).compute_action(
        observed(problem, np.zeros(problem.robot.dof), obstacles=obstacles)
    )
    assert action.shape == (problem.robot.n_actions,)
    assert np.isfinite(action).all()
