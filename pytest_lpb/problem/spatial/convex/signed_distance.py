"""Signed distance of two bodies that are unions of convex shapes."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from pytest_lpb.problem.spatial.convex.cores import Core, Point
from pytest_lpb.problem.spatial.convex.epa import depth
from pytest_lpb.problem.spatial.convex.gjk import separation


def signed_distance(first: Sequence[Core], second: Sequence[Core]) -> float:
    """The least signed distance [m] of any shape of one body from any of the other, in the same frame.

    That of two convex shapes is the largest separation over all directions: their distance where they are apart, and
    minus the shortest way out of each other where they overlap.
    """
    if len(first) == len(second) == 1:
        return _of_cores(first[0], second[0])
    spheres = [core.bounding_sphere() for core in first], [core.bounding_sphere() for core in second]
    pairs = []
    for one, (centre, radius) in zip(first, spheres[0], strict=True):
        for other, (place, size) in zip(second, spheres[1], strict=True):
            gap = centre - place
            pairs.append((sqrt(float(gap @ gap)) - radius - size, one, other))
    pairs.sort(key=lambda pair: pair[0])
    least = float("inf")
    for bound, one, other in pairs:
        if bound < least:
            least = min(least, _of_cores(one, other))
    return least


def _of_cores(one: Core, other: Core) -> float:
    first, second = one.support, other.support

    def support(x: float, y: float, z: float) -> Point:
        a, b = first(x, y, z), second(-x, -y, -z)
        return a[0] - b[0], a[1] - b[1], a[2] - b[2]

    apart = separation(support)
    distance = -depth(support) if apart is None else apart
    return distance - one.radius - other.radius
