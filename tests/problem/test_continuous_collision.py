"""The search along one step, on distances that are written down; and the bounds that it rests on, on all robots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, sqrt

import numpy as np
import pytest

from pytest_lpb.problem.continuous_collision import (
    CLEARANCE_TOLERANCE_M,
    EITHER,
    MAX_MEASUREMENTS,
    SHARE_RESOLUTION,
    Span,
    first_touch,
    least_distance,
    most_measurements,
)
from pytest_lpb.problem.spatial.reach import reach_between, reach_of_joints
from tests.problem.entries import ARM, CART, make_robot
from tests.problem.spatial.robots import ENTRIES, spatial_robot

SLACK = 1e-9
DT = 0.1


class Written:
    """Pairs whose distances along the step are functions of the share, with bounds of their change."""

    def __init__(self, *pairs: tuple[Callable[[float], float], float]) -> None:
        self._pairs = pairs
        self.measured = 0

    def spans(self, floor: float, kinds: Sequence[bool] = EITHER) -> list[Span]:
        spans = [Span(0.0, d(0.0), d(1.0), index, travel) for index, (d, travel) in enumerate(self._pairs)]
        return [span for span in spans if not span.bound >= floor]

    def distances(self, share: float, pairs: Sequence[int]) -> list[float]:
        self.measured += len(pairs)
        return [self._pairs[pair][0](share) for pair in pairs]

    def names(self, pair: int) -> tuple[str, str]:
        return f"body{pair}", "obstacle"

    def is_own(self, pair: int) -> bool:
        return False


def passing(speed: float, offset: float, radius: float, at: float) -> tuple[Callable[[float], float], float]:
    """A point that passes a disc's centre at `offset`, nearest at the share `at`; it moves `speed` in the step."""
    return lambda s: sqrt(offset**2 + (speed * (s - at)) ** 2) - radius, speed


@pytest.mark.parametrize("speed", [0.5, 50.0, 5e3])
@pytest.mark.parametrize("depth", [1e-6, 1e-3, 0.009])
def test_contact_is_found_however_short(speed: float, depth: float) -> None:
    radius, at = 0.01, 0.61803
    bodies = Written(passing(speed, radius - depth, radius, at), passing(speed, 3.0, radius, 0.1))
    touch = first_touch(bodies, -SLACK)
    assert touch is not None
    assert touch.pair == 0
    expected = at - sqrt(radius**2 - (radius - depth) ** 2) / speed
    assert abs(touch.share - expected) <= SHARE_RESOLUTION
    assert bodies.measured < 2 * MAX_MEASUREMENTS


@pytest.mark.parametrize("speed", [0.5, 50.0, 5e3])
@pytest.mark.parametrize("gap", [0.0, 1e-7, 1e-3])
def test_what_only_grazes_is_free(speed: float, gap: float) -> None:
    bodies = Written(passing(speed, 0.01 + gap, 0.01, 0.3))
    assert first_touch(bodies, -SLACK) is None
    assert bodies.measured < 4 * MAX_MEASUREMENTS


def test_the_first_of_several_contacts_counts() -> None:
    bodies = Written(passing(3.0, 0.0, 0.2, 0.9), passing(3.0, 0.0, 0.01, 0.4), passing(3.0, 0.0, 0.01, 0.5))
    touch = first_touch(bodies, -SLACK)
    assert touch is not None
    assert touch.pair == 1
    assert touch.share == pytest.approx(0.4 - 0.01 / 3.0, abs=SHARE_RESOLUTION)


def test_many_near_passes_do_not_hide_a_short_contact() -> None:
    """A fast robot among many obstacles: each pair has its own share of the effort."""
    near = [passing(50.0, 0.012, 0.01, at) for at in np.linspace(0.05, 0.95, 200)]
    touching = passing(50.0, 0.01 - 1e-6, 0.01, 0.31415926)
    bodies = Written(*near, touching)
    touch = first_touch(bodies, -SLACK)
    assert touch is not None
    assert touch.pair == len(near)
    assert touch.share == pytest.approx(0.31415926, abs=SHARE_RESOLUTION)
    assert bodies.measured < most_measurements(len(near) + 1)
    known = min(touching[0](0.0), touching[0](1.0))
    assert least_distance(Written(*near, touching), known, inf) == pytest.approx(-1e-6, abs=CLEARANCE_TOLERANCE_M)


