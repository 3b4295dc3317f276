"""Maps to task spaces against finite differences along exact motions: velocities, Jacobians, curvature terms, drifts.

Along q(t), where the inputs w have constant rates w', a map x(q, t) must have x' = its velocity and
x'' = its Jacobian times w' + its curvature term + its drift.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import casadi
import numpy as np
import pytest

from pytest_lpb.planner.fabrics.geometries import Geometries
from pytest_lpb.planner.scene.goals import ERRORS
from pytest_lpb.planner.scene.layout import Slot
from pytest_lpb.planner.scene.maps import Mapped, Reference, State
from pytest_lpb.planner.scene.parts import Ball, Block, Part, Segment
from pytest_lpb.planner.scene.shapes import MESH, SHAPES
from pytest_lpb.problem.goal import goal_from
from pytest_lpb.problem.robot import Robot, robot_from
from tests.planner import problems
from tests.planner.scene.making import (
    Array,
    Entry,
    geometries_of,
    goal,
    goal_info,
    moved,
    planar,
    random_states,
    spatial,
)
from tests.problem.spatial.robots import CAR, ENTRIES, PANDA, POINT
from tests.problem.spatial.robots import CART as SPATIAL_CART

STEP = 5e-3  # [s] between samples
STATES = 4  # per map
PANDA_LIMITS = [[-2.9, 2.9], [-1.8, 1.8], [-2.9, 2.9], [-3.0, -0.1], [-2.9, 2.9], [0.0, 3.7], [-2.9, 2.9]]  # [rad]

ROBOTS: dict[str, Entry] = {
    "point": planar(problems.POINT),
    "arm": planar(problems.arm(0.6, 0.5, 0.4)),
    "cart in the plane": planar(problems.CART),
    "point in space": spatial(POINT),
    "panda": spatial(PANDA, limits={"position": PANDA_LIMITS}),
    "panda on wheels": spatial(ENTRIES["panda on wheels"]),
    "panda on a holonomic base": spatial(ENTRIES["panda on a holonomic base"]),
    "arm on a car": spatial(ENTRIES["arm on a car"]),
    "racecar": spatial(ENTRIES["racecar"]),
    "car": spatial(CAR),
    "cart": spatial(SPATIAL_CART),
}


@cache
def robot(name: str) -> Robot:
    return robot_from(ROBOTS[name])


def slopes(value: Callable[[float], Array]) -> tuple[Array, Array]:
    """First and second derivative at t = 0, by central differences of fourth order."""
    a, b, c, d, e = (value(step * STEP) for step in (-2, -1, 0, 1, 2))
    return (a - 8.0 * b + 8.0 * d - e) / (12.0 * STEP), (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / (12.0 * STEP**2)


def dense(mapped: Mapped) -> list[Any]:
    parts = (mapped.value, mapped.velocity, mapped.jacobian, mapped.curvature, mapped.drift)
    return [casadi.densify(casadi.SX(part)) for part in parts]


def assert_differentiated(
    state: State, function: casadi.Function, reference: Array | None = None, seed: int = 0, count: int = STATES
) -> None:
    """Check a function of q, w and, if any, a reference (r, 3) to the parts of a map, in random states.

    Args:
        state: of the robot.
        function: to value, velocity, Jacobian, curvature term and drift.
        reference: value, velocity and acceleration of what else moves.
        seed: of the states.
        count: of states.
    """
    rates = np.random.default_rng(seed + 1000).uniform(-1.0, 1.0, (count, state.size))
    for (q, w), rate in zip(random_states(state.robot, seed, count), rates, strict=True):

        def at(t: float, q: Array = q, w: Array = w, rate: Array = rate) -> list[Array]:
            ends = moved(state.robot, q, w, rate, t)
            others = [] if reference is None else [later(reference, t)]
            return [np.array(part) for part in function(*ends, *others)]

        _, velocity, jacobian, curvature, drift = at(0.0)
        first, second = slopes(lambda t: at(t)[0])
        scale = 1.0 + np.abs(second).max()
        np.testing.assert_allclose(velocity, first, rtol=0.0, atol=1e-7 * scale)
        np.testing.assert_allclose(jacobian @ rate[:, None] + curvature + drift, second, rtol=0.0, atol=2e-6 * scale)


def later(reference: Array, t: float) -> Array:
    """What a reference (r, 3) of constant acceleration is after t [s]."""
    value, velocity, acceleration = reference.T
    ends = (value + t * velocity + 0.5 * t * t * acceleration, velocity + t * acceleration, acceleration)
    return np.column_stack(ends)


# Places of parts


def placed(name: str, links: str) -> tuple[Geometries, State, Mapped]:
    """The places of all parts of a robot, as one map."""
    state = State(robot(name))
    geometries = geometries_of(state, links=links)
    places = geometries._places(geometries.parts)
    joined = [casadi.vertcat(*(getattr(place, key) for place in places)) for key in Mapped.__dataclass_fields__]
    return geometries, state, Mapped(*joined)


@pytest.mark.parametrize("links", ["spheres", "exact"])
@pytest.mark.parametrize("name", ROBOTS)
def test_places_of_parts_move_as_their_maps_say(name: str, links: str) -> None:
    _, state, mapped = placed(name, links)
    function = casadi.Function("places", [state.q, state.inputs], dense(mapped), {"cse": True})
    assert_differentiated(state, function)


@pytest.mark.parametrize("name", ROBOTS)
def test_velocities_of_places_are_their_jacobians_times_the_inputs(name: str) -> None:
    _, state, mapped = placed(name, "exact")
    difference = mapped.velocity - mapped.jacobian @ state.inputs
    function = casadi.Function("difference", [state.q, state.inputs], [difference])
    for q, w in random_states(state.robot, 1, STATES):
        assert np.array(function(q, w)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_balls_are_where_the_robot_s_own_kinematics_have_them(name: str) -> None:
    geometries, state, _ = placed(name, "spheres")
    d = state.robot.dimension
    centres = casadi.horzcat(*(ball.place(state.frames) for ball in geometries.balls))
    function = casadi.Function("centres", [state.q], [centres])
    for q, _ in random_states(state.robot, 2, STATES):
        found = np.array(function(q)).T
        for ball, centre in zip(geometries.balls, found, strict=True):
            pose = state.robot.forward_kinematics(q, ball.link)
            ahead = ball.ahead * np.array([np.cos(q[2]), np.sin(q[2]), 0.0])[:d] if ball.ahead else 0.0
            assert centre == pytest.approx(pose[:d, :d] @ ball.centre + pose[:d, d] + ahead, abs=1e-9)


def test_a_cart_s_inputs_are_forward_and_turning_speed() -> None:
    state = State(robot("cart in the plane"))
    mapped = state.mapped(state.q[:2])
    function = casadi.Function("base", [state.q, state.inputs], dense(mapped))
    _, velocity, jacobian, curvature, _ = (np.array(part) for part in function([1.0, 2.0, 0.0], [0.5, 0.4]))
    assert velocity.ravel() == pytest.approx([0.5, 0.0])
    assert jacobian == pytest.approx(np.array([[1.0, 0.0], [0.0, 0.0]]))
    assert curvature.ravel() == pytest.approx([0.0, 0.2])  # v times turn rate, to the left


# Sub-goals

GOALS: dict[str, tuple[str, Entry]] = {
    "point": ("point", goal("position", [0.5, -0.2], link="body")),
    "point, one axis": ("point", goal("position", [0.5], link="body", axes=[1])),
    "point, joints": ("point", goal("joint", [0.5, 0.1], joints=["y", "x"])),
    "arm": ("arm", goal("position", [0.6, 0.4], link="end")),
    "arm, point of a link": ("arm", goal("position", [0.6, 0.4], link="link2", point=[0.2, -0.1])),
    "arm, relative": ("arm", goal("position", [0.3, 0.1], link="end", relative_to="link2")),
    "arm, relative, one axis": (
        "arm",
        goal("position", [0.3], link="end", relative_to="link2", axes=[1], point=[0.1, 0.2]),
    ),
    "arm, orientation": ("arm", goal("orientation", [0.7], link="link3")),
    "arm, alignment": ("arm", goal("alignment", [0.0], link="link2", axis=[1.0, 0.5], other_axis=[-0.2, 1.0])),
    "arm, two links": (
        "arm",
        goal("alignment", [0.0], link="end", axis=[1.0, 0.5], other="link1", other_axis=[-0.2, 1.0]),
    ),
    "arm, joints": ("arm", goal("joint", [0.3, -0.2], joints=["joint3", "joint1"])),
    "cart, ahead": ("cart in the plane", goal("position", [1.0, 0.5], link="base")),
    "cart, one axis": ("cart in the plane", goal("position", [0.5], link="base", axes=[1])),
    "cart, orientation": ("cart in the plane", goal("orientation", [0.7], link="base")),
    "cart, heading": ("cart in the plane", goal("joint", [0.7, 0.3], joints=["theta", "y"])),
    "panda": ("panda", goal("position", [0.4, 0.1, 0.5], link="panda_hand")),
    "panda, point": ("panda", goal("position", [0.4, 0.1, 0.5], link="panda_hand", point=[0.1, -0.2, 0.3])),
    "panda, two axes": ("panda", goal("position", [0.4, 0.5], link="panda_hand", axes=[0, 2])),
    "panda, relative": ("panda", goal("position", [0.1, 0.0, 0.3], link="panda_hand", relative_to="panda_link4")),
    "panda, orientation": ("panda", goal("orientation", [0.0, 0.924, 0.383, 0.0], link="panda_hand")),
    "panda, joints": ("panda", goal("joint", [0.1, -1.0], joints=["panda_joint2", "panda_joint4"])),
    "panda, alignment": (
        "panda",
        goal("alignment", [0.0], link="panda_hand", axis=[0, 0, 1], other="world", other_axis=[0, 1, -1]),
    ),
    "panda, two links": (
        "panda",
        goal("alignment", [0.0], link="panda_hand", axis=[0, 1, 0], other="panda_link3", other_axis=[1, 0, 0]),
    ),
    "car, ahead": ("car", goal("position", [1.0, 0.5, 0.1], link="base", point=[0.1, 0.0, 0.2])),
    "wheels": ("panda on wheels", goal("position", [1.0, 0.5, 0.4], link="panda_hand")),
    "wheels, orientation": ("panda on wheels", goal("orientation", [0.5, 0.5, -0.5, 0.5], link="panda_hand")),
    "wheels, heading": ("panda on wheels", goal("joint", [0.4, 0.2], joints=["theta", "panda_joint3"])),
}


def error_of(name: str, lookahead: float = 0.3) -> tuple[State, Reference, Any, Entry]:
    """State, symbols of the target and the error of a sub-goal."""
    model, entry = GOALS[name]
    state = State(robot(model))
    reference = Reference(*(casadi.SX.sym(key, entry["target"].size) for key in ("target", "velocity", "acceleration")))
    error = ERRORS[state.robot.dimension, entry["type"]](state, goal_info(entry), reference.value, lookahead)
    return state, reference, error, entry


def test_all_types_of_sub_goals_are_among_these() -> None:
    assert {(robot(model).dimension, entry["type"]) for model, entry in GOALS.values()} == set(ERRORS)


@pytest.mark.parametrize("name", GOALS)
def test_errors_of_sub_goals_change_as_their_maps_say(name: str) -> None:
    state, reference, error, entry = error_of(name)
    symbols = casadi.horzcat(reference.value, reference.velocity, reference.acceleration)
    mapped = dense(state.mapped(error, reference))
    function = casadi.Function("error", [state.q, state.inputs, symbols], mapped, {"cse": True})
    motion = np.random.default_rng(5).uniform(-0.5, 0.5, (entry["target"].size, 2))
    assert_differentiated(state, function, np.column_stack([entry["target"], motion]), seed=3)


@pytest.mark.parametrize("name", [name for name in GOALS if "ahead" not in name])
def test_errors_are_as_large_as_the_environment_says(name: str) -> None:
    state, reference, error, entry = error_of(name)
    function = casadi.Function("error", [state.q, reference.value], [error])
    judge = goal_from([{**entry["entry"], "name": "g", "primary": True, "target": entry["target"]}], state.robot)[0]
    for q, _ in random_states(state.robot, 4, STATES):
        value = judge.value(q.tolist(), state.robot.frames(q.tolist()))
        distance = judge.distance(value, entry["target"].tolist())
        found = np.array(function(q, entry["target"])).ravel()
        if entry["type"] == "joint":
            assert np.abs(found).max() == pytest.approx(distance, abs=1e-9)
        elif state.robot.dimension == 3 and entry["type"] in ("orientation", "alignment"):
            assert np.linalg.norm(found) == pytest.approx(2.0 * np.sin(0.5 * distance), abs=1e-9)
        else:
            assert np.linalg.norm(found) == pytest.approx(distance, abs=1e-9)


@pytest.mark.parametrize("lookahead", [0.05, 0.3, 2.0])
def test_a_cart_is_steered_by_a_point_ahead_whose_error_vanishes_at_the_goal_only(lookahead: float) -> None:
    state, reference, error, entry = error_of("cart, ahead", lookahead)
    function = casadi.Function("error", [state.q, reference.value], [error])
    for q, _ in random_states(state.robot, 6, 20):
        distance = float(np.linalg.norm(q[:2] - entry["target"]))
        found = np.array(function(q, entry["target"])).ravel()
        ahead = found - (q[:2] - entry["target"])
        assert ahead / np.linalg.norm(ahead) == pytest.approx([np.cos(q[2]), np.sin(q[2])])
        assert np.linalg.norm(ahead) < min(0.5 * distance, lookahead)
        assert np.linalg.norm(found) > 0.5 * distance
    assert np.linalg.norm(np.array(function([*entry["target"], 0.7], entry["target"]))) == pytest.approx(0.0, abs=1e-9)


# Bodies of the robot itself, limits, planes

OWN: dict[str, list[list[str]]] = {
    "arm": [["base", "link3"], ["base", "link2"]],
    "panda": [["panda_link0", "panda_link5"], ["panda_link1", "panda_hand"], ["panda_link2", "panda_link6"]],
    "panda on wheels": [["panda_link0", "panda_link5"], ["panda_link0", "panda_hand"]],
    "arm on a car": [["base", "link3"], ["link1", "link3"]],
}


@pytest.mark.parametrize("name", OWN)
def test_distances_between_own_bodies_change_as_their_maps_say(name: str) -> None:
    state = State(robot_from({**ROBOTS[name], "self_collision_pairs": OWN[name]}))
    geometries = geometries_of(state, self_collision_reach=10.0)
    maps = [leaf.mapped for leaf in geometries._own_bodies()]
    assert len(maps) == len(OWN[name])
    for place, mapped in enumerate(maps):
        function = casadi.Function("own", [state.q, state.inputs], dense(mapped), {"cse": True})
        assert_differentiated(state, function, seed=10 * place, count=2)


def test_distances_to_limits_change_as_their_maps_say() -> None:
    state = State(robot("panda"))
    maps = [leaf.mapped for leaf in geometries_of(state)._limits()]
    assert len(maps) == 2 * state.robot.dof
    q, w = np.linspace(-1.0, 1.0, 7), np.linspace(0.2, 0.8, 7)
    values = casadi.Function("limits", [state.q], [casadi.vertcat(*(mapped.value for mapped in maps))])
    assert np.array(values(q)).reshape(-1, 2) == pytest.approx(
        np.column_stack([q - np.array(PANDA_LIMITS)[:, 0], np.array(PANDA_LIMITS)[:, 1] - q])
    )
    rates = casadi.Function("rates", [state.inputs], [casadi.vertcat(*(mapped.velocity for mapped in maps))])
    assert np.array(rates(w)).reshape(-1, 2) == pytest.approx(np.column_stack([w, -w]))


@pytest.mark.parametrize(
    ("name", "plane"), [("arm", (3.0, 4.0, -2.0)), ("panda", (0.0, 0.0, 2.0, -0.1)), ("car", (1.0, 1.0, 0.0, -5.0))]
)
def test_distances_to_planes_change_as_their_maps_say(name: str, plane: tuple[float, ...]) -> None:
    state = State(robot(name))
    geometries = geometries_of(state, planes=(plane,))
    maps = [leaf.mapped for leaf in geometries._planes()]
    assert len(maps) == len(geometries.balls)
    for mapped in maps[-2:]:
        function = casadi.Function("plane", [state.q, state.inputs], dense(mapped), {"cse": True})
        assert_differentiated(state, function, seed=7)


# Distances of parts to obstacles

# The robot and link of which a part of a kind is taken, by dimension.
HOLDERS: dict[tuple[int, type[Part]], tuple[str, str]] = {
    (2, Ball): ("cart in the plane", "base"),
    (2, Segment): ("arm", "link3"),
    (3, Ball): ("panda on wheels", "panda_link7"),
    (3, Segment): ("arm on a car", "link3"),
    (3, Block): ("arm on a car", "mobile_base"),
}
DIMENSIONS = dict.fromkeys(SHAPES, 3) | {"circle": 2, "rectangle": 2}
SIZES: dict[str, list[float]] = {
    "circle": [0.3],
    "sphere": [0.3],
    "rectangle": [0.4, 0.2],
    "box": [0.4, 0.2, 0.6],
    "capsule": [0.15, 0.5],
    "cylinder": [0.25, 0.4],
    MESH: [],
}
PAIRS = [
    (dimension, kind, shape)
    for dimension, kind in HOLDERS
    for shape in sorted(kind.exact)
    if DIMENSIONS[shape] == dimension
]
TURNS = {2: [0.4], 3: (np.array([0.8, -0.3, 0.4, 0.2]) / np.linalg.norm([0.8, -0.3, 0.4, 0.2])).tolist()}


def distance_map(state: State, link: str, kind: type[Part], shape: str, **parameters: Any) -> casadi.Function:
    """Function of q, w and an obstacle's motion (d, 3) to what a fabric has of one part's distance to an obstacle.

    With the energy x'^2 / 2 the metric is J^T J and the energy's force J^T (curvature + drift); with the geometries 1,
    x and x' besides, the force tells J, x and x'.
    """
    slot = Slot(shape, state.robot.dimension)
    motion = casadi.SX.sym("motion", slot.dimension, 3)
    turn, sizes = TURNS[slot.dimension] if SHAPES[shape].turns else [], SIZES[shape]
    numbers = casadi.vertcat(casadi.reshape(motion, -1, 1), casadi.SX(casadi.DM([*turn, *sizes, 1.0])))
    told = {}
    for geometry in ("1", "x", "xdot"):
        leaves = {"base_energy": "0", "obstacle_energy": "0.5 * xdot**2", "obstacle_geometry": geometry}
        geometries = geometries_of(state, **{"links": "exact", **leaves, **parameters})
        part = [part for part in geometries.parts if part.link == link and type(part) is kind][-1]
        geometries.parts = [part]
        told[geometry] = geometries.total({shape: numbers})
    gradient = told["1"].force - told["1"].energy_force
    square = casadi.sumsqr(gradient)
    value, rate = (casadi.dot(gradient, told[key].force - told[key].energy_force) / square for key in ("x", "xdot"))
    bend = casadi.dot(gradient, told["1"].energy_force) / square
    results = [value, rate, gradient.T, bend, casadi.SX.zeros(1, 1)]
    return casadi.Function("distance", [state.q, state.inputs, motion], results, {"cse": True})


@pytest.mark.parametrize("distance", ["relative", "metric"])
@pytest.mark.parametrize(("dimension", "kind", "shape"), PAIRS)
def test_distances_to_moving_obstacles_change_as_their_maps_say(
    dimension: int, kind: type[Part], shape: str, distance: str
) -> None:
    name, link = HOLDERS[dimension, kind]
    state = State(robot(name))
    function = distance_map(state, link, kind, shape, distance=distance)
    generator = np.random.default_rng(0)
    for seed in range(STATES):
        motion = generator.uniform(-0.6, 0.6, (dimension, 3))
        motion[:, 0] *= 2.5 / np.linalg.norm(motion[:, 0])  # too far to touch
        assert_differentiated(state, function, motion, seed=20 + seed, count=1)


# What x is measured by where it is relative: the sum of the part's radius and that of the largest ball in the obstacle.
INSCRIBED = {"circle": 0.3, "sphere": 0.3, "rectangle": 0.1, "box": 0.1, "capsule": 0.15, "cylinder": 0.2, MESH: 0.0}


@pytest.mark.parametrize(("dimension", "kind", "shape"), PAIRS)
def test_relative_distances_are_per_sum_of_radii(dimension: int, kind: type[Part], shape: str) -> None:
    name, link = HOLDERS[dimension, kind]
    state = State(robot(name))
    parts = geometries_of(state, links="exact").parts
    radius = [part.radius for part in parts if part.link == link and type(part) is kind][-1]
    relative, metric = (distance_map(state, link, kind, shape, distance=way) for way in ("relative", "metric"))
    motion = np.zeros((dimension, 3))
    motion[:, 0] = 3.0
    (state_now,) = random_states(state.robot, 30, 1)
    distance = float(metric(*state_now, motion)[0])
    assert float(relative(*state_now, motion)[0]) == pytest.approx(distance / (radius + INSCRIBED[shape]))


def test_a_cylinder_s_largest_ball_may_be_as_wide_as_it_is() -> None:
    assert float(SHAPES["cylinder"].inscribed(casadi.DM([0.25, 0.4]))) == 0.2
    assert float(SHAPES["cylinder"].inscribed(casadi.DM([0.25, 4.0]))) == 0.25


def test_errors_of_headings_are_wrapped_and_those_of_joints_are_not() -> None:
    for name, joint, expected in (("cart in the plane", "theta", 6.0 - 2.0 * np.pi), ("arm", "joint3", 6.0)):
        state = State(robot(name))
        entry = goal("joint", [-3.0], joints=[joint])
        error = ERRORS[2, "joint"](state, goal_info(entry), casadi.SX(-3.0), 0.3)
        assert float(casadi.Function("error", [state.q], [error])([0.0, 0.0, 3.0])) == pytest.approx(expected)
