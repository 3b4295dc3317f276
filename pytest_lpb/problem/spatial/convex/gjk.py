"""Distance of two convex sets by support points: the algorithm of Gilbert, Johnson and Keerthi.

Their distance is that of the origin from the set of all differences of their points. A simplex of at most four such
differences is moved towards the origin; each new support point proves a lower bound of the distance, the simplex an
upper one (Gilbert, Johnson, Keerthi, A fast procedure for computing the distance between complex objects in
three-dimensional space, 1988). The nearest point of a simplex is found from signed areas and volumes of its faces,
which is safe where linear equations are nearly singular (Montanari, Petrinic, Barbieri, Improving the GJK algorithm
for faster and more reliable distance queries between convex objects, 2017).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from math import sqrt

from pytest_lpb.problem.spatial.convex.cores import Point

Support = Callable[[float, float, float], Point]  # the farthest point along a direction
Nearest = tuple[float, Point, tuple[Point, ...]]  # squared distance from the origin, point, the vertices it needs

TOLERANCE_M = 1e-9  # [m] between upper and lower bound at which the distance is known
TOUCHING_M = 1e-9  # [m] below which the direction to the origin is not known any more
MAX_POINTS = 200  # support points; a dozen suffice for polytopes, some dozens for curved faces
FLAT = 1e-24  # squared, relative: of triangles and tetrahedra whose sides count as their faces and edges only


def separation(support: Support) -> float | None:
    """Distance of the origin from the convex set that has these support points [m]; None where it is inside."""
    start = support(1.0, 0.0, 0.0)
    least, point = _dot(start, start), start
    simplex: tuple[Point, ...] = (start,)
    lower = 0.0
    for _ in range(MAX_POINTS):
        upper = sqrt(least)
        if upper < TOUCHING_M:
            return None
        x, y, z = point
        found = support(-x, -y, -z)
        lower = max(lower, _dot(point, found) / upper)
        if upper - lower < TOLERANCE_M or found in simplex:
            return upper
        nearest = _nearest((*simplex, found))
        if nearest is None:
            return None
        if nearest[0] >= least:  # as near as numbers can tell
            return upper if lower > 0.0 else None
        least, point, simplex = nearest
    return upper if lower > 0.0 else None


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def minus(a: Point, b: Point) -> Point:
    """The difference of two vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def cross(a: Point, b: Point) -> Point:
    """The vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _nearest(simplex: Sequence[Point]) -> Nearest | None:
    """The point of a simplex of two to four vertices nearest to the origin; None where that is inside of four."""
    if len(simplex) == 2:
        return _of_segment(simplex[0], simplex[1])
    if len(simplex) == 3:
        return _of_triangle(simplex[0], simplex[1], simplex[2])
    return _of_tetrahedron(simplex)


def _of_segment(a: Point, b: Point) -> Nearest:
    side = minus(b, a)
    length = _dot(side, side)
    share = -_dot(a, side) / length if length > 0.0 else 0.0
    if share <= 0.0:
        return _dot(a, a), a, (a,)
    if share >= 1.0:
        return _dot(b, b), b, (b,)
    point = a[0] + share * side[0], a[1] + share * side[1], a[2] + share * side[2]
    return _dot(point, point), point, (a, b)


def _of_triangle(a: Point, b: Point, c: Point) -> Nearest:
    first, second = minus(b, a), minus(c, a)
    normal = cross(first, second)
    size = _dot(normal, normal)
    if (
        size > FLAT * _dot(first, first) * _dot(second, second)
        and _dot(normal, cross(a, b)) > 0.0
        and _dot(normal, cross(b, c)) > 0.0
        and _dot(normal, cross(c, a)) > 0.0
    ):
        height = _dot(a, normal)
        share = height / size
        return height * share, (share * normal[0], share * normal[1], share * normal[2]), (a, b, c)
    return min(_of_segment(a, b), _of_segment(b, c), _of_segment(c, a), key=_squared)


def _of_tetrahedron(simplex: Sequence[Point]) -> Nearest | None:
    """Of the faces that the origin is beyond, the nearest one decides."""
    best: Nearest | None = None
    for (a, b, c), fourth in zip(combinations(simplex, 3), reversed(simplex), strict=True):
        first, second, third = minus(b, a), minus(c, a), minus(fourth, a)
        normal = cross(first, second)
        inwards = _dot(normal, third)
        flat = inwards * inwards <= FLAT * _dot(normal, normal) * _dot(third, third)
        if flat or _dot(normal, a) * inwards > 0.0:
            found = _of_triangle(a, b, c)
            if best is None or found[0] < best[0]:
                best = found
    return best


def _squared(nearest: Nearest) -> float:
    return nearest[0]
