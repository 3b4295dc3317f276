"""Errors and Jacobians of goals as planners see them, against finite differences and the environment's own errors."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.planner.actuation import actuation_of
from pytest_lpb.planner.planar_rows import point_on_link
from pytest_lpb.planner.task import Task, damped_inverse
from pytest_lpb.problem.goal import goal_from
from pytest_lpb.problem.planar.robot import PlanarRobot

from .problems import CART, POINT, Array, Entry, arm, observed, problem_of, reach

STEP = 1e-6
ARM = arm(0.6, 0.5, 0.4)


def orientation(link: str, target: float) -> Entry:
    return {"name": "turn", "type": "orientation", "link": link, "target": [target], "tolerance": 0.1}


def joint(*names: str) -> Entry:
    return {"name": "bend", "type": "joint", "joints": list(names), "target": [0.3] * len(names), "tolerance": 0.1}


def alignment(link: str, other: str) -> Entry:
    axes = {"axis": [1.0, 0.5], "other_axis": [-0.2, 1.0]}
    return {"name": "level", "type": "alignment", "link": link, "other": other, "tolerance": 0.1, **axes}


CASES: dict[str, tuple[Entry, list[Entry]]] = {
    "point": (POINT, [reach("body", 1.0, 0.5)]),
    "point_axis": (POINT, [reach("body", 0.5, axes=[1])]),
    "point_joints": (POINT, [joint("y", "x")]),
    "arm_position": (ARM, [reach("end", 0.6, 0.4)]),
    "arm_weighted": (ARM, [reach("end", 0.6, 0.4, weight=2.5)]),
    "arm_point_on_link": (ARM, [reach("link2", 0.6, 0.4, point=[0.2, -0.1])]),
    "arm_axis": (ARM, [reach("end", 0.4, axes=[0])]),
    "arm_relative": (ARM, [reach("end", 0.3, 0.1, relative_to="link2")]),
    "arm_relative_axis": (ARM, [reach("end", 0.3, relative_to="link2", axes=[1], point=[0.1, 0.0])]),
    "arm_orientation": (ARM, [orientation("link3", 0.7)]),
    "arm_alignment_world": (ARM, [alignment("link2", "world")]),
    "arm_alignment_link": (ARM, [alignment("end", "link1")]),
    "arm_joints": (ARM, [joint("joint3", "joint1")]),
    "arm_composed": (ARM, [reach("end", 0.6, 0.4), orientation("end", 0.2) | {"weight": 0.5}, joint("joint2")]),
    "cart_orientation": (CART, [orientation("base", 0.7)]),
    "cart_heading_joint": (CART, [joint("theta")]),
}  # fmt: skip


def states(robot: Entry) -> Array:
    size = 3 if robot is CART else len(robot.get("links", (0, 0)))
    return np.random.default_rng(1).uniform(-1.4, 1.4, (6, size))


@pytest.mark.parametrize("case", CASES)
def test_jacobian_is_minus_the_error_s_slope(case: str) -> None:
    robot, goal = CASES[case]
    problem = problem_of(robot, goal)
    task = Task(problem, lookahead=0.3)
    targets = {item["name"]: item.get("target", [0.0]) for item in goal}
    for q in states(robot):
        error, jacobian = task.error(observed(problem, q, targets=targets))
        assert error.shape == (len(jacobian),)
        moves = problem.robot.action_map(q).T
        assert jacobian.shape == (len(error), len(moves))
        for column, move in zip(jacobian.T, moves, strict=True):
            ahead, _ = task.error(observed(problem, q + STEP * move, targets=targets))
            behind, _ = task.error(observed(problem, q - STEP * move, targets=targets))
            assert column == pytest.approx((behind - ahead) / (2.0 * STEP), abs=1e-8)


@pytest.mark.parametrize("case", [*CASES, "cart_position"])
def test_error_is_what_the_environment_measures(case: str) -> None:
    robot, goal = CASES.get(case, (CART, [reach("base", 1.0, 0.5)]))
    problem = problem_of(robot, [{**item, "weight": 1.0} for item in goal])
    assert isinstance(problem.robot, PlanarRobot)
    task = Task(problem, lookahead=0.3)
    targets = {item["name"]: item.get("target", [0.0]) for item in goal}
    sub_goals = goal_from(goal, problem.robot)
    for q in states(robot):
        error, _ = task.error(observed(problem, q, targets=targets))
        frames = problem.robot.frames(q.tolist())
        for sub_goal, (rows, _) in zip(sub_goals, task.blocks, strict=True):
            expected = sub_goal.distance(sub_goal.value(q.tolist(), frames), targets[sub_goal.name])
            part = np.abs(error[rows])
            measured = np.max(part) if sub_goal.type == "joint" else np.linalg.norm(part)
            assert measured == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("lookahead", [0.05, 0.3])
def test_a_cart_s_jacobian_is_that_of_the_point_ahead(lookahead: float) -> None:
    robot = problem_of(CART, [reach("base", 0, 0)]).robot
    actuation = actuation_of(robot, "acceleration", 0.05, lookahead)
    for q in states(CART):
        jacobian = actuation.per_input(robot.jacobian(q, "base")[:2], q)
        for column, move in zip(jacobian.T, robot.action_map(q).T, strict=True):
            ahead, _ = point_on_link(robot, "base", (lookahead, 0.0), q + STEP * move)
            behind, _ = point_on_link(robot, "base", (lookahead, 0.0), q - STEP * move)
            assert column == pytest.approx((ahead - behind) / (2.0 * STEP), abs=1e-8)
        assert np.linalg.det(jacobian) == pytest.approx(lookahead)  # it can move in any direction


@pytest.mark.parametrize(("distance", "lookahead"), [(0.0, 0.05), (0.06, 0.05), (0.2, 0.1), (0.6, 0.3), (5.0, 0.3)])
def test_lookahead_is_half_the_distance_within_bounds(distance: float, lookahead: float) -> None:
    actuation = actuation_of(problem_of(CART, [reach("base", 0, 0)]).robot, "acceleration", 0.05, 0.3)
    assert actuation.lookahead_at(np.array([0.6 * distance, -0.8 * distance])) == pytest.approx(lookahead)


def test_target_velocities_are_stacked_and_weighted() -> None:
    goal = [reach("end", 0.6, 0.4, weight=2.0), orientation("end", 0.2)]
    problem = problem_of(ARM, goal)
    observation = observed(problem, [0, 0, 0], velocities={"reach": [0.1, -0.2], "turn": [0.3]})
    assert Task(problem, 0.3).target_velocity(observation).tolist() == [0.2, -0.4, 0.3]


@pytest.mark.parametrize(
    ("goal", "direct"),
    [
        ([reach("body", 1, 1)], True),
        ([reach("body", 1, 1, weight=2.0)], False),
        ([reach("body", 1, axes=[0])], False),
        ([reach("body", 1, 1), joint("x")], False),
    ],
)
def test_a_plain_point_needs_no_jacobian(goal: list[Entry], direct: bool) -> None:
    assert Task(problem_of(POINT, goal), 0.3).direct is direct


@given(st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6), st.floats(1e-3, 1.0))
def test_damped_inverse_is_bounded_and_solves_the_damped_normal_equations(entries: list[float], damping: float) -> None:
    jacobian = np.array(entries).reshape(2, 3)
    inverse = damped_inverse(jacobian, damping)
    assert np.linalg.norm(inverse, 2) <= 0.5 / damping * (1.0 + 1e-6)
    square = jacobian @ jacobian.T + damping**2 * np.eye(2)
    assert inverse @ square == pytest.approx(jacobian.T, abs=1e-6)
