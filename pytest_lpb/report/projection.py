"""From the world to the plane of a picture: planar worlds as they are, spatial ones from above and from the side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
LETTERS = "xyz"


@dataclass(frozen=True)
class Projection:
    """Along a world axis, onto the plane of two others.

    Attributes:
        title: what is seen; empty where there is nothing else to see.
        axes: those drawn to the right and up.
    """

    title: str
    axes: tuple[int, int]

    @property
    def letters(self) -> str:
        """Names of the axes drawn, such as `xy`."""
        return "".join(LETTERS[axis] for axis in self.axes)

    def of(self, points: FloatArray) -> FloatArray:
        """Points (..., 2 or 3) [m] as they are seen, (..., 2) [m]."""
        return np.asarray(points[..., self.axes])


@dataclass(frozen=True)
class Disc:
    """A round outline: centre (2,) [m] and radius [m]."""

    centre: FloatArray
    radius: float


Outline = Disc | FloatArray  # a disc, or the corners (N, 2) [m] of a polygon

# What is drawn of problems of a dimension.
PROJECTIONS: dict[int, tuple[Projection, ...]] = {
    2: (Projection("", (0, 1)),),
    3: (Projection("seen from above", (0, 1)), Projection("seen from the side", (0, 2))),
}


def corners_of(outline: Outline) -> FloatArray:
    """Corners (N, 2) [m] of an outline; of a disc, those of the square around it."""
    if isinstance(outline, Disc):
        return outline.centre + outline.radius * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return outline


def convex_hull(points: FloatArray) -> FloatArray:
    """Corners (M, 2) of the convex hull of points (N, 2), counter-clockwise (Andrew's monotone chain, 1979)."""
    ordered = np.unique(points, axis=0).tolist()
    if len(ordered) < 3:
        return np.array(ordered)
    return np.array(_chain(ordered)[:-1] + _chain(ordered[::-1])[:-1])


def _chain(points: list[list[float]]) -> list[list[float]]:
    """The right-hand half of the hull of points in order, both ends included."""
    chain: list[list[float]] = []
    for x, y in points:
        while len(chain) > 1:
            (ax, ay), (bx, by) = chain[-2:]
            if (bx - ax) * (y - ay) > (by - ay) * (x - ax):
                break
            chain.pop()
        chain.append([x, y])
    return chain
