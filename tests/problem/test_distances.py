"""Signed distances against hand values, dense sampling, and the meaning of a penetration depth."""

from collections.abc import Callable
from math import cos, hypot, inf, nextafter, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pytest_lpb.problem.planar.geometry import point_to_segment, segment_to_box, segment_to_segment
from pytest_lpb.problem.planar.shapes import Circle, PlacedShape, Rectangle

Array = NDArray[np.float64]
Segment = tuple[float, float, float, float]

coordinates = st.floats(-3.0, 3.0)
segments = st.tuples(coordinates, coordinates, coordinates, coordinates)
angles = st.floats(-7.0, 7.0)
lengths = st.floats(0.05, 2.0)
SHARES = np.linspace(0.0, 1.0, 201)


def on_segment(segment: Segment, shares: Array = SHARES) -> Array:
    ax, ay, bx, by = segment
    return np.column_stack([ax + shares * (bx - ax), ay + shares * (by - ay)])


def length_of(segment: Segment) -> float:
    return hypot(segment[2] - segment[0], segment[3] - segment[1])


def moved(segment: Segment, angle: float, x: float, y: float) -> Segment:
    """Turned about the origin, then shifted."""
    c, s = cos(angle), sin(angle)
    ax, ay, bx, by = segment
    return c * ax - s * ay + x, s * ax + c * ay + y, c * bx - s * by + x, s * bx + c * by + y


def rectangle(width: float, height: float, x: float = 0.0, y: float = 0.0, angle: float = 0.0) -> Rectangle:
    shape = Rectangle({"size": [width, height]})
    shape.place(x, y, angle)
    return shape


def disc(radius: float, x: float = 0.0, y: float = 0.0) -> Circle:
    shape = Circle({"radius": radius})
    shape.place(x, y, 1.0)
    return shape


@pytest.mark.parametrize(
    ("point", "expected"), [((0.5, 2.0), 2.0), ((-3.0, 4.0), 5.0), ((4.0, -4.0), 5.0), ((0.3, 0.0), 0.0)]
)
def test_point_to_segment(point: tuple[float, float], expected: float) -> None:
    assert point_to_segment(*point, 0.0, 0.0, 1.0, 0.0) == pytest.approx(expected)
    assert point_to_segment(*point, 1.0, 0.0, 0.0, 0.0) == pytest.approx(expected)


def test_point_to_a_segment_without_length() -> None:
    assert point_to_segment(3.0, 4.0, 0.0, 0.0, 0.0, 0.0) == 5.0


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ((0.0, 0.0, 1.0, 0.0), (0.0, 2.0, 1.0, 2.0), 2.0),  # parallel
        ((0.0, 0.0, 1.0, 0.0), (2.0, 0.0, 3.0, 0.0), 1.0),  # collinear, apart
        ((0.0, 0.0, 2.0, 0.0), (1.0, 0.0, 3.0, 0.0), 0.0),  # collinear, overlapping
        ((0.0, 0.0, 1.0, 0.0), (4.0, 4.0, 9.0, 9.0), 5.0),  # ends
        ((0.0, 0.0, 2.0, 0.0), (1.0, 0.0, 1.0, 1.0), 0.0),  # touching in a T
        ((-1.0, 0.0, 1.0, 0.0), (0.0, -1.0, 0.0, 3.0), -1.0),  # a cross: out sideways past an end
        ((-1.0, 0.0, 1.0, 0.0), (0.25, -2.0, 0.25, 2.0), -0.75),
        ((-1.0, -1.0, 1.0, 1.0), (-1.0, 1.0, 1.0, -1.0), -sqrt(2.0)),
    ],
)
def test_segments_by_hand(first: Segment, second: Segment, expected: float) -> None:
    assert segment_to_segment(*first, *second) == pytest.approx(expected)
    assert segment_to_segment(*second, *first) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("segment", "expected"),
    [
        ((3.0, 0.0, 4.0, 0.0), 1.0),
        ((5.0, 5.0, 5.0, 5.0), 5.0),
        ((0.0, 3.0, 4.0, 1.0), 2.0 / sqrt(5.0)),  # the corner (2, 1) against the segment's middle
        ((0.0, 0.0, 0.0, 0.0), -1.0),  # a point at the centre
        ((1.5, 0.0, 1.5, 0.0), -0.5),
        ((-5.0, 0.5, 5.0, 0.5), -0.5),  # right through
        ((1.5, -5.0, 1.5, 5.0), -0.5),
        ((-2.0, 1.0, 2.0, 1.0), 0.0),  # along a side
    ],
)
def test_boxes_by_hand(segment: Segment, expected: float) -> None:
    assert segment_to_box(*segment, 2.0, 1.0) == pytest.approx(expected, abs=1e-15)


def test_discs_by_hand() -> None:
    shape = disc(0.5, 1.0, 1.0)
    assert shape.distance_to_segment(4.0, 5.0, 4.0, 5.0) == pytest.approx(4.5)
    assert shape.distance_to_segment(0.0, -1.0, 3.0, -1.0) == pytest.approx(1.5)
    assert shape.distance_to_segment(0.0, 1.0, 3.0, 1.0) == pytest.approx(-0.5)


@given(segments, segments)
def test_segments_against_samples(first: Segment, second: Segment) -> None:
    exact = segment_to_segment(*first, *second)
    gaps = np.hypot(*(on_segment(first)[:, None] - on_segment(second)[None, :]).transpose(2, 0, 1))
    spacing = (length_of(first) + length_of(second)) / (len(SHARES) - 1)
    assert max(exact, 0.0) - 1e-12 <= gaps.min() <= max(exact, 0.0) + spacing


