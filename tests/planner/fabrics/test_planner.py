"""The planner: by hand where possible; what is composed anew; obstacles that move, planes, meshes; every robot."""

from __future__ import annotations

import shutil
from math import exp, sqrt, tanh
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.base import PlannerProblem
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.fabrics.composition import Composer
from pytest_lpb.planner.fabrics.observed import obstacle_fills
from pytest_lpb.planner.fabrics.parameters import NAMED, FabricsParameters
from pytest_lpb.planner.fabrics.planner import Fabrics, _composed_for
from pytest_lpb.planner.files import find_planners
from pytest_lpb.planner.scene.layout import capacities
from pytest_lpb.planner.scene.meshes import SPACING_M
from pytest_lpb.planner.scene.shapes import MESH
from pytest_lpb.problem.robot import robot_from
from pytest_lpb.problem.spatial.meshes import surface_sample
from pytest_lpb.problem.spatial.triangles import mesh_triangles
from pytest_lpb.symbolic.buffered import BufferedFunction
from tests.planner import problems
from tests.planner.scene.making import (
    Array,
    Entry,
    act,
    goal,
    observed,
    obstacle,
    obstacle_info,
    planar,
    problem_of,
    ready,
    spatial,
)
from tests.problem.spatial.robots import ARM as SPATIAL_ARM
from tests.problem.spatial.robots import ENTRIES
from tests.problem.spatial.robots import POINT as SPATIAL_POINT

POINT = planar(problems.POINT)
ARM = planar(
    problems.arm(0.6, 0.5, 0.4), limits={"position": [[-2.8, 2.8]] * 3}, self_collision_pairs=[["base", "link3"]]
)
CART = planar(problems.CART)
HERE = [goal("position", [0.0, 0.0], link="body")]
TIP = [goal("position", [0.5, 0.8], link="end")]
RING = str(Path(__file__).parents[3] / "scenarios" / "meshes" / "ring.obj")
COMPILER = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)


def discs(count: int, **entry: Any) -> list[Entry]:
    """Discs around the origin, 1.5 m away."""
    angles = np.linspace(0.3, 5.0, count)
    return [
        obstacle("circle", [1.5 * np.cos(angle), 1.5 * np.sin(angle)], radius=0.2, name=f"disc{index}", **entry)
        for index, angle in enumerate(angles)
    ]


# By hand

MET = 0.5 * 6.5 * (tanh(0.5 * 0.02) + 1.0) + 0.01  # [1/s] damping where the goal is met


def test_a_point_at_rest_is_pulled_to_its_goal_as_computed_by_hand() -> None:
    # 0.5 m away: attractor metric m, slope s; base metric 0.2.
    mass = 2.0 * (1.7 * exp(-(0.375**2)) + 0.3)
    slope = 5.0 * (1.0 - 2.0 / (1.0 + exp(10.0)))
    pull = mass * slope / (0.2 + mass + 1e-6)
    assert act(POINT, [0.3, -0.4], [0, 0], HERE) == pytest.approx([-0.6 * pull, 0.8 * pull], abs=1e-9)


def test_a_point_at_its_goal_is_damped_as_computed_by_hand() -> None:
    assert act(POINT, [0, 0], [0.3, -0.2], HERE) == pytest.approx([-0.3 * MET, 0.2 * MET], abs=1e-9)


def test_a_point_follows_a_moving_goal_as_computed_by_hand() -> None:
    # The attractor's metric is 4 there, the base's 0.2: both velocity and acceleration are followed by 4 / 4.2.
    moving = [goal("position", [0.0, 0.0], link="body", velocity=[0.5, 0.0], acceleration=[0.1, 0.3])]
    share = 4.0 / (4.2 + 1e-6)
    expected = share * np.array([0.1, 0.3]) + MET * share * np.array([0.5, 0.0])
    assert act(POINT, [0, 0], [0, 0], moving) == pytest.approx(expected, abs=1e-9)


