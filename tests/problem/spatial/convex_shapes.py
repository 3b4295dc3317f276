"""Convex shapes by their formulas, and what proves a distance between two of them. No engine is involved.

Of two convex shapes the signed distance is the largest separation over all directions: how far apart they are along
the direction, negative where they overlap along it. Any direction therefore proves a lower bound, and any point of
each shape an upper bound where they are apart.
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
        outside: how far a point (3,) is out of the shape at least, zero for one within [m].
        normals: of its faces and axes (m, 3).
        radius: [m] of a sphere around the origin that holds it.
    """

    support: Callable[[Array], Array]
    outside: Callable[[Array], float]
    normals: Array
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

    def outside(self, point: Array) -> float:
        """As of the shape."""
        return self.shape.outside(self.pose[:3, :3].T @ (point - self.pose[:3, 3]))

    @property
    def normals(self) -> Array:
        """As of the shape."""
        found: Array = self.shape.normals @ self.pose[:3, :3].T
        return found


def separation(one: Placed, other: Placed, directions: Array) -> Array:
    """How far `one` is beyond `other` along each of unit directions (k, 3) [m]."""
    return -one.support(-directions) - other.support(directions)


def sphere(radius: float) -> Convex:
    return Convex(
        lambda n: radius * np.linalg.norm(n, axis=1),
        lambda p: max(float(np.linalg.norm(p)) - radius, 0.0),
        np.zeros((0, 3)),
        radius,
    )


def capsule(radius: float, length: float) -> Convex:
    def outside(p: Array) -> float:
        along = np.clip(p[2], -0.5 * length, 0.5 * length)
        return max(float(np.linalg.norm(p - [0.0, 0.0, along])) - radius, 0.0)

    def support(n: Array) -> Array:
        found: Array = radius * np.linalg.norm(n, axis=1) + 0.5 * length * np.abs(n[:, 2])
        return found

    return Convex(support, outside, np.eye(3)[2:], radius + 0.5 * length)


def cylinder(radius: float, length: float) -> Convex:
    def outside(p: Array) -> float:
        gap = np.array([np.hypot(p[0], p[1]) - radius, abs(p[2]) - 0.5 * length])
        return float(np.linalg.norm(np.maximum(gap, 0.0)))

    def support(n: Array) -> Array:
        found: Array = radius * np.hypot(n[:, 0], n[:, 1]) + 0.5 * length * np.abs(n[:, 2])
        return found

    return Convex(support, outside, np.eye(3)[2:], float(np.hypot(radius, 0.5 * length)))


def box(size: list[float]) -> Convex:
    half = 0.5 * np.array(size)
    return Convex(
        lambda n: np.abs(n) @ half,
        lambda p: float(np.linalg.norm(np.maximum(np.abs(p) - half, 0.0))),
        np.eye(3),
        float(np.linalg.norm(half)),
    )


def hull(vertices: Array) -> Convex:
    """The convex hull of vertices (n, 3); `outside` of it is the largest distance to one of its faces' planes."""
    from scipy.spatial import ConvexHull

    planes = ConvexHull(vertices).equations

    def outside(p: Array) -> float:
        return max(float((planes[:, :3] @ p + planes[:, 3]).max()), 0.0)

    def support(n: Array) -> Array:
        found: Array = (n @ vertices.T).max(axis=1)
        return found

    return Convex(support, outside, planes[:, :3], float(np.linalg.norm(vertices, axis=1).max()))


def directions_of(one: Placed, other: Placed, near: Array) -> Array:
    """Unit directions (k, 3) among which the least overlap of two shapes is, or nearly so.

    Normals of faces, axes, what is across them, and many others, evenly spread and around `near` (3,).
    """
    special = np.vstack([one.normals, other.normals])
    across = np.cross(special[:, None], np.vstack([special, _SPREAD[::8]])[None]).reshape(-1, 3)
    centres = (one.pose[:3, 3] - other.pose[:3, 3])[None]
    found = np.vstack([special, -special, across, centres, _SPREAD, around(near)])
    length = np.linalg.norm(found, axis=1)
    unit: Array = found[length > 1e-9] / length[length > 1e-9, None]
    return unit


def around(direction: Array) -> Array:
    """Unit directions (k, 3) around one, ever nearer to it, and itself."""
    found = np.vstack([direction, (direction + _STEPS * _SPREAD[None, ::16]).reshape(-1, 3)])
    unit: Array = found / np.linalg.norm(found, axis=1)[:, None]
    return unit


_STEPS = np.logspace(-7, -0.5, 27)[:, None, None]


def _spread(count: int) -> Array:
    """Directions spread evenly over all (a Fibonacci lattice)."""
    index = np.arange(count) + 0.5
    height, angle = 1.0 - 2.0 * index / count, np.pi * (1.0 + np.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - height * height)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


_SPREAD = _spread(512)
