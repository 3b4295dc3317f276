"""Convex shapes by their support points: each is a core, grown by a sphere of `radius`.

Spheres and capsules are a point and a segment so grown; boxes, cylinders and convex hulls are their own cores.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import hypot, sqrt
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from pytest_lpb.problem.registries import FloatArray, registered_vertices
from pytest_lpb.problem.spatial.hulls import mesh_hulls

Point = tuple[float, float, float]

FEW = 12  # points among which a loop finds the farthest sooner than NumPy


class Core(Protocol):
    """A convex shape without the sphere by which it is grown."""

    @property
    def radius(self) -> float:
        """Of the sphere by which the core is grown [m]."""

    @property
    def round(self) -> bool:
        """Whether it is a sphere or capsule."""

    def support(self, x: float, y: float, z: float) -> Point:
        """A point of the core that is farthest along a direction of any length but zero."""

    def placed(self, turn: FloatArray, shift: FloatArray) -> Core:
        """The same after a turn, a matrix (3, 3), and a shift (3,) [m]."""

    def bounding_sphere(self) -> tuple[FloatArray, float]:
        """Centre (3,) and radius [m] of a sphere that holds the grown shape."""


@dataclass(frozen=True, eq=False)
class Points:
    """The convex hull of points (n, 3) [m]."""

    points: FloatArray
    radius: float = 0.0
    _few: list[Point] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_few", self.points.tolist() if len(self.points) <= FEW else [])

    @property
    def round(self) -> bool:
        """See `Core`."""
        return self.radius > 0.0

    def support(self, x: float, y: float, z: float) -> Point:
        """See `Core`."""
        if self._few:
            return max(self._few, key=lambda p: x * p[0] + y * p[1] + z * p[2])
        a, b, c = self.points[(self.points @ (x, y, z)).argmax()].tolist()
        return a, b, c

    def placed(self, turn: FloatArray, shift: FloatArray) -> Points:
        """See `Core`."""
        return Points(self.points @ turn.T + shift, self.radius)

    def bounding_sphere(self) -> tuple[FloatArray, float]:
        """See `Core`."""
        centre = 0.5 * (self.points.min(axis=0) + self.points.max(axis=0))
        return centre, sqrt(float(((self.points - centre) ** 2).sum(axis=1).max())) + self.radius


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder.

    Attributes:
        centre: its middle (3,) [m].
        axes: two unit vectors across, and the axis, as columns (3, 3).
        across, half: radius, and half of the length [m].
    """

    centre: FloatArray
    axes: FloatArray
    across: float
    half: float
    radius: float = 0.0
    round: bool = False
    _numbers: tuple[float, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_numbers", (*self.centre.tolist(), *self.axes.ravel().tolist()))

    def support(self, x: float, y: float, z: float) -> Point:
        """See `Core`."""
        cx, cy, cz, ux, vx, ax, uy, vy, ay, uz, vz, az = self._numbers
        u, v = x * ux + y * uy + z * uz, x * vx + y * vy + z * vz
        length = sqrt(u * u + v * v)
        if length > 0.0:
            u, v = self.across * u / length, self.across * v / length
        half = self.half if x * ax + y * ay + z * az > 0.0 else -self.half
        return cx + u * ux + v * vx + half * ax, cy + u * uy + v * vy + half * ay, cz + u * uz + v * vz + half * az

    def placed(self, turn: FloatArray, shift: FloatArray) -> Cylinder:
        """See `Core`."""
        return Cylinder(turn @ self.centre + shift, turn @ self.axes, self.across, self.half)

    def bounding_sphere(self) -> tuple[FloatArray, float]:
        """See `Core`."""
        return self.centre, hypot(self.across, self.half)


def _box(entry: Mapping[str, Any]) -> Points:
    corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
    return Points(corners * np.array(entry["size"], dtype=float))


def _capsule(entry: Mapping[str, Any]) -> Points:
    half = 0.5 * entry["length"]
    return Points(np.array([[0.0, 0.0, -half], [0.0, 0.0, half]]), float(entry["radius"]))


def _cylinder(entry: Mapping[str, Any]) -> Cylinder:
    return Cylinder(np.zeros(3), np.eye(3), float(entry["radius"]), 0.5 * entry["length"])


# As obstacles have them; all other shapes are vertices.
CORES: dict[str, Callable[[Mapping[str, Any]], Core]] = {
    "sphere": lambda entry: Points(np.zeros((1, 3)), float(entry["radius"])),
    "box": _box,
    "capsule": _capsule,
    "cylinder": _cylinder,
}


def cores_of(entry: Mapping[str, Any]) -> tuple[Core, ...]:
    """The cores of an obstacle at the origin, several of a mesh of several hulls; none of a concave mesh.

    Raises ScenarioError for a mesh that cannot be read.
    """
    if entry["shape"] in CORES:
        return (CORES[entry["shape"]](entry),)
    if entry["shape"] != "mesh":
        return (Points(registered_vertices(entry)),)
    if entry.get("concave"):
        return ()
    return tuple(Points(hull) for hull in mesh_hulls(Path(entry["file"]), (entry.get("scale", 1.0),) * 3))