def test_damping_is_by_the_distance_to_sub_goals_with_a_tolerance() -> None:
    # The other sub-goal is 3 m away, and of hardly any weight: it pulls at nothing.
    other: Entry = {"name": "other", "joints": ["x"], "weight": 1e-12}
    wish = [*HERE, goal("joint", [3.0], tolerance=None, **other)]
    must = [*HERE, goal("joint", [3.0], tolerance=0.1, **other)]
    near = 0.5 * 6.5 * (tanh(-0.5 * (3.0 - 0.02)) + 1.0) + 0.01
    assert act(POINT, [0, 0], [0.3, -0.2], wish) == pytest.approx([-0.3 * MET, 0.2 * MET], abs=1e-9)
    assert act(POINT, [0, 0], [0.3, -0.2], must) == pytest.approx([-0.3 * near, 0.2 * near], abs=1e-9)


def test_sub_goals_of_no_weight_count_for_nothing() -> None:
    moving = goal("joint", [3.0], joints=["x"], weight=0.0, name="other", velocity=[1.0])
    alone, both = (act(POINT, [0, 0], [0.3, -0.2], goals) for goals in (HERE, [*HERE, moving]))
    assert both == pytest.approx(alone, abs=1e-12)


def test_sub_goals_pull_by_their_weight() -> None:
    once, twice = ([goal("position", [0.0, 0.0], link="body", weight=weight)] for weight in (1.0, 2.0))
    assert act(POINT, [0.3, -0.4], [0, 0], twice) == pytest.approx(2.0 * act(POINT, [0.3, -0.4], [0, 0], once))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_disc_ahead_turns_a_point_to_the_side_where_the_way_is_shorter(side: float) -> None:
    disc = obstacle("circle", [1.0, -0.05 * side], radius=0.3)
    goals = [goal("position", [2.0, 0.0], link="body")]
    free, turned = (act(POINT, [0.2, 0.0], [0.8, 0.0], goals, things) for things in ([], [disc]))
    assert side * turned[1] > 0.01
    assert free[1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("scale", [0.02, 5.0])
def test_the_largest_acceleration_shortens_actions_and_keeps_their_direction(scale: float) -> None:
    free = act(ARM, [0.2, 0.5, 0.9], [0.3, -0.2, 0.4], TIP, discs(2))
    largest = scale * float(np.linalg.norm(free))
    found = act(ARM, [0.2, 0.5, 0.9], [0.3, -0.2, 0.4], TIP, discs(2), largest_acceleration=largest)
    assert found == pytest.approx(min(scale, 1.0) * free)


def test_limits_of_accelerations_shorten_actions_as_a_whole_where_they_are_respected() -> None:
    free = act(ARM, [0.2, 0.5, 0.9], [0.3, -0.2, 0.4], TIP)
    tight = [[-10.0, 10.0], [-abs(free[1]) / 4.0, abs(free[1]) / 4.0], None]
    limited = {**ARM, "limits": {**ARM["limits"], "acceleration": tight}}
    state = ([0.2, 0.5, 0.9], [0.3, -0.2, 0.4])
    assert act(limited, *state, TIP, respect_limits=True) == pytest.approx(0.25 * free)
    assert act(limited, *state, TIP) == pytest.approx(free, abs=0.0)


# Control


@pytest.mark.parametrize(("robot", "goals"), [(ARM, TIP), (CART, [goal("position", [1.0, 0.4], link="base")])])
def test_under_velocity_control_the_action_is_the_velocity_after_a_period(robot: Entry, goals: list[Entry]) -> None:
    q = [0.2, -0.3, 0.9]
    u = np.array([0.3, -0.2, 0.4])[: 2 if robot is CART else 3]
    acceleration = act(robot, q, u, goals, discs(2))
    for period in (0.05, 0.2):
        velocity = act({**robot, "control": "velocity"}, q, u, goals, discs(2), period=period)
        assert velocity == pytest.approx(u + period * acceleration, abs=1e-12)


def test_torques_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="fabrics gives accelerations or velocities, not torques"):
        Fabrics().setup(problem_of({**ARM, "control": "torque"}, TIP))


