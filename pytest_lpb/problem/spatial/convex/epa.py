"""How deep two convex sets overlap: the expanding polytope algorithm (van den Bergen, 2001).

The depth is the least distance along which they are apart: the least, over all directions, of how far the set of all
differences of their points reaches. A polytope of support points grows within that set at the face that reaches least.
Its faces need not hold the origin to begin with: their signed distances from it are compared.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from pytest_lpb.problem.spatial.convex.cores import Point
from pytest_lpb.problem.spatial.convex.gjk import Support, cross, minus

TOLERANCE_M = 1e-9  # [m] between upper and lower bound at which the depth is known
MAX_POINTS = 160  # support points; faces of a thousand more would move depths by 1e-7 of the size
FLAT_M = 1e-12  # [m] extents below which a set has no inside
SEEN_M = 1e-12  # [m] above a face from which it is seen

Face = tuple[int, int, int]


def depth(support: Support) -> float:
    """Least distance that takes the origin out of a convex set [m]; below zero as far as it is outside of a face."""
    polytope = _Polytope(support)
    least = polytope.reach
    for _ in range(MAX_POINTS if polytope.faces else 0):
        face = int(polytope.offsets[: len(polytope.faces)].argmin())
        normal = polytope.normals[face].tolist()
        point = support(*normal)
        reach = point[0] * normal[0] + point[1] * normal[1] + point[2] * normal[2]
        least = min(least, reach)
        if least - polytope.offsets[face] < TOLERANCE_M:
            break
        polytope.add(point)
    return least


class _Polytope:
    """The convex hull of support points: triangles, seen from outside counter-clockwise.

    Attributes:
        faces: indices of vertices, also of faces that are gone.
        normals, offsets: unit normals, and distances of faces from the origin along them [m]; inf of those gone.
        reach: the least distance [m] that any support point of the first simplex shows.
    """

    def __init__(self, support: Support) -> None:
        self.faces: list[Face] = []
        self.reach = inf
        self._support = support
        self._vertices: list[Point] = []
        room = 8 * MAX_POINTS
        self.normals = np.zeros((room, 3))
        self.offsets = np.full(room, inf)
        if self._found_simplex():
            a, b, c, d = self._vertices
            outwards = _scalar(cross(minus(b, a), minus(c, a)), minus(d, a)) < 0.0
            for face in ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)):
                self._append(face if outwards else (face[0], face[2], face[1]))

    def _found_simplex(self) -> bool:
        """Start with a tetrahedron; False for a set that is flat."""
        self._vertices.append(self._support(1.0, 0.0, 0.0))
        while len(self._vertices) < 4:
            best, point = FLAT_M, None
            for direction in self._across():
                extent, found = self._farthest(direction)
                if extent > best:
                    best, point = extent, found
            if point is None:
                self.reach = min(self.reach, 0.0)
                return False
            self._vertices.append(point)
        return True

    def _across(self) -> list[Point]:
        """Unit directions away from what the vertices span so far."""
        a, *others = self._vertices
        if len(others) == 2:
            return [_unit(cross(minus(others[0], a), minus(others[1], a)))]
        if not others:
            return [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
        line = minus(others[0], a)
        least = min(range(3), key=lambda axis: abs(line[axis]))
        axis = (float(least == 0), float(least == 1), float(least == 2))
        first = _unit(cross(line, axis))
        return [first, _unit(cross(line, first))]

    def _farthest(self, direction: Point) -> tuple[float, Point]:
        """The farther of the support points both ways along a direction, and how far that is from the vertices [m]."""
        start = _scalar(self._vertices[0], direction)
        ahead = self._support(*direction)
        back = self._support(-direction[0], -direction[1], -direction[2])
        reach, behind = _scalar(ahead, direction), _scalar(back, direction)
        self.reach = min(self.reach, reach, -behind)
        return (reach - start, ahead) if reach - start >= start - behind else (start - behind, back)

    def add(self, point: Point) -> None:
        """Take in a point outside: the faces that see it give way to those that join it with their rim."""
        count = len(self.faces)
        heights = self.normals[:count] @ point - self.offsets[:count]
        self._vertices.append(point)
        seen = np.flatnonzero(heights > SEEN_M).tolist()
        edges = dict.fromkeys(edge for face in seen for edge in _edges(self.faces[face]))
        self.offsets[seen] = inf
        for start, end in edges:
            if (end, start) not in edges:
                self._append((start, end, len(self._vertices) - 1))

    def _append(self, face: Face) -> None:
        a, b, c = (self._vertices[index] for index in face)
        normal = cross(minus(b, a), minus(c, a))
        size = sqrt(_scalar(normal, normal))
        index = len(self.faces)
        if index == len(self.offsets):
            self.normals = np.vstack([self.normals, np.zeros_like(self.normals)])
            self.offsets = np.concatenate([self.offsets, np.full(index, inf)])
        self.faces.append(face)
        if size > 0.0:
            normal = normal[0] / size, normal[1] / size, normal[2] / size
            self.normals[index] = normal
            self.offsets[index] = max(_scalar(normal, a), _scalar(normal, b), _scalar(normal, c))


def _edges(face: Face) -> tuple[tuple[int, int], ...]:
    a, b, c = face
    return (a, b), (b, c), (c, a)


def _scalar(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _unit(vector: Point) -> Point:
    length = sqrt(_scalar(vector, vector))
    return vector[0] / length, vector[1] / length, vector[2] / length
