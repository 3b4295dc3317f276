"""Convex shapes by their formulas, and what proves a distance between two of them. No engine is involved.

Of two convex shapes the signed distance is the largest separation over all directions: how far apart they are along
the direction, negative where they overlap along it. Any direction therefore proves a lower bound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, eq=False)
class Convex:
    """A convex shape at the origin.

    Attributes:
        support: largest coordinates (k,) of the shape along directions (k, 3) [m].
        normals: of its faces and axes (m, 3).
        edges: their directions (k, 3).
        radius: [m] of a sphere around the origin that holds it.
    """

    support: Callable[[Array], Array]
    normals: Array
    edges: Array
    radius: float


@dataclass(frozen=True, eq=False)
class Placed:
    """A shape at a pose (4, 4)."""

    shape: Convex
    pose: Array

    def support(self, directions: Array) -> Array:
        """As of the shape."""
        found: Array = self.shape.support(directions @ self.pose[:3, :3]) + directions @ self.pose[:3, 3]
        return found

    @property
    def normals(self) -> Array:
        """As of the shape."""
        found: Array = self.shape.normals @ self.pose[:3, :3].T
        return found

    @property
    def edges(self) -> Array:
        """As of the shape."""
        found: Array = self.shape.edges @ self.pose[:3, :3].T
        return found


def separation(one: Placed, other: Placed, directions: Array) -> Array:
    """How far `one` is beyond `other` along each of unit directions (k, 3) [m]."""
    return -one.support(-directions) - other.support(directions)


NONE = np.zeros((0, 3))
AXIS = np.eye(3)[2:]


def sphere(radius: float) -> Convex:
    return Convex(lambda n: radius * np.linalg.norm(n, axis=1), NONE, NONE, radius)


def capsule(radius: float, length: float) -> Convex:
    def support(n: Array) -> Array:
        found: Array = radius * np.linalg.norm(n, axis=1) + 0.5 * length * np.abs(n[:, 2])
        return found

    return Convex(support, NONE, AXIS, radius + 0.5 * length)


def cylinder(radius: float, length: float) -> Convex:
    def support(n: Array) -> Array:
        found: Array = radius * np.hypot(n[:, 0], n[:, 1]) + 0.5 * length * np.abs(n[:, 2])
        return found

    return Convex(support, AXIS, AXIS, float(np.hypot(radius, 0.5 * length)))


def box(size: list[float]) -> Convex:
    half = 0.5 * np.array(size)
    return Convex(lambda n: np.abs(n) @ half, np.eye(3), np.eye(3), float(np.linalg.norm(half)))


def hull(vertices: Array) -> Convex:
    """The convex hull of vertices (n, 3)."""
    from scipy.spatial import ConvexHull

    found = ConvexHull(vertices)
    corners = vertices[found.simplices]
    edges = np.vstack([corners[:, i] - corners[:, j] for i, j in ((0, 1), (1, 2), (2, 0))])
    edges /= np.linalg.norm(edges, axis=1)[:, None]

    def support(n: Array) -> Array:
        value: Array = (n @ vertices.T).max(axis=1)
        return value

    return Convex(support, found.equations[:, :3], edges[::2], float(np.linalg.norm(vertices, axis=1).max()))


def signed_distance(one: Placed, other: Placed, near: Array) -> float:
    """The largest separation of two shapes [m], found from many directions, and from `near` (3,)."""
    directions = _directions_of(one, other, near)
    values = separation(one, other, directions)
    return max(_climbed(one, other, directions[index]) for index in np.argsort(values)[-3:])


def _climbed(one: Placed, other: Placed, direction: Array) -> float:
    """The separation along the best direction that ever smaller steps from one lead to [m]."""
    best = float(separation(one, other, direction[None])[0])
    for number, step in enumerate(np.logspace(-1.0, -8.5, 80)):
        around = direction + step * _SPREAD[5 * number % 16 :: 16]  # others each time: ridges are narrow
        around /= np.linalg.norm(around, axis=1)[:, None]
        values = separation(one, other, around)
        index = int(values.argmax())
        if values[index] > best:
            best, direction = float(values[index]), around[index]
    return best


def _directions_of(one: Placed, other: Placed, near: Array) -> Array:
    """Unit directions (k, 3) among which the largest separation is, or nearly so.

    Normals of faces, what is across edges of both, that to each other's centre, many that are evenly spread, `near`.
    """
    normals = np.vstack([one.normals, other.normals])
    across = np.cross(one.edges[:, None], other.edges[None]).reshape(-1, 3)
    edges = np.vstack([one.edges, other.edges])
    from_edges = np.cross(edges[:, None], _SPREAD[None, ::16]).reshape(-1, 3) if len(edges) < 8 else NONE
    centres = (one.pose[:3, 3] - other.pose[:3, 3])[None]
    found = np.vstack([normals, -normals, across, -across, from_edges, centres, near[None], _SPREAD])
    length = np.linalg.norm(found, axis=1)
    unit: Array = found[length > 1e-9] / length[length > 1e-9, None]
    return unit


def _spread(count: int) -> Array:
    """Directions spread evenly over all (a Fibonacci lattice)."""
    index = np.arange(count) + 0.5
    height, angle = 1.0 - 2.0 * index / count, np.pi * (1.0 + np.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - height * height)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


_SPREAD = _spread(512)