# What is composed


def function_of(problem: PlannerProblem, **parameters: Any) -> Any:
    return _composed_for(problem, FabricsParameters(**parameters)).function


def test_problems_of_equal_structure_share_a_composed_function() -> None:
    first = problem_of(ARM, TIP, discs(5))
    other = problem_of(ARM, [goal("position", [-0.2, 0.9], link="end", name="there", tolerance=0.01)], discs(6))
    assert function_of(first) is function_of(other)
    assert function_of(problem_of(ARM, TIP, discs(5), period=0.2)) is function_of(first)


def test_room_for_obstacles_grows_by_at_most_a_half() -> None:
    rooms = [capacities([obstacle_info(disc) for disc in discs(count)]) for count in range(1, 14)]
    assert [room["circle"] for room in rooms] == [1, 2, 3, 4, 6, 6, 8, 8, 12, 12, 12, 12, 16]
    box = obstacle("rectangle", [1.0, 1.0], size=[0.2, 0.2])
    assert capacities([obstacle_info(thing) for thing in [*discs(5), box]]) == {"circle": 6, "rectangle": 1}
    assert capacities([]) == {}


@pytest.mark.parametrize(
    "change",
    [
        {"obstacles": discs(5)},
        {"obstacles": discs(4, velocity=[0.1, 0.0])},
        {"obstacles": [obstacle("rectangle", [1.0, 1.0], size=[0.2, 0.2])]},
        {"robot": {**ARM, "links": [0.6, 0.5, 0.3]}},
        {"robot": {**ARM, "limits": {}}},
        {"goals": [goal("position", [0.5, 0.8], link="link3")]},
        {"goals": [goal("position", [0.5, 0.8], link="end", weight=2.0)]},
        {"goals": [goal("position", [0.5, 0.8], link="end", point=[0.1, 0.0])]},
        {"goals": [goal("position", [0.5, 0.8], link="end", tolerance=None)]},
        {"goals": [*TIP, goal("joint", [0.1], joints=["joint1"], name="bend")]},
    ],
    ids=["room", "motion", "shape", "links", "limits", "link", "weight", "point", "tolerance", "sub-goals"],
)
def test_problems_of_another_structure_do_not(change: Entry) -> None:
    same: Entry = {"robot": ARM, "goals": TIP, "obstacles": discs(4)}
    assert function_of(problem_of(**same)) is not function_of(problem_of(**(same | change)))


def test_parameters_are_part_of_what_is_composed() -> None:
    problem = problem_of(ARM, TIP, discs(4))
    assert function_of(problem, damping_near=3.0) is not function_of(problem)
    assert function_of(problem, obstacle_energy=NAMED["barrier_energy"]) is function_of(problem)


def test_setup_forgets_the_last_trial() -> None:
    moving = discs(6, velocity=[0.3, -0.2])
    trials: list[tuple[Entry, list[Entry], list[Entry], list[float], list[float]]] = [
        (ARM, TIP, moving, [0.2, 0.5, 0.9], [0.3, -0.2, 0.4]),
        (ARM, TIP, discs(6), [0.2, 0.5, 0.9], [0.3, -0.2, 0.4]),
        (ARM, TIP, discs(5), [0.1, 0.7, 0.4], [0.1, 0.3, -0.4]),
        (ARM, TIP, discs(5, velocity=[0.1, 0.1]), [0.1, 0.7, 0.4], [0.1, 0.3, -0.4]),
        (POINT, HERE, discs(1), [0.4, 0.3], [0.1, 0.3]),
        (ARM, TIP, moving, [0.2, 0.5, 0.9], [0.3, -0.2, 0.4]),
    ]
    planner = Fabrics()
    for robot, goals, obstacles, q, u in trials:
        planner.setup(problem_of(robot, goals, obstacles))
        found = planner.compute_action(observed(q, u, goals, obstacles))
        assert np.array_equal(found, act(robot, q, u, goals, obstacles))


