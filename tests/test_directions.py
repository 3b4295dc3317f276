"""Directions have length one, whatever the length of the vector: from subnormal numbers to the largest ones."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pytest_lpb.environment.camera import Camera
from pytest_lpb.motion.directions import LONGEST, SHORTEST, lengths, scaled, unit
from pytest_lpb.motion.motion import FixedMotion
from pytest_lpb.motion.normalised import NormalisedMotion
from pytest_lpb.motion.rotation import AxisTurn
from pytest_lpb.planner.base import ObstacleInfo
from pytest_lpb.planner.fields import ObstacleField
from pytest_lpb.planner.files import find_planners
from pytest_lpb.planner.spatial_fields import SpatialObstacleField
from pytest_lpb.problem.planar.geometry import segment_to_box
from pytest_lpb.problem.spatial.rotations import from_axis_angle, normalised
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.problem.entries import CART, POINT, Entry, circle, position_goal, problem_entry

Array = NDArray[np.float64]

TINIEST, LARGEST = 5e-324, 1.7e308
NUMBER = st.floats(allow_nan=False, allow_infinity=False)
# Of the sizes that squares cannot have, more often than chance would.
ANY = st.one_of(
    NUMBER, st.floats(-1e-300, 1e-300), st.floats(-1e-150, 1e-150), st.sampled_from([0.0, TINIEST, LARGEST])
)


@given(st.lists(st.tuples(ANY, ANY, ANY), min_size=1, max_size=4), st.integers(2, 3))
@example([(TINIEST, TINIEST, 0.0)], 2)  # over its rounded length it was (1, 1)
@example([(1e-170, 1e-170, 1e-170)], 3)
@example([(LARGEST, LARGEST, LARGEST)], 3)
@example([(0.0, 0.0, 0.0), (3.0, 4.0, 0.0)], 3)
def test_unit_vectors_have_length_one_and_their_direction(rows: list[tuple[float, ...]], size: int) -> None:
    vectors = np.array(rows)[:, :size]
    found = unit(vectors, lengths(vectors))
    assert lengths(found) == pytest.approx(np.ones(len(rows)), abs=1e-12)
    for row, direction in zip(vectors.tolist(), found.tolist(), strict=True):
        largest = max(map(abs, row))
        if largest == 0.0:
            assert direction == [1.0, *[0.0] * (size - 1)]
        else:
            reduced = [value / largest for value in row]
            assert direction == pytest.approx([value / math.hypot(*reduced) for value in reduced], abs=1e-12)


@given(st.lists(st.tuples(*[st.floats(-1e100, 1e100)] * 3), min_size=1, max_size=4))
def test_usual_vectors_are_divided_as_they_are(rows: list[tuple[float, ...]]) -> None:
    vectors = np.array(rows)
    length = np.sqrt((vectors * vectors).sum(axis=-1))
    same, same_length = scaled(vectors, length)
    usual = (length > SHORTEST) & (length < LONGEST)
    assert np.array_equal(same[usual], vectors[usual])
    assert np.array_equal(same_length[usual], length[usual])


@given(st.tuples(ANY, ANY, ANY))
@example((TINIEST, TINIEST, TINIEST))
@example((1e200, 1e-200, 0.0))
def test_lengths_are_right_where_squares_are_not(vector: tuple[float, ...]) -> None:
    exact = math.hypot(*vector)
    assert float(lengths(np.array([vector]))[0]) == pytest.approx(exact, rel=1e-12, abs=2 * TINIEST)


@given(st.tuples(ANY, ANY, ANY, ANY).filter(any))
@example((TINIEST, TINIEST, 0.0, 0.0))
@example((LARGEST, 0.0, 0.0, -LARGEST))
def test_quaternions_of_any_length(quaternion: tuple[float, ...]) -> None:
    assert math.hypot(*normalised(quaternion)) == pytest.approx(1.0, abs=1e-12)
    motion = NormalisedMotion(FixedMotion(list(quaternion)))
    assert lengths(motion.evaluate(np.zeros(1))[0]) == pytest.approx(1.0, abs=1e-12)


def test_a_quaternion_of_zeros_is_no_rotation() -> None:
    with pytest.raises(ZeroDivisionError):
        normalised((0.0, 0.0, 0.0, 0.0))
    assert np.isnan(NormalisedMotion(FixedMotion([0.0] * 4)).evaluate(np.zeros(1))[0]).all()


@given(st.tuples(ANY, ANY, ANY).filter(any), st.floats(-7.0, 7.0))
@example((TINIEST, TINIEST, 0.0), 1.0)
@example((LARGEST, LARGEST, LARGEST), 1.0)
def test_turns_about_axes_of_any_length(axis: tuple[float, ...], angle: float) -> None:
    assert math.hypot(*from_axis_angle(axis, angle)) == pytest.approx(1.0, abs=1e-12)
    assert lengths(AxisTurn(axis, angle).evaluate(np.zeros(1))[0]) == pytest.approx(1.0, abs=1e-12)


OFFSET = st.one_of(st.floats(-3.0, 3.0), st.floats(-1e-12, 1e-12), st.floats(-1e-300, 1e-300), st.just(0.0))
SHAPES_3D = [
    ObstacleInfo("sphere", "sphere", 0.5, None, False),
    ObstacleInfo("box", "box", None, (1.0, 0.6, 0.4), False),
    ObstacleInfo("capsule", "capsule", 0.3, None, False, 0.8),
    ObstacleInfo("cylinder", "cylinder", 0.3, None, False, 0.8),
]
CORNERS = [[0.0, 0.0, 0.0], [0.5, 0.3, 0.2], [0.0, 0.0, 0.4], [0.3, 0.0, 0.4]]  # where directions change


@given(st.tuples(OFFSET, OFFSET, OFFSET))
@example((TINIEST, TINIEST, TINIEST))
@example((1e-170, 1e-170, 0.0))
@example((1e-13, 0.0, 0.0))
def test_ways_out_of_shapes_in_space_have_length_one(offset: tuple[float, ...]) -> None:
    field = SpatialObstacleField(SHAPES_3D)
    seen = {"obstacle_position": np.zeros((4, 3)), "obstacle_orientation": np.tile([1.0, 0.0, 0.0, 0.0], (4, 1))}
    points = np.array(CORNERS) + np.array(offset)
    distance, away = field.distances(points, seen)
    assert lengths(away) == pytest.approx(np.ones(distance.shape), abs=1e-12)


@given(st.tuples(OFFSET, OFFSET), st.floats(-4.0, 4.0))
@example((TINIEST, TINIEST), 0.0)
@example((5e-324, 0.0), 1.0)
def test_ways_out_of_shapes_in_the_plane_have_length_one(offset: tuple[float, ...], angle: float) -> None:
    obstacles = [
        ObstacleInfo("disc", "circle", 0.5, None, False),
        ObstacleInfo("box", "rectangle", None, (1.0, 0.6), False),
    ]
    for present in (obstacles, obstacles[:1]):
        count = len(present)
        seen = {"obstacle_position": np.zeros((count, 2)), "obstacle_orientation": np.full(count, angle)}
        corner = (0.5 * math.cos(angle) - 0.3 * math.sin(angle), 0.5 * math.sin(angle) + 0.3 * math.cos(angle))
        points = np.array([offset, np.array(corner) + np.array(offset)])
        distance, away = ObstacleField(present).distances(points, seen)
        assert lengths(away) == pytest.approx(np.ones(distance.shape), abs=1e-12)


@given(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.sampled_from([TINIEST, 1e-310, 1e-300]))
@example(0.3, 0.3, TINIEST)
def test_a_segment_of_hardly_any_length_is_a_point(x: float, y: float, length: float) -> None:
    point = segment_to_box(x, y, x, y, 0.5, 0.5)
    assert segment_to_box(x, y, x + length, y + length, 0.5, 0.5) == pytest.approx(point, abs=1e-12)
    assert segment_to_box(0.0, 0.0, length, length, 0.5, 0.5) == pytest.approx(-0.5, abs=1e-12)


@pytest.mark.parametrize("height", [1.0, -1.0, 1e-200, 0.0])
def test_a_camera_above_looks_straight_down(height: float) -> None:
    axes = Camera(np.array([0.0, 0.0, height]), np.zeros(3), 40, 30).axes
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)


@pytest.mark.parametrize("planner", ["pd", "potential_field", "fabrics", "mpc"])
@pytest.mark.parametrize("robot", [POINT, CART], ids=["point", "cart"])
def test_planners_act_at_hardly_any_distance(planner: str, robot: Entry) -> None:
    """At the goal, and in the middle of obstacles: no direction is not a number."""
    configuration = find_planners([planner], [])[0]
    link = "body" if robot is POINT else "base"
    box = {"name": "box", "shape": "rectangle", "size": [0.4, 0.4], "position": [0.0, 0.0]}
    for offset in (0.0, TINIEST, -1e-300, 1e-170, 1e-13):
        entry = problem_entry(
            {**robot, "limits": {"acceleration": [[-2.0, 2.0], [-2.0, 2.0]]}},
            goal=[position_goal([0.0, 0.0], link)],
            obstacles=[circle(0.0, 0.0, 0.3), box],
            q=[offset, offset] if robot is POINT else [offset, offset, 0.0],
            end_at=[],
            duration=0.1,
        )
        trajectory = run_trial(TrialSpecification(entry, configuration))
        assert trajectory.outcome == "collision", (offset, trajectory.metadata["message"])
        assert np.isfinite(trajectory.action[:-1]).all()
