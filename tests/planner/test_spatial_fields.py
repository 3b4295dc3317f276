"""Distances of points to obstacles in space, and control points on robots."""

from __future__ import annotations

from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pytest_lpb.planner.base import ObstacleInfo
from pytest_lpb.planner.spatial_fields import SpatialControlPoints, SpatialObstacleField, SpatialSelfDistances
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.spatial.space import SpatialSpace
from tests.problem.spatial.entries import write_torus
from tests.problem.spatial.robots import ARM, CART, PANDA, POINT, spatial_robot

Array = NDArray[np.float64]

SHAPES: dict[str, dict[str, Any]] = {
    "sphere": {"radius": 0.4},
    "box": {"size": [0.6, 0.4, 1.0]},
    "capsule": {"radius": 0.2, "length": 0.8},
    "cylinder": {"radius": 0.3, "length": 0.6},
}
TURN = [cos(0.4), 0.0, sin(0.4), 0.0]
AT = [0.3, -0.2, 0.5]


def told(shape: str, **values: Any) -> ObstacleInfo:
    size = values.pop("size", None)
    return ObstacleInfo("o", shape, values.pop("radius", None), None if size is None else tuple(size), False, **values)


def observed(count: int) -> dict[str, Array]:
    return {"obstacle_position": np.array([AT] * count), "obstacle_orientation": np.array([TURN] * count)}


@pytest.fixture(scope="module")
def space() -> SpatialSpace:
    """The distances of a tiny ball, by the simulator: an independent check."""
    return SpatialSpace(spatial_robot(POINT, body_radius=1e-3), [])


@pytest.mark.parametrize("shape", SHAPES)
@given(st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3))
@settings(max_examples=60, deadline=None)
def test_distances_are_those_of_the_simulator(shape: str, space: SpatialSpace, point: list[float]) -> None:
    field = SpatialObstacleField([told(shape, **SHAPES[shape])])
    distance, away = field.distances(np.array([point]), observed(1))
    entry = {"name": "o", "shape": shape, "position": AT, "orientation": TURN, **SHAPES[shape]}
    expected = space.clearance_of(Obstacle(entry), point) + 1e-3
    assert distance[0, 0] == pytest.approx(expected, abs=2e-5)
    assume(abs(distance[0, 0]) > 1e-3)
    # Away is where the distance grows as fast as one moves.
    step = 1e-5
    further, _ = field.distances(np.array([point]) + step * away[0], observed(1))
    assert (further[0, 0] - distance[0, 0]) / step == pytest.approx(1.0, abs=1e-3)


def test_obstacles_of_all_kinds_keep_their_order() -> None:
    kinds = ["box", "sphere", "cylinder", "sphere", "capsule", "box"]
    together = SpatialObstacleField([told(kind, **SHAPES[kind]) for kind in kinds])
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (5, 3))
    distance, away = together.distances(points, observed(len(kinds)))
    for column, kind in enumerate(kinds):
        alone = SpatialObstacleField([told(kind, **SHAPES[kind])]).distances(points, observed(1))
        assert distance[:, column] == pytest.approx(alone[0][:, 0])
        assert away[:, column] == pytest.approx(alone[1][:, 0])


def test_a_concave_mesh_is_open_inside(tmp_path: Path) -> None:
    path = write_torus(tmp_path / "ring.obj", major=0.5, minor=0.1)
    field = SpatialObstacleField([told("mesh", file=str(path), concave=True)])
    middle = {"obstacle_position": np.zeros((1, 3)), "obstacle_orientation": np.array([[1.0, 0.0, 0.0, 0.0]])}
    distance, away = field.distances(np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]]), middle)
    assert distance[:, 0] == pytest.approx([0.4, 0.1], abs=0.005)
    assert away[1, 0] == pytest.approx([-1.0, 0.0, 0.0], abs=0.05)


@pytest.mark.parametrize("entry", [PANDA, ARM, CART], ids=lambda entry: entry["model"])
def test_control_points_move_as_their_jacobians_say(entry: dict[str, Any]) -> None:
    robot = spatial_robot(entry)
    points = SpatialControlPoints(robot, 0.1, 0.3)
    q = np.random.default_rng(1).uniform(-1.0, 1.0, robot.dof)
    _, jacobians = points.at(q)
    for joint in range(robot.dof):
        step = np.zeros(robot.dof)
        step[joint] = 1e-6
        slope = (points.at(q + step)[0] - points.at(q - step)[0]) / 2e-6
        assert slope == pytest.approx(jacobians[:, :, joint], abs=1e-6)


def test_control_points_of_an_arm_lie_on_its_axis() -> None:
    points = SpatialControlPoints(spatial_robot(ARM), 0.1, 0.3)
    positions, _ = points.at(np.zeros(3))
    assert positions[:, 1:] == pytest.approx(np.zeros((len(positions), 2)))
    assert positions[:, 0].max() == pytest.approx(1.2)
    assert set(points.radii) == {0.05}


def test_pairs_of_capsules_that_mostly_overlap_are_left_out() -> None:
    robot = spatial_robot(PANDA, self_collision_pairs=[["panda_link5", "panda_link7"], ["panda_link0", "panda_hand"]])
    points = SpatialControlPoints(robot, 0.1, 0.3)
    own = SpatialSelfDistances(robot, points, 0.05)
    assert len(own.least(points.at(np.zeros(7))[0])) == 1