def test_planners_of_one_composed_function_do_not_disturb_each_other() -> None:
    one, other = ready(ARM, TIP, discs(5)), ready(ARM, TIP, discs(6))
    state = ([0.2, 0.5, 0.9], [0.3, -0.2, 0.4])
    first = one.compute_action(observed(*state, TIP, discs(5)))
    other.compute_action(observed([0.0, 0.1, 0.2], [0.0, 0.0, 0.1], TIP, discs(6)))
    assert np.array_equal(first, one.compute_action(observed(*state, TIP, discs(5))))


def test_actions_are_the_caller_s_own() -> None:
    planner = ready(ARM, TIP)
    first = planner.compute_action(observed([0.2, 0.5, 0.9], [0.3, -0.2, 0.4], TIP))
    kept = first.copy()
    planner.compute_action(observed([0.3, 0.1, 0.9], [0.1, -0.2, 0.4], TIP))
    assert np.array_equal(first, kept)


# Room for obstacles


def with_room(capacity: int, obstacles: list[Entry]) -> Array:
    """The action of an arm whose fabric has this many slots for discs."""
    problem = problem_of(ARM, TIP, obstacles)
    composer = Composer(problem.robot, problem.goal, {"circle": capacity}, FabricsParameters(), problem.period)
    fabric = BufferedFunction(composer.function())
    seen = observed([0.2, 0.5, 0.9], [0.3, -0.2, 0.4], TIP, obstacles)
    fabric.arguments["q"][:], fabric.arguments["w"][:] = seen["q"], seen["u"]
    fabric.arguments["goal0"][0] = seen["goal_reach"]
    for fill in obstacle_fills(problem.obstacles, fabric.arguments, 2):
        fill(seen)
    fabric()
    return fabric.results["action"].copy()


def test_slots_without_an_obstacle_change_nothing() -> None:
    exact = with_room(5, discs(5))
    for capacity in (6, 8, 16):
        assert with_room(capacity, discs(5)) == pytest.approx(exact, abs=1e-12)
    assert act(ARM, [0.2, 0.5, 0.9], [0.3, -0.2, 0.4], TIP, discs(5)) == pytest.approx(exact, abs=1e-12)
    assert np.abs(with_room(5, discs(4)) - exact).max() > 1e-3  # an obstacle does change something


def test_an_obstacle_very_far_away_is_as_good_as_none() -> None:
    far = obstacle("circle", [1e8, 0.0], radius=0.2, name="far")
    state = ([0.2, 0.5, 0.9], [0.3, -0.2, 0.4])
    assert act(ARM, *state, TIP, [*discs(3), far]) == pytest.approx(act(ARM, *state, TIP, discs(3)), abs=1e-6)


def test_the_order_of_obstacles_does_not_matter() -> None:
    things = [*discs(3), obstacle("rectangle", [0.2, 1.2], size=[0.4, 0.2], orientation=0.4, name="box")]
    things[1] |= {"radius": 0.35, "moving": True, "velocity": [0.4, -0.5]}
    state = ([0.2, 0.5, 0.9], [0.3, -0.2, 0.4])
    expected = act(ARM, *state, TIP, things)
    for order in ([3, 2, 1, 0], [1, 3, 0, 2], [2, 0, 3, 1]):
        assert act(ARM, *state, TIP, [things[index] for index in order]) == pytest.approx(expected, abs=1e-9)


# Obstacles that move. Geometries bend paths, the speed along them is the speed control's: what counts is across.

AHEAD = [goal("position", [2.0, 0.0], link="body")]


