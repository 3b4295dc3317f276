"""KPIs on trials in space whose values are known by hand."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.kpis.safety import time_to_collision_min
from pytest_lpb.trajectory import Trajectory

from .test_known_values import BELL_JERK
from .trials import ARM_3D, CART_3D, POINT_3D, REACH, make_problem, make_trial

AHEAD = np.array([2.0, 1.0, 2.0]) / 3.0  # of length one


def ball(position: Any, radius: float = 0.5, **keys: Any) -> dict[str, Any]:
    return {"name": "ball", "shape": "sphere", "radius": radius, "position": np.array(position).tolist(), **keys}


@cache
def straight() -> Trajectory:
    """2 s along AHEAD at 1 m/s, dt = 0.1 s, to a goal 2 m away with tolerance 0.15; an obstacle is 5 m away."""
    problem = make_problem(
        POINT_3D,
        goal=[{**REACH, "target": (2.0 * AHEAD).tolist()}],
        obstacles=[ball(5.0 * AHEAD)],
        safety_margin=2.85,
        limits=[[-1.0, 3.0], [-0.4, math.inf], [-0.3, 3.0]],
    )
    problem.certified_path_length_m = 1.52
    along = np.arange(21)[:, None] * 0.1 * AHEAD
    action = np.tile([1.0, 2.0, 2.0], (21, 1))
    action[10:] = [1.0, 2.0, 4.0]
    return make_trial(problem, along, qd=np.tile(AHEAD, (21, 1)), action=action)


@cache
def helix() -> Trajectory:
    """One turn of radius 0.3 m that climbs 0.4 m per rad."""
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    path = np.column_stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.4 * angle])
    return make_trial(make_problem(POINT_3D, goal=[{**REACH, "target": [0.3, 0.0, 0.0]}]), path)


@cache
def bell() -> Trajectory:
    """4 s along AHEAD at the speed exp(−5 (t − 2)²), dt = 0.02 s."""
    t = np.arange(201) * 0.02
    scale = math.sqrt(math.pi / 20.0)
    along = np.array([scale * math.erf(math.sqrt(5.0) * (s - 2.0)) for s in t.tolist()])
    problem = make_problem(POINT_3D, dt=0.02, goal=[{**REACH, "target": [9.0, 9.0, 9.0]}])
    return make_trial(problem, along[:, None] * AHEAD)


@cache
def arm() -> Trajectory:
    """The first joint turns by 0.3 rad about z in 1 s, the others are raised by 0.4 and lowered by 1.2 rad."""
    goal = {"name": "turn", "type": "orientation", "link": "end", "target": [1.0, 0.0, 0.0, 0.0], "tolerance": 0.2}
    problem = make_problem(ARM_3D, goal=[goal], limits=[[-0.25, 1.0], [-2.0, 0.6], None])
    q = np.linspace(0.0, 1.0, 11)[:, None] * [0.3, 0.4, -1.2]
    return make_trial(problem, np.vstack([q, [0.3, 0.0, 0.0]]))


@cache
def stretched() -> Trajectory:
    """The stretched arm of 1.2 m swings its end on a quarter of a circle, while it lies flat."""
    q = np.linspace(0.0, math.pi / 2.0, 500)[:, None] * [1.0, 0.0, 0.0]
    return make_trial(
        make_problem(ARM_3D, goal=[{**REACH, "link": "end", "target": [0.0, 1.2, 0.0], "tolerance": 0.01}]), q
    )


@cache
def follower() -> Trajectory:
    """A goal at (t, 0, t) and a point at (t, 0, t + 1 − t/2): within 0.501 m from t = 1 s to the end at 2 s."""
    goal = {**REACH, "target": None, "trajectory": ["t", "0", "t"], "tolerance": 0.501}
    t = np.arange(201) * 0.01
    problem = make_problem(POINT_3D, dt=0.01, goal=[goal], hold_time="end", duration=2.0)
    return make_trial(problem, np.column_stack([t, 0.0 * t, t + 1.0 - 0.5 * t]))


KNOWN: list[tuple[str, Callable[[], Trajectory], float, float]] = [
    ("time_to_goal_s", straight, 1.9, 1e-9),
    ("final_goal_distance_m", straight, 0.0, 1e-9),
    ("min_goal_distance_m", helix, 0.0, 1e-9),
    ("final_goal_distance_m", helix, 0.8 * math.pi, 1e-9),
    ("final_goal_error_rad", arm, 0.3, 1e-9),
    ("min_goal_error_rad", arm, 0.0, 1e-9),  # at the start
    ("tracking_error_mean_m", follower, 0.25, 1e-9),
    ("tracking_error_rms_m", follower, math.sqrt(1.0 / 12.0), 1e-4),
    ("spl", straight, 1.52 / 1.9, 1e-9),
    ("path_length_m", straight, 2.0, 1e-9),
    ("path_length_m", helix, math.pi, 1e-3),  # 2 pi sqrt(0.3² + 0.4²)
    ("path_length_m", stretched, 0.6 * math.pi, 1e-5),
    ("path_length_to_goal_m", straight, 1.9, 1e-9),
    ("path_length_ratio", straight, 1.0, 1e-9),
    ("path_length_ratio", stretched, math.pi / math.sqrt(8.0), 0.01),  # a quarter of a circle over its chord
    ("joint_path_length_rad", arm, 1.3 + math.hypot(0.4, 1.2), 1e-9),
    ("joint_path_length_m", straight, 2.0, 1e-9),
    ("clearance_min_m", straight, 2.3, 1e-9),
    ("clearance_mean_m", straight, 3.3, 1e-9),
    ("near_miss_time_s", straight, 0.5, 1e-9),
    ("joint_limit_margin_min_rad", arm, 0.2, 1e-9),  # 0.6 − 0.4; the first joint: 0.25
    ("joint_limit_margin_min_m", straight, 0.3, 1e-9),  # z stays 0.3 above its lower limit
    ("time_to_collision_min_s", straight, 2.3, 1e-9),
    ("jerk_rms_m_per_s3", bell, math.sqrt(BELL_JERK / 4.0), 0.02),
    ("ldj", bell, -math.log(4.0**3 * BELL_JERK), 0.02),
    ("sparc", bell, -1.414, 2e-3),
    ("curvature_max_per_m", helix, 0.3 / 0.25, 1e-3),
    ("curvature_max_per_m", stretched, 1.0 / 1.2, 1e-6),
    ("action_total_variation", straight, 2.0, 1e-9),
    ("action_squared_integral", straight, 10 * 9.0 * 0.1 + 10 * 21.0 * 0.1, 1e-9),
]


@pytest.mark.parametrize(
    ("name", "trial", "value", "tolerance"), KNOWN, ids=[f"{row[0]}-{row[1].__name__}" for row in KNOWN]
)
def test_value_is_the_one_computed_by_hand(
    name: str, trial: Callable[[], Trajectory], value: float, tolerance: float
) -> None:
    (entry,) = load_builtin().select([name])
    assert float(entry(trial())) == pytest.approx(value, abs=tolerance)


def test_every_kpi_that_depends_on_space_has_a_known_value() -> None:
    same_in_both = {"self_clearance_min_m", "saturated_steps", "infeasible_rate"}  # columns as they are
    expected = {entry.name for entry in load_builtin() if entry.group != "user" and not entry.timing}
    assert {row[0] for row in KNOWN} == expected - same_in_both


def time_to_collision(robot: dict[str, Any], q: list[float], qd: list[float], *obstacles: dict[str, Any]) -> float:
    """Of a robot that is at q with qd at 0 and 0.1 s."""
    joint = "x" if robot["base"] != "fixed" else robot["joints"][0]
    goal = {"name": "start", "type": "joint", "joints": [joint], "target": [0.0]}
    problem = make_problem(robot, goal=[goal], obstacles=obstacles)
    dof = problem.robot.dof
    trial = make_trial(problem, np.array([q[:dof]] * 2), qd=np.array([qd[:dof]] * 2))
    return time_to_collision_min(trial)


def test_time_to_collision_takes_the_height_into_account() -> None:
    passing = ball([3.0, 0.0, 0.8], 0.5)  # 0.8 above the path, radii 0.2 and 0.5
    assert math.isnan(time_to_collision(POINT_3D, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], passing))
    grazing = ball([3.0, 0.0, 0.42], 0.5)  # 0.42, 0.56, 0.7
    assert time_to_collision(POINT_3D, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], grazing) == pytest.approx(3.0 - 0.56)


def test_time_to_collision_uses_both_velocities_in_space() -> None:
    falling = {**ball([0.0] * 3, 0.3), "position": None, "trajectory": ["0", "0", "5 - 2*t"]}
    # Rows at 0 and 0.1 s: the ball is at 5 and 4.8, the robot climbs at 1 m/s.
    found = time_to_collision(POINT_3D, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], falling)
    assert found == pytest.approx((4.8 - 0.5) / 3.0)


def test_time_to_collision_of_coordinates_that_are_turned_and_shifted() -> None:
    turned = {"position": [1.0, 2.0, 3.0], "orientation": [0.5, 0.5, 0.5, 0.5]}  # x, y, z of q along y, z, x
    robot = {**POINT_3D, "base_pose": turned}
    ahead = ball([1.0, 7.0, 3.0])  # q = (5, 0, 0)
    assert time_to_collision(robot, [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], ahead) == pytest.approx((4.0 - 0.7) / 2.0)


def test_time_to_collision_of_a_base_meets_the_section_at_its_height() -> None:
    """The cart is 0.3 m high and 0.4 m wide."""
    ahead, speed = [0.0, 0.0, math.pi / 2.0], [0.0, 2.0, 0.0]
    beside = ball([0.0, 5.0, 0.1])
    assert time_to_collision(CART_3D, ahead, speed, beside) == pytest.approx((5.0 - 0.7) / 2.0)
    above = ball([0.0, 5.0, 0.6])  # 0.3 above the cart: 0.3, 0.4, 0.5
    assert time_to_collision(CART_3D, ahead, speed, above) == pytest.approx((5.0 - 0.6) / 2.0)
    beneath = ball([0.0, 5.0, -0.3])
    assert time_to_collision(CART_3D, ahead, speed, beneath) == pytest.approx((5.0 - 0.6) / 2.0)
    over_it = ball([0.0, 0.0, 0.9])
    assert math.isnan(time_to_collision(CART_3D, ahead, speed, over_it))
    assert time_to_collision(CART_3D, ahead, speed, ball([0.0, 0.0, 0.7])) == 0.0


@pytest.mark.parametrize("heading", [0.0, math.pi / 2.0, -0.6])
def test_time_to_collision_of_a_ball_beside_the_middle_of_a_turning_base(heading: float) -> None:
    robot = {**CART_3D, "collision": {"spheres": {"base": [[0.5, 0.0, 0.1, 0.2]]}}}
    c, s = math.cos(heading), math.sin(heading)
    target = ball([1.0 + 0.5 * c - 4.0 * s, 2.0 + 0.5 * s + 4.0 * c, 0.1], 0.3)
    # Turning on the spot at 2 rad/s takes the ball, half a metre ahead, to the left at 1 m/s.
    found = time_to_collision(robot, [1.0, 2.0, heading], [0.0, 0.0, 2.0], target)
    assert found == pytest.approx(4.0 - 0.5)


@pytest.mark.parametrize(
    "robot",
    [
        ARM_3D,
        {**ARM_3D, "collision": {"spheres": {"end": [[0.0, 0.0, 0.0, 0.1]]}}},
        {**CART_3D, "model": "car", "base": "bicycle", "body_radius": None},
        {**CART_3D, "base_pose": {"position": [0.0, 0.0, 0.5], "orientation": [1.0, 0.5, 0.0, 0.0]}},
        {**ARM_3D, "base": "holonomic", "collision": {"spheres": {"base": [[0.0, 0.0, 0.0, 0.1]]}}},
        {**CART_3D, "collision": {"spheres": {"base": [[0.1, 0.0, 0.0, 0.1], [-0.1, 0.0, 0.0, 0.1]]}}},
    ],
    ids=["arm", "arm with one ball", "box", "leaning cylinder", "arm on a base", "two balls"],
)
def test_time_to_collision_is_for_the_one_round_body_of_points_and_bases(robot: dict[str, Any]) -> None:
    at_rest, towards = [0.0] * 6, [1.0] * 6
    assert math.isnan(time_to_collision(robot, at_rest, towards, ball([0.0, 0.0, 0.0], 0.9)))


def test_time_to_collision_leaves_out_other_shapes_in_space() -> None:
    pillar = {"name": "pillar", "shape": "cylinder", "radius": 0.3, "length": 1.0, "position": [1.0, 0.0, 0.0]}
    box = {"name": "box", "shape": "box", "size": [1.0, 1.0, 1.0], "position": [2.0, 0.0, 0.0]}
    at_rest, speed = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]
    assert math.isnan(time_to_collision(POINT_3D, at_rest, speed, pillar, box))
    assert time_to_collision(POINT_3D, at_rest, speed, pillar, box, ball([4.0, 0.0, 0.0])) == pytest.approx(3.3)