@pytest.mark.parametrize("travel", [1.0, 1e6, 1e300, inf])
def test_the_effort_is_bounded(travel: float) -> None:
    """Sliding at no distance at all, and bodies that diverge, end after so many measurements."""
    bodies = Written((lambda s: 0.0, travel))
    assert first_touch(bodies, -SLACK) is None
    assert bodies.measured < 4 * MAX_MEASUREMENTS
    assert least_distance(bodies, 0.0, inf) == 0.0
    assert bodies.measured < 8 * MAX_MEASUREMENTS


@pytest.mark.parametrize("offset", [0.005, 0.2, 2.0])
def test_least_distances_are_found_to_their_tolerance(offset: float) -> None:
    distance, travel = passing(4.0, offset, 0.01, 0.37)
    known = min(distance(0.0), distance(1.0))
    assert least_distance(Written((distance, travel)), known, inf) == pytest.approx(
        offset - 0.01, abs=CLEARANCE_TOLERANCE_M
    )
    assert least_distance(Written((distance, travel)), known, -1.0) == known, "nobody asks for what is not below -1"


@pytest.mark.parametrize("control", ["velocity", "acceleration"])
@pytest.mark.parametrize("entry", [ARM, CART], ids=["arm", "cart"])
def test_planar_links_are_no_faster_than_their_bounds(entry: dict[str, object], control: str) -> None:
    robot = make_robot(entry, control=control)
    random = np.random.Generator(np.random.PCG64(3))
    for _ in range(30):
        q, u, action = (
            random.uniform(-s, s, n).tolist() for s, n in ((3, robot.dof), (5, robot.n_actions), (90, robot.n_actions))
        )
        after = robot.integrate(q, u, action, DT)[1]
        speeds = robot.link_speeds(after if control == "velocity" else u, after)
        frames = [robot.frames(robot.integrate(q, u, action, DT * s)[0]) for s in np.linspace(0.0, 1.0, 200)]
        for link, (linear, angular) in enumerate(speeds):
            points = np.array([[f[link][0], f[link][1]] for f in frames])
            assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() <= linear * DT / 199 + 1e-9
            turns = np.unwrap([np.arctan2(f[link][3], f[link][2]) for f in frames])
            assert np.abs(np.diff(turns)).max() <= angular * DT / 199 + 1e-9


class Body:
    """A ball around a link's frame."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.radius = 0.15


@pytest.mark.parametrize("control", ["velocity", "acceleration"])
@pytest.mark.parametrize("name", ENTRIES)
def test_points_of_robots_in_space_are_no_faster_than_their_bounds(name: str, control: str) -> None:
    """Points on links along random steps, and the distances between two of them."""
    robot = spatial_robot(ENTRIES[name], control=control)
    random = np.random.Generator(np.random.PCG64(4))
    bodies = [Body(link) for link in robot.link_names if link in robot.urdf._links]
    rows = [robot.link_index(body.name) for body in bodies]
    pairs = [(i, j) for i in range(len(bodies)) for j in range(i)]
    reach, between = reach_of_joints(robot, bodies), reach_between(robot, bodies, pairs)
    low, high = np.clip(robot.limits.position, -1.0, 1.0).T
    for _ in range(4):
        q = random.uniform(low, high).tolist()
        u, action = (random.uniform(-s, s, robot.n_actions).tolist() for s in (3.0, 40.0))
        action = [a if control == "acceleration" else 0.05 * a for a in action]
        last, after = robot.integrate(q, u, action, DT)
        rates = np.array(robot.peak_rates(last, after if control == "velocity" else u, after, DT))
        path = np.array([robot.integrate(q, u, action, DT * s)[0] for s in np.linspace(0.0, 1.0, 60)])
        offsets = random.normal(size=(len(bodies), 3))
        offsets *= 0.15 / np.linalg.norm(offsets, axis=1, keepdims=True)
        frames = robot.link_frames_along(path)[:, rows]
        points = frames[..., :3, 3] + np.einsum("nbij,bj->nbi", frames[..., :3, :3], offsets)
        step = DT / 59
        moved = np.linalg.norm(np.diff(points, axis=0), axis=2).max(axis=0)
        assert (moved <= reach @ rates * step + 1e-9).all()
        apart = np.linalg.norm(points[:, [i for i, _ in pairs]] - points[:, [j for _, j in pairs]], axis=2)
        assert (np.abs(np.diff(apart, axis=0)).max(axis=0) <= between @ rates * step + 1e-9).all()