def past(velocity: list[float], **entry: Any) -> Array:
    """The action of a point that moves along x, past a disc of this velocity on its left."""
    acceleration = entry.pop("acceleration", [0.0, 0.0])
    disc = obstacle("circle", [0.3, 0.9], radius=0.3, velocity=velocity, acceleration=acceleration)
    return act(POINT, [0.2, 0.0], [0.5, 0.0], AHEAD, [disc], **entry)


def test_obstacles_at_rest_are_the_same_whether_motion_is_seen_or_not() -> None:
    assert past([0.0, 0.0]) == pytest.approx(past([0.0, 0.0], obstacle_motion=False), abs=1e-12)


def test_motion_of_obstacles_is_seen_unless_it_is_not_to_be() -> None:
    unseen = past([0.0, -0.5], obstacle_motion=False)
    assert unseen == pytest.approx(past([0.0, 0.0]), abs=1e-12)
    assert past([0.0, -0.5])[1] < unseen[1] - 0.01  # away from what comes from the left


def test_one_obstacle_that_moves_among_others_is_seen() -> None:
    coming = obstacle("circle", [0.3, 0.9], radius=0.3, velocity=[0.0, -0.5])
    still = obstacle("circle", [0.3, -2.0], radius=0.3, name="other")
    state = ([0.2, 0.0], [0.5, 0.0])
    both = act(POINT, *state, AHEAD, [coming, still])
    assert both[1] < act(POINT, *state, AHEAD, [coming, still], obstacle_motion=False)[1] - 0.01


def test_accelerations_of_obstacles_are_seen() -> None:
    assert past([0.0, 0.0], acceleration=[0.0, -0.5])[1] < past([0.0, 0.0])[1] - 0.001
    unseen = past([0.0, 0.0], acceleration=[0.0, -0.5], obstacle_motion=False)
    assert unseen == pytest.approx(past([0.0, 0.0]), abs=1e-12)


def test_what_moves_along_with_the_robot_is_not_approached() -> None:
    state: tuple[list[float], list[float]] = ([0.2, 0.0], [0.5, 0.1])
    disc = obstacle("circle", [0.8, 0.2], radius=0.3, velocity=state[1])
    along, alone = (act(POINT, *state, AHEAD, [disc], obstacle_geometry=leaf) for leaf in ("barrier", "none"))
    assert along == pytest.approx(alone, abs=1e-9)
    still = {**disc, "velocity": [0.0, 0.0]}
    towards, alone = (act(POINT, *state, AHEAD, [still], obstacle_geometry=leaf) for leaf in ("barrier", "none"))
    assert np.abs(towards - alone).max() > 0.01


# Planes


@pytest.mark.parametrize(("sinking", "pushed"), [(0.1, True), (0.0, False), (-0.1, False)])
def test_a_ball_is_pushed_off_a_plane_that_it_approaches_only(sinking: float, pushed: bool) -> None:
    # At its goal, so that nothing else acts but damping; 0.1 m of air between its body and y >= -2.
    goals, state = [goal("position", [0.0, -1.7], link="body")], ([0.0, -1.7], [0.6, -sinking])
    without, within = (act(POINT, *state, goals, planes=planes) for planes in ((), ((0.0, 3.0, -2.0),)))
    if pushed:
        assert within[1] > without[1] + 0.1
    else:
        assert within == pytest.approx(without, abs=1e-9)


def test_planes_are_met_by_every_ball_of_a_link() -> None:
    # The stretched arm turns down, towards y >= -0.3: its tip moves fastest, and stays behind.
    goals = [goal("joint", [0.0, 0.0, 0.0], joints=["joint1", "joint2", "joint3"])]
    state = ([0.0, 0.0, 0.0], [-0.6, 0.0, 0.0])
    without, within = (act(ARM, *state, goals, planes=planes) for planes in ((), ((0.0, 1.0, -0.3),)))
    assert within[0] > without[0] + 0.1


# Meshes


def ring(position: Any, orientation: list[float], **entry: Any) -> Entry:
    return obstacle(MESH, position, orientation=orientation, file=RING, concave=True, **{"name": "ring", **entry})