@given(segments, lengths, lengths, coordinates, coordinates, angles)
def test_rectangles_against_samples(
    segment: Segment, width: float, height: float, x: float, y: float, angle: float
) -> None:
    exact = rectangle(width, height, x, y, angle).distance_to_segment(*segment)
    c, s = cos(angle), sin(angle)
    points = on_segment(segment) - np.array([x, y])
    local = np.column_stack([c * points[:, 0] + s * points[:, 1], c * points[:, 1] - s * points[:, 0]])
    beyond = np.abs(local) - 0.5 * np.array([width, height])
    nearest = np.hypot(*np.maximum(beyond, 0.0).T).min()
    spacing = length_of(segment) / (len(SHARES) - 1)
    assert max(exact, 0.0) - 1e-12 <= nearest <= max(exact, 0.0) + spacing
    if nearest == 0.0:  # a point inside is as deep as the nearest side is far, and the segment at least as deep
        assert exact <= beyond.max(axis=1).min() + 1e-12


@given(coordinates, coordinates, angles, angles, lengths, lengths, lengths, lengths)
def test_depth_of_crossing_segments_is_the_smallest_separating_translation(
    x: float, y: float, one: float, other: float, a: float, b: float, c: float, d: float
) -> None:
    assume(abs(sin(one - other)) > 0.05)
    first = (x - a * cos(one), y - a * sin(one), x + b * cos(one), y + b * sin(one))
    second = (x - c * cos(other), y - c * sin(other), x + d * cos(other), y + d * sin(other))
    depth = -segment_to_segment(*first, *second)
    assert depth > 0.0
    assert_smallest_translation(depth, first, lambda shifted: segment_to_segment(*shifted, *second))


@given(segments, lengths, lengths, angles)
def test_depth_in_a_rectangle_is_the_smallest_separating_translation(
    segment: Segment, width: float, height: float, angle: float
) -> None:
    shape = rectangle(width, height, 0.3, -0.2, angle)
    depth = -shape.distance_to_segment(*segment)
    assume(depth > 1e-3)
    assert_smallest_translation(depth, segment, lambda shifted: shape.distance_to_segment(*shifted))


@given(segments, lengths)
def test_depth_in_a_disc_is_the_smallest_separating_translation(segment: Segment, radius: float) -> None:
    shape = disc(radius)
    depth = -shape.distance_to_segment(*segment)
    assume(depth > 1e-3)
    assert_smallest_translation(depth, segment, lambda shifted: shape.distance_to_segment(*shifted))


def assert_smallest_translation(depth: float, segment: Segment, distance: Callable[[Segment], float]) -> None:
    """Moving by the depth frees the segment in the best direction; moving by less frees it in none."""
    turns = np.arange(720) * (2.0 * pi / 720)
    best_free = max(distance(moved(segment, 0.0, depth * cos(a), depth * sin(a))) for a in turns)
    assert best_free > -1e-4 * depth - 1e-12  # the best direction lies at most 0.25 degrees from a sampled one
    less = 0.995 * depth
    assert all(distance(moved(segment, 0.0, less * cos(a), less * sin(a))) < 0.0 for a in turns)


@given(segments, segments, angles, coordinates, coordinates)
def test_rigid_motion_changes_no_distance_of_segments(
    first: Segment, second: Segment, angle: float, x: float, y: float
) -> None:
    placed = (moved(first, angle, x, y), moved(second, angle, x, y))
    before, after = segment_to_segment(*first, *second), segment_to_segment(*placed[0], *placed[1])
    assert after == pytest.approx(before, abs=1e-9)


@given(segments, lengths, lengths, angles, coordinates, coordinates)
def test_rigid_motion_changes_no_distance_to_shapes(
    segment: Segment, width: float, height: float, angle: float, x: float, y: float
) -> None:
    pairs: list[tuple[PlacedShape, PlacedShape]] = [
        (rectangle(width, height), rectangle(width, height, x, y, angle)),
        (disc(width), disc(width, x, y)),
    ]
    for before, after in pairs:
        moved_distance = after.distance_to_segment(*moved(segment, angle, x, y))
        assert moved_distance == pytest.approx(before.distance_to_segment(*segment), abs=1e-9)


@given(segments, lengths, lengths, coordinates, coordinates, angles)
def test_the_circumscribed_disc_bounds_the_distance_from_below(
    segment: Segment, width: float, height: float, x: float, y: float, angle: float
) -> None:
    """Clearances skip pairs by this bound; it must hold inside too."""
    for shape in (rectangle(width, height, x, y, angle), disc(width, x, y)):
        middle = (0.5 * (segment[0] + segment[2]), 0.5 * (segment[1] + segment[3]))
        bound = hypot(shape.x - middle[0], shape.y - middle[1]) - shape.circumradius - 0.5 * length_of(segment)
        assert shape.distance_to_segment(*segment) >= bound - 1e-9


def test_contact_is_continuous() -> None:
    """No jump between touching and a first bit of penetration."""
    just_in = nextafter(2.0, -inf)
    assert abs(segment_to_box(just_in, 0.0, 9.0, 0.0, 2.0, 1.0)) < 1e-15
    assert abs(segment_to_segment(-1.0, 0.0, 1.0, 0.0, 0.0, -1e-16, 0.0, 5.0)) < 1e-15
