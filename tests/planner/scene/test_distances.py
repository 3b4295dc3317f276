"""Signed distances against those trials are judged by, segments against brute force, derivatives finite anywhere."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import product
from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.scene.layout import Slot
from pytest_lpb.planner.scene.maps import State, derivatives
from pytest_lpb.planner.scene.parts import Ball, Block, ObstacleSymbols, Part, Segment, distance_between
from pytest_lpb.planner.scene.robot_parts import capsules_of, parts_of
from pytest_lpb.planner.scene.segments import segment_derivatives, segment_distance
from pytest_lpb.planner.scene.shapes import MESH, SHAPES
from pytest_lpb.problem.collision import CollisionSpace
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import Robot, robot_from
from tests.planner import problems
from tests.planner.scene.making import Array, Entry, obstacle, obstacle_info, planar, random_states, spatial
from tests.problem.spatial.robots import ARM, ENTRIES, PANDA, POINT

EXACT = {2: 1e-9, 3: 2e-5}  # [m] by dimension: Bullet's iterations end early at curved faces
EXCESS = 0.05  # [m]
TURN = (np.array([0.7, -0.4, 0.5, 0.3]) / np.linalg.norm([0.7, -0.4, 0.5, 0.3])).tolist()

ROBOTS: dict[str, Entry] = {
    "point": planar(problems.POINT),
    "arm": planar(problems.arm(0.6, 0.5, 0.4)),
    "point in space": spatial(POINT),
    "arm in space": spatial(ARM),
    "arm on a car": spatial(ENTRIES["arm on a car"]),
    "panda": spatial(PANDA, limits={"position": [[-2.0, 2.0]] * 3 + [[-3.0, -0.1]] + [[-2.0, 2.0]] * 3}),
}
THINGS: dict[str, Entry] = {
    "circle": obstacle("circle", [0.0, 0.0], radius=0.3),
    "rectangle": obstacle("rectangle", [0.0, 0.0], size=[0.5, 0.3]),
    "turned rectangle": obstacle("rectangle", [0.0, 0.0], size=[0.5, 0.3], orientation=0.8),
    "sphere": obstacle("sphere", [0.0, 0.0, 0.0], radius=0.3),
    "box": obstacle("box", [0.0, 0.0, 0.0], size=[0.6, 0.4, 0.8]),
    "turned box": obstacle("box", [0.0, 0.0, 0.0], size=[0.6, 0.4, 0.8], orientation=TURN),
    "capsule": obstacle("capsule", [0.0, 0.0, 0.0], radius=0.2, length=0.7),
    "turned capsule": obstacle("capsule", [0.0, 0.0, 0.0], radius=0.2, length=0.7, orientation=TURN),
    "cylinder": obstacle("cylinder", [0.0, 0.0, 0.0], radius=0.3, length=0.6),
    "turned cylinder": obstacle("cylinder", [0.0, 0.0, 0.0], radius=0.3, length=0.6, orientation=TURN),
}


@cache
def robot(name: str) -> Robot:
    return robot_from(ROBOTS[name])


@pytest.fixture(scope="module")
def spaces() -> Iterator[dict[str, CollisionSpace]]:
    """What the environment measures with, per robot."""
    made = {name: robot(name).collision_space([]) for name in ROBOTS}
    yield made
    for space in made.values():
        space.close()


def at(thing: Entry, position: Array) -> Obstacle:
    """An obstacle as the environment has it."""
    entry = {key: value for key, value in thing.items() if value is not None}
    return Obstacle({**entry, "position": position.tolist()})


def symbols_of(thing: Entry) -> ObstacleSymbols:
    """An obstacle as distances have it, its numbers filled in."""
    slot = Slot(thing["shape"], len(thing["position"]))
    numbers = np.zeros(slot.length)
    numbers[slot.turn] = thing["orientation"] if slot.turn.stop > slot.turn.start else []
    numbers[slot.sizes] = SHAPES[slot.shape].sizes(obstacle_info(thing))
    return slot.symbols(casadi.SX(casadi.DM(numbers)))


def measured(name: str, thing: Entry, links: str, **parameters: Any) -> casadi.Function:
    """Function of q and an obstacle's position to the distance [m] of the robot's nearest part."""
    state = State(robot(name))
    told = FabricsParameters(**{"links": links, "sphere_excess": EXCESS, **parameters})
    position = casadi.SX.sym("position", state.robot.dimension)
    symbols = symbols_of(thing)
    distances = [
        met.distance(met.place(state.frames) - met.shift(position), symbols)
        for part in parts_of(state.robot, told, exact=told.links == "exact", lookahead=told.lookahead)
        for met in ([part] if thing["shape"] in part.exact else part.balls(EXCESS))
    ]
    return casadi.Function("measured", [state.q, position], [casadi.mmin(casadi.vertcat(*distances))], {"cse": True})


def near(name: str, seed: int, count: int = 150) -> Iterator[tuple[Array, Array]]:
    """Configurations, and places of obstacles near the robot."""
    generator = np.random.default_rng(seed)
    links = robot(name).link_names
    d = robot(name).dimension
    for q, _ in random_states(robot(name), seed, count):
        link = links[int(generator.integers(len(links)))]
        yield q, robot(name).forward_kinematics(q, link)[:d, d] + generator.uniform(-0.8, 0.8, d)


EXACT_PAIRS = [
    *product(["point"], [name for name, thing in THINGS.items() if len(thing["position"]) == 2]),
    ("arm", "circle"),
    *product(["point in space"], [name for name, thing in THINGS.items() if len(thing["position"]) == 3]),
    *product(["arm in space"], ["sphere", "capsule", "turned capsule"]),
    ("arm on a car", "sphere"),
]


@pytest.mark.parametrize(("name", "thing"), EXACT_PAIRS)
def test_distances_are_those_of_the_environment(name: str, thing: str, spaces: dict[str, CollisionSpace]) -> None:
    function = measured(name, THINGS[thing], "exact")
    apart, touching = 0, 0
    for q, position in near(name, 0):
        expected = spaces[name].clearance_of(at(THINGS[thing], position), q.tolist())
        if expected > -0.04:  # deeper, engines push out elsewhere
            assert float(function(q, position)) == pytest.approx(expected, abs=EXACT[robot(name).dimension])
            apart, touching = apart + (expected > 0.0), touching + (expected < 0.0)
    assert apart > 5
    assert touching > 0


@pytest.mark.parametrize(
    ("name", "thing", "links"),
    [
        ("arm", "circle", "spheres"),
        ("arm", "rectangle", "exact"),
        ("arm", "turned rectangle", "spheres"),
        ("arm in space", "sphere", "spheres"),
        ("arm in space", "box", "exact"),
        ("arm in space", "turned cylinder", "exact"),
        ("panda", "sphere", "spheres"),
        ("panda", "turned box", "exact"),
    ],
)
def test_balls_hold_links_and_reach_little_beyond(
    name: str, thing: str, links: str, spaces: dict[str, CollisionSpace]
) -> None:
    function = measured(name, THINGS[thing], links, spheres_per_shape=64)
    slack = EXACT[robot(name).dimension]
    for q, position in near(name, 1, 40):
        expected = spaces[name].clearance_of(at(THINGS[thing], position), q.tolist())
        if expected > 0.0:
            assert expected - EXCESS - slack <= float(function(q, position)) <= expected + slack


@pytest.mark.parametrize("name", ["arm", "arm in space"])
def test_distances_between_own_bodies_are_those_of_the_environment(name: str) -> None:
    pairs = [["base", "link3"], ["link1", "link3"]]
    made = robot_from({**ROBOTS[name], "self_collision_pairs": pairs})
    state, bodies = State(made), capsules_of(made)
    distances = [
        distance_between(one, other, [one.place(state.frames), other.place(state.frames)])
        for first, second in pairs
        for one in bodies[first]
        for other in bodies[second]
    ]
    function = casadi.Function("own", [state.q], [casadi.mmin(casadi.vertcat(*distances))])
    space, checked = made.collision_space([]), 0
    for q in np.random.default_rng(2).uniform(-2.6, 2.6, (80, made.dof)):
        expected = space.self_clearance(q.tolist())[0]
        if expected > -0.5 * made.body_radius:  # axes that cross have no depth here
            assert float(function(q)) == pytest.approx(expected, abs=EXACT[made.dimension])
            checked += 1
    space.close()
    assert checked > 20


def test_the_body_of_a_base_that_must_turn_is_also_ahead_of_it() -> None:
    made = robot_from(planar(problems.CART))
    state = State(made)
    parts = parts_of(made, FabricsParameters(), exact=False, lookahead=0.4)
    places = casadi.Function("places", [state.q], [part.place(state.frames) for part in parts])
    here, ahead = (np.array(place).ravel() for place in places([1.0, 2.0, np.pi / 6.0]))
    assert here == pytest.approx([1.0, 2.0])
    assert ahead == pytest.approx([1.0 + 0.2 * np.sqrt(3.0), 2.2])
    assert {part.radius for part in parts} == {0.2}


@pytest.mark.parametrize("links", ["spheres", "exact"])
@pytest.mark.parametrize("name", ["cart", "husky", "car", "racecar"])
def test_parts_ahead_of_a_base_are_so_along_its_heading(name: str, links: str) -> None:
    made = robot_from(spatial(ENTRIES[name]))
    state, parts = State(made), parts_of(made, FabricsParameters(), exact=links == "exact", lookahead=0.3)
    half = len(parts) // 2
    shifts = [
        (moved.place(state.frames) - part.place(state.frames))[:3]
        for part, moved in zip(parts[:half], parts[half:], strict=True)
    ]
    function = casadi.Function("shifts", [state.q], [casadi.horzcat(*shifts)])
    q = np.zeros(made.dof)
    q[:3] = 0.3, -0.2, 0.5
    for shift in np.array(function(q)).T:
        assert shift == pytest.approx([0.3 * np.cos(0.5), 0.3 * np.sin(0.5), 0.0], abs=1e-9)


# Segments

COORDINATES = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3)
PLACES = {count: [casadi.SX.sym(f"p{count}{i}", 3) for i in range(count)] for count in (1, 2)}
OTHERS = {count: [casadi.SX.sym(f"o{count}{i}", 3) for i in range(count)] for count in (1, 2)}
SEGMENTS = {
    (one, other): casadi.Function(
        "segments", [*PLACES[one], *OTHERS[other]], [segment_distance(PLACES[one], OTHERS[other])]
    )
    for one, other in product((1, 2), (1, 2))
}


def to_segment(point: Array, a: Array, b: Array) -> float:
    along = b - a
    square = float(along @ along)
    share = np.clip((point - a) @ along / square, 0.0, 1.0) if square > 0.0 else 0.0
    return float(np.linalg.norm(a + share * along - point))


def brute_force(a: Array, b: Array, c: Array, d: Array) -> float:
    """Distance of segments: that of a point to one of them, where the point along the other makes it least."""
    low, high = 0.0, 1.0
    for _ in range(6):  # the distance is convex along the segment
        shares = np.linspace(low, high, 21)
        distances = [to_segment(a + share * (b - a), c, d) for share in shares]
        best = int(np.argmin(distances))
        low, high = shares[max(best - 1, 0)], shares[min(best + 1, 20)]
    return min(distances)


@given(COORDINATES, COORDINATES, COORDINATES, COORDINATES)
@example([0, 0, 0], [1, 0, 0], [0, 0.5, 0], [1, 0.5, 0])  # parallel, side by side
@example([0, 0, 0], [1, 0, 0], [0.9, 0.5, 0], [-0.2, 0.5, 0])  # the other way round
@example([0, 0, 0], [1, 0, 0], [1.0, 0, 0], [0.5, 0, 0])  # one within the other
@example([0, 0, 0], [0.2, 0, 0], [0.5, 0, 0], [1, 0, 0])  # one behind the other
@example([-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0])  # crossing
@example([-1, 0, 0], [1, 0, 0], [0, -1, 0.3], [0, 1, 0.3])  # crossing at a distance
@example([-1, 0, 0], [1, 0, 0], [0.5, 0.2, 0], [0.5, 1, 0])  # a T
@example([0, 0, 0], [0, 0, 0], [1, 1, 0], [1, -1, 0])  # a point
@example([0, 0, 0], [0, 0, 0], [1, 1, 1], [1, 1, 1])  # two points
@example([0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0])  # one point
def test_distances_of_segments_are_those_of_brute_force(
    a: list[float], b: list[float], c: list[float], d: list[float]
) -> None:
    points = [np.array(point, dtype=float) for point in (a, b, c, d)]
    expected = brute_force(*points)
    # Segments turned against one another by less than the root of PARALLEL have any of their nearest points.
    assert float(SEGMENTS[2, 2](*points)) == pytest.approx(expected, abs=5e-5)
    assert float(SEGMENTS[2, 2](*points[2:], *points[:2])) == pytest.approx(expected, abs=5e-5)


@given(COORDINATES, st.floats(-50.0, 50.0), st.floats(0.1, 5.0))
def test_long_parallel_segments_have_the_distance_of_their_lines(
    along: list[float], shift: float, distance: float
) -> None:
    # 200 m long and shifted by less: they lie side by side, and any of their nearest points will do.
    assume(np.linalg.norm(along) > 0.1)
    direction = np.array(along) / np.linalg.norm(along)
    across = np.cross(direction, np.eye(3)[np.abs(direction).argmin()])
    offset = shift * direction + distance * across / np.linalg.norm(across)
    ends = [-100.0 * direction, 100.0 * direction]
    assert float(SEGMENTS[2, 2](*ends, *(end + offset for end in ends))) == pytest.approx(distance, abs=1e-6)


@given(COORDINATES, COORDINATES, COORDINATES)
def test_distances_of_points_and_segments(a: list[float], b: list[float], p: list[float]) -> None:
    start, end, point = np.array(a), np.array(b), np.array(p)
    expected = to_segment(point, start, end)
    assert float(SEGMENTS[2, 1](start, end, point)) == pytest.approx(expected, abs=1e-5)
    assert float(SEGMENTS[1, 2](point, start, end)) == pytest.approx(expected, abs=1e-5)
    assert float(SEGMENTS[1, 1](start, point)) == pytest.approx(np.linalg.norm(start - point), abs=1e-9)


# Derivatives


def finite(part: Part, size: int, thing: Entry, places: Array) -> bool:
    """Whether distance, velocity, gradient and curvature term are finite at places relative to the obstacle."""
    place, velocity = casadi.SX.sym("place", size), casadi.SX.sym("velocity", size)
    mapped = derivatives(part.distance(place, symbols_of(thing)), (place, velocity))
    parts = (mapped.value, mapped.velocity, mapped.jacobian.T, mapped.curvature)
    function = casadi.Function("derivatives", [place, velocity], [casadi.vertcat(*map(casadi.densify, parts))])
    rates = np.random.default_rng(0).uniform(-1.0, 1.0, places.shape)
    return bool(np.isfinite(np.array([function(at, rate) for at, rate in zip(places, rates, strict=True)])).all())


@pytest.mark.parametrize("thing", THINGS)
def test_derivatives_at_balls_are_finite_anywhere(thing: str) -> None:
    d = len(THINGS[thing]["position"])
    # Centres, faces, edges, corners and ends of all shapes are among these.
    grid = np.array(list(product([0.0, 0.1, -0.2, 0.2, 0.25, 0.3, 0.35, -0.4, 2.0], repeat=d)))
    assert finite(Ball("body", "body", 0.1, (0.0,) * d), d, THINGS[thing], grid)


@pytest.mark.parametrize("thing", ["circle", "sphere", "capsule", "turned capsule"])
def test_derivatives_at_segments_are_finite_anywhere(thing: str) -> None:
    d = len(THINGS[thing]["position"])
    ends = np.array(list(product([0.0, 0.35, -0.35], repeat=d)))  # parallel, crossing, of no length, end to end
    places = np.array([np.concatenate(pair) for pair in product(ends, ends)])
    assert finite(Segment("body", "body", 0.1, (0.0,) * d, (1.0,) * d), 2 * d, THINGS[thing], places)


def test_derivatives_at_boxes_are_finite_anywhere() -> None:
    block = Block("body", "body", 0.0, tuple(np.eye(4).ravel()), (0.6, 0.4, 0.8), ())
    centres = product([0.0, 0.2, -0.3, 0.4, 1.0], repeat=3)
    places = np.array([[*centre, *np.eye(3).ravel()] for centre in centres])
    assert finite(block, 12, THINGS["sphere"], places)


def test_derivatives_at_a_mesh_s_point_are_finite_anywhere() -> None:
    mesh = obstacle(MESH, [0.0, 0.0, 0.0], file="ring.obj")
    grid = np.array(list(product([0.0, 0.1, 1.0], repeat=3)))
    assert finite(Ball("body", "body", 0.1, (0.0, 0.0, 0.0)), 3, mesh, grid)


# Derivatives of segments' distances in closed form


def with_slopes(one: int, other: int) -> tuple[casadi.Function, casadi.Function]:
    """Functions of the points and their velocities: in closed form, and as CasADi differentiates the distance."""
    points = [casadi.SX.sym(f"p{index}", 3) for index in range(one + other)]
    rates = [casadi.SX.sym(f"v{index}", 3) for index in range(one + other)]
    known = segment_derivatives(points[:one], points[one:], rates[:one], rates[one:])
    place, rate = casadi.vertcat(*points), casadi.vertcat(*rates)
    found = derivatives(segment_distance(points[:one], points[one:]), (place, rate))
    functions = []
    for mapped in (known, found):
        parts = (mapped.value, mapped.velocity, mapped.jacobian.T, mapped.curvature)
        functions.append(casadi.Function("slopes", [place, rate], [casadi.vertcat(*map(casadi.densify, parts))]))
    return functions[0], functions[1]


KINDS = {(one, other): with_slopes(one, other) for one, other in product((1, 2), (1, 2))}


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_slopes_in_closed_form_are_those_of_the_distance(kind: tuple[int, int]) -> None:
    known, found = KINDS[kind]
    generator = np.random.default_rng(0)
    for _ in range(100):
        points, rates = generator.uniform(-1.0, 1.0, (2, 3 * sum(kind)))
        expected = np.array(found(points, rates))
        if np.abs(expected).max() < 100.0:  # not nearly parallel
            assert np.array(known(points, rates)) == pytest.approx(expected, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("lengths", list(product([0.0, 0.5], repeat=2)), ids=str)
def test_slopes_are_finite_anywhere(lengths: tuple[float, float]) -> None:
    known, _ = KINDS[2, 2]
    rate = np.random.default_rng(0).uniform(-1.0, 1.0, 12)
    for start, along in product(product([0.0, 0.25, 0.5], repeat=3), np.eye(3)):
        ends: list[Any] = [np.zeros(3), [lengths[0], 0.0, 0.0], start, np.array(start) + lengths[1] * along]
        assert np.isfinite(np.array(known(np.ravel(ends), rate))).all()


def test_a_segment_that_slides_past_a_parallel_one_keeps_its_distance() -> None:
    ends: list[Any] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.2, 0.5, 0.0], [0.9, 0.5, 0.0]]
    known, _ = KINDS[2, 2]
    found = np.array(known(np.ravel(ends), np.array([0.3, 0.0, 0.0] * 2 + [0.0] * 6))).ravel()
    assert found[[0, 1, -1]] == pytest.approx([0.5, 0.0, 0.0], abs=1e-9)