BALL = spatial(SPATIAL_POINT, body_radius=0.01)
FREE = [goal("position", [0.5, 0.2, 0.1], link="body")]
SIDEWAYS = [sqrt(0.5), 0.0, sqrt(0.5), 0.0]  # by a right angle about y: the ring's x is -z, its z is x


def as_near_as_it_may_be(ball: list[float], point: list[float], **entry: Any) -> Entry:
    """A point of the mesh, moved to the ball as far as the surface between it and its neighbours may be nearer."""
    _, reach = surface_sample(RING, 1.0, SPACING_M, concave=True)
    offset = np.array(point) - ball
    distance = float(np.linalg.norm(offset))
    share = sqrt(distance**2 - reach**2) / distance
    return obstacle("sphere", np.array(ball) + share * offset, radius=0.0, **entry)


def test_the_surface_between_points_of_a_mesh_is_reckoned_with() -> None:
    points, reach = surface_sample(RING, 1.0, SPACING_M, concave=True)
    assert 0.0 < reach <= SPACING_M / sqrt(3.0) + 1e-9
    triangles = mesh_triangles(Path(RING))
    inside = np.random.default_rng(0).dirichlet([1.0, 1.0, 1.0], len(triangles))
    middles = (triangles * inside[:, :, None]).sum(axis=1)
    gaps = np.array([np.linalg.norm(points - middle, axis=1).min() for middle in middles])
    assert gaps.max() <= reach + 1e-6


def test_a_mesh_repels_like_a_point_where_it_is_nearest() -> None:
    # The hole's radius is 0.22 m. So near to it, the tube is nearest where x meets it.
    q, u = [0.19, 0.0, 0.0], [0.1, 0.3, 0.2]
    near, mesh = as_near_as_it_may_be(q, [0.22, 0.0, 0.0]), ring([0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])
    found = act(BALL, q, u, FREE, [mesh])
    assert found == pytest.approx(act(BALL, q, u, FREE, [near]), abs=1e-6)
    bend = found - act(BALL, q, u, FREE, [mesh], obstacle_geometry="none")
    assert bend @ (np.array([1.0, 0.0, 0.0]) - 0.1 / 0.14 * np.array(u)) < -0.01  # away, as seen across its path


def test_a_mesh_moves_and_turns_with_its_obstacle() -> None:
    q, u, velocity = [1.0, 2.0, 2.81], [0.3, 0.2, -0.1], [0.0, 0.1, 0.2]
    moving: Entry = {"velocity": velocity, "acceleration": [0.0, 0.0, 0.3]}
    near = as_near_as_it_may_be(q, [1.0, 2.0, 2.78], **moving)
    found = act(BALL, q, u, FREE, [ring([1.0, 2.0, 3.0], SIDEWAYS, **moving)])
    assert found == pytest.approx(act(BALL, q, u, FREE, [near]), abs=1e-6)
    assert np.abs(found - act(BALL, q, u, FREE, [ring([1.0, 2.0, 3.0], SIDEWAYS)])).max() > 1e-2


def test_the_order_of_meshes_does_not_matter_nor_does_room_for_more() -> None:
    robot, tip = spatial(SPATIAL_ARM), [goal("position", [0.6, 0.2, 0.5], link="end")]
    q, u = [0.2, -0.4, 0.6], [0.3, -0.5, 0.4]
    rings = [
        ring([0.9, 0.3, 0.3], SIDEWAYS, name="one"),
        ring([0.4, -0.3, 0.5], [1.0, 0.0, 0.0, 0.0], name="two"),
        ring([1e8, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], name="far"),
    ]
    expected = act(robot, q, u, tip, rings[:2])
    assert act(robot, q, u, tip, rings[1::-1]) == pytest.approx(expected, abs=1e-9)
    assert act(robot, q, u, tip, rings) == pytest.approx(expected, abs=1e-6)
    assert np.abs(act(robot, q, u, tip, rings[:1]) - expected).max() > 1e-3


