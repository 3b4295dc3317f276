"""Shapes of planar obstacles, placed in the world. A new shape is one class here, in `SHAPES`, or a user's own."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, hypot, sin
from typing import Any, Protocol

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.planar.geometry import point_to_segment, segment_to_box
from pytest_lpb.problem.registries import shapes


class PlacedShape(Protocol):
    """A planar obstacle's shape at a pose in the world."""

    x: float  # [m]
    y: float  # [m]
    circumradius: float  # [m] of the disc around (x, y) that holds the shape

    def place(self, x: float, y: float, angle: float) -> None:
        """Move the shape: position [m] and angle [rad] in the world."""

    def distance_to_segment(self, ax: float, ay: float, bx: float, by: float) -> float:
        """Signed distance of the segment ab (world, [m]) to the shape [m]."""

    def outline(self) -> list[tuple[float, float]] | float:
        """Corners in the shape's frame [m], or the radius of a disc [m]: what a picture needs."""


class Circle:
    """A disc."""

    def __init__(self, entry: Mapping[str, Any]) -> None:
        self.radius = float(entry["radius"])
        self.circumradius = self.radius
        self.place(0.0, 0.0, 0.0)

    def place(self, x: float, y: float, angle: float) -> None:  # noqa: ARG002 - a disc has no orientation
        """Move the disc's centre to (x, y) [m]."""
        self.x, self.y = x, y

    def distance_to_segment(self, ax: float, ay: float, bx: float, by: float) -> float:
        """Signed distance of the segment ab (world, [m]) to the disc [m]."""
        if ax == bx and ay == by:
            return hypot(ax - self.x, ay - self.y) - self.radius
        return point_to_segment(self.x, self.y, ax, ay, bx, by) - self.radius

    def outline(self) -> float:
        """The radius [m]."""
        return self.radius


class Rectangle:
    """A rectangle of full lengths `size`, centred at its position."""

    def __init__(self, entry: Mapping[str, Any]) -> None:
        self.half = (0.5 * float(entry["size"][0]), 0.5 * float(entry["size"][1]))
        self.circumradius = hypot(*self.half)
        self.place(0.0, 0.0, 0.0)

    def place(self, x: float, y: float, angle: float) -> None:
        """Move the rectangle's centre to (x, y) [m], its first side along `angle` [rad]."""
        self.x, self.y = x, y
        self._cos, self._sin = cos(angle), sin(angle)

    def distance_to_segment(self, ax: float, ay: float, bx: float, by: float) -> float:
        """Signed distance of the segment ab (world, [m]) to the rectangle [m]."""
        c, s = self._cos, self._sin
        ax, ay, bx, by = ax - self.x, ay - self.y, bx - self.x, by - self.y
        return segment_to_box(
            c * ax + s * ay, c * ay - s * ax, c * bx + s * by, c * by - s * bx, self.half[0], self.half[1]
        )

    def outline(self) -> list[tuple[float, float]]:
        """The corners, counter-clockwise [m]."""
        hx, hy = self.half
        return [(hx, hy), (-hx, hy), (-hx, -hy), (hx, -hy)]


SHAPES: dict[str, type[Circle] | type[Rectangle]] = {"circle": Circle, "rectangle": Rectangle}


def planar_shape(entry: Mapping[str, Any]) -> PlacedShape:
    """The shape of an obstacle's entry. Raises ScenarioError for one that is unknown here."""
    built_in = SHAPES.get(entry["shape"])
    if built_in is not None:
        return built_in(entry)
    registered = shapes.get(entry["shape"])
    if registered is None:
        raise ScenarioError(f"unknown shape {entry['shape']!r}: what registers it is not loaded")
    shape: PlacedShape = registered.create(entry)
    return shape


def outline_of(shape: PlacedShape) -> list[tuple[float, float]] | float:
    """Corners of a shape in its frame [m], or the radius of a disc [m]: one around a shape that has no outline."""
    outline = getattr(shape, "outline", None)
    return float(shape.circumradius) if outline is None else outline()