# All robots

THINGS = [
    obstacle("sphere", [1.2, 0.3, 0.4], radius=0.2, name="ball", velocity=[-0.2, 0.0, 0.0]),
    obstacle("box", [-0.9, 0.5, 0.3], size=[0.4, 0.3, 0.6], name="box"),
]
# Robots that have links other than meshes are taken for more than balls.
PLAIN = ["husky", "arm", "cart", "car", "panda on wheels", "arm on a car"]


@pytest.mark.parametrize(
    ("name", "links"), [*((name, "spheres") for name in ENTRIES), *((name, "exact") for name in PLAIN)]
)
def test_every_robot_gets_finite_actions(name: str, links: str) -> None:
    robot = spatial(ENTRIES[name])
    made = robot_from(robot)
    goals = [goal("joint", [0.5], joints=[made.joint_names[0]])]
    generator = np.random.default_rng(0)
    planner = ready(robot, goals, THINGS, links=links)
    for _ in range(3):
        q, u = generator.uniform(-0.5, 0.5, made.dof), generator.uniform(-0.5, 0.5, made.n_actions)
        found = planner.compute_action(observed(q, u, goals, THINGS))
        assert found.shape == (made.n_actions,)
        assert np.isfinite(found).all()
        assert np.abs(found).max() > 1e-3


@pytest.mark.parametrize("robot", [POINT, ARM, CART], ids=["point", "arm", "cart"])
def test_actions_are_finite_even_within_obstacles(robot: Entry) -> None:
    link = {"point": "body", "planar_arm": "end", "differential_drive": "base"}[robot["model"]]
    things = [
        obstacle("circle", [0.0, 0.0], radius=0.5, name="disc"),
        obstacle("rectangle", [0.0, 0.0], size=[1.0, 1.0], name="box"),
    ]
    made = robot_from(robot)
    goals = [goal("position", [0.0, 0.0], link=link)]
    for u in (np.zeros(made.n_actions), np.full(made.n_actions, 0.5)):
        assert np.isfinite(act(robot, np.zeros(made.dof), u, goals, things)).all()


# Compiled, and what parameters may be


@pytest.mark.skipif(COMPILER is None, reason="no C compiler: neither cc nor gcc nor clang")
def test_compiled_fabrics_give_the_same_actions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_LPB_CACHE", str(tmp_path))
    interpreted, compiled = (ready(ARM, TIP, discs(2), compile=flag) for flag in (False, True))
    assert list(tmp_path.glob("*.so"))
    for q, u in np.random.default_rng(0).uniform(-1.0, 1.0, (5, 2, 3)):
        seen = observed(q, u, TIP, discs(2))
        assert compiled.compute_action(seen) == pytest.approx(interpreted.compute_action(seen), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", [name for name in NAMED if name not in ("none", "soft_norm")])
def test_leaves_may_be_given_by_name_or_by_their_text(name: str) -> None:
    field = "obstacle_energy" if "energy" in name or name == "kinetic" else "obstacle_geometry"
    given: list[Entry] = [{field: name}, {field: NAMED[name]}]
    by_name, by_text = (act(POINT, [0.2, 0.0], [0.5, 0.1], AHEAD, discs(2), **leaf) for leaf in given)
    assert np.array_equal(by_name, by_text)


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"obstacle_energy": "0.1 * xdto**2 / x"}, "xdot"),
        ({"attractor_potential": "5 * xdot"}, "xdot"),
        ({"limit_geometry": "__import__('os')"}, "limit_geometry"),
        ({"attractor_energy": "none"}, "no sub-goal would count"),
        ({"attractor_potential": "-x"}, "drive away from the target"),
        ({"obstacle_geometry": "1 / 0"}, "has a value of inf at x = 0.5, xdot = -0.5"),
        ({"limit_geometry": "log(-x)"}, "has a value of nan"),
        ({"obstacle_geometry": "barier"}, "obstacle_geometry"),
        ({"regularisation": 0.0}, "regularisation"),
        ({"spheres_per_shape": 0}, "spheres_per_shape"),
        ({"links": "boxes"}, "links"),
        ({"obstacle_enregy": "none"}, "did you mean 'obstacle_energy'"),
    ],
)
def test_parameters_that_make_no_sense_are_refused(parameters: Entry, said: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        PlannerConfiguration("mine", "fabrics", parameters).check()
    assert said in str(caught.value)
    assert "mine" in str(caught.value)


def test_parameters_by_name_are_accepted() -> None:
    given = {"obstacle_geometry": "soft_barrier", "planes": [[0.0, 0.0, 1.0, 0.02]], "links": "exact"}
    configuration = PlannerConfiguration("mine", "fabrics", given)
    configuration.check()
    found = configuration.parameters_for("point", "acceleration")
    assert (found.obstacle_geometry, found.planes, found.links) == ("soft_barrier", ((0.0, 0.0, 1.0, 0.02),), "exact")


# What users may write


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"planes": [[0, 0, 0]]}, "a plane is its outward normal"),
        ({"planes": [[1, 2]]}, "at least 3 items"),
        ({"brake": 1e999}, "finite"),
        ({"obstacle_energy": "0.1 / x"}, "gives what approaches no weight"),
        ({"obstacle_energy": "-0.1 * xdot**2 / x"}, "gives what approaches no weight"),
        ({"attractor_energy": "x"}, "gives what approaches no weight"),
        ({"attractor_energy": "none"}, "no sub-goal would count"),
        ({"attractor_potential": "-x"}, "drive away from the target"),
        ({"obstacle_geometry": "1 / 0"}, "has a value of inf at x = 0.5, xdot = -0.5"),
        ({"limit_geometry": "log(-x)"}, "has a value of nan"),
        ({"obstacle_geometry": "barier"}, "unknown name 'barier'; did you mean 'barrier'?"),
        ({"attractor_potential": "x * xdott"}, "xdott"),
        ({"links": "balls"}, "'spheres' or 'exact'"),
    ],
)
def test_parameters_that_cannot_be_used_are_told_before_anything_runs(parameters: Entry, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        PlannerConfiguration("mine", "fabrics", parameters).check()


def test_planes_of_another_dimension_are_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"planes: found \[0.0, 0.0, 1.0, 0.2\]; in 2 dimensions"):
        ready(POINT, HERE, planes=((0.0, 0.0, 1.0, 0.2),))


def test_actions_of_cars_are_not_shortened() -> None:
    with pytest.raises(ConfigurationError, match="a bicycle is planned for as a cart"):
        ready(
            spatial(ENTRIES["racecar"]),
            [goal("position", [1.0, 0.0], link="base_link", axes=[0, 1])],
            respect_limits=True,
        )


def test_the_static_configuration_differs_in_what_it_sees_only() -> None:
    dynamic, static = find_planners(["fabrics", "fabrics_static"], [])
    assert {**static.parameters, "obstacle_motion": True} == {**dynamic.parameters, "obstacle_motion": True}
    assert static.parameters["obstacle_motion"] is False
    assert (static.planner, static.per_robot, static.period) == (dynamic.planner, dynamic.per_robot, dynamic.period)


def test_parallel_segments_of_an_arm_do_not_throw_it_about() -> None:
    # Links 1 and 3 are parallel at right angles: their nearest points could lie anywhere along them.
    arm = planar(problems.arm(1.0, 1.0, 1.0), self_collision_pairs=[["link1", "link3"]])
    tip = [goal("position", [0.5, 0.5], link="end")]
    action = act(arm, [0.0, np.pi / 2, np.pi / 2], [1.0, 0.3, 0.1], tip)
    assert np.abs(action).max() < 100.0
