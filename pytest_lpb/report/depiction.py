"""How problems of a dimension are drawn: outlines of obstacles, bodies of the robot. One class per dimension."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.report.canvas import Canvas
from pytest_lpb.report.projection import Outline, Projection
from pytest_lpb.report.view import Mark, PlannerStyle

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle
    from pytest_lpb.problem.robot import Robot
    from pytest_lpb.trajectory import Trajectory

FloatArray = NDArray[np.float64]

# Dimension -> "module:Class".
DEPICTIONS: dict[int, str] = {
    2: "pytest_lpb.report.planar_depiction:PlanarDepiction",
    3: "pytest_lpb.report.spatial_depiction:SpatialDepiction",
}


class Depiction(Protocol):
    """What differs between pictures of planar and spatial problems."""

    def outline(
        self, obstacle: Obstacle, position: FloatArray, orientation: FloatArray, projection: Projection
    ) -> Outline | None:
        """An obstacle's outline where it is placed, as it is seen; None when its file cannot be read any more."""

    def extent(self, trajectory: Trajectory, projection: Projection) -> FloatArray:
        """Points (N, 2) [m] around the robot at all rows with finite numbers, as they are seen."""

    def start(self, trajectory: Trajectory, projection: Projection) -> FloatArray:
        """Points (N, 2) [m] around the robot at the start that are in the picture however far paths run."""

    def has_ghosts(self, robot: Robot) -> bool:
        """Whether the robot's poses between start and end are worth drawing."""

    def robot(
        self, sheet: Sheet, trajectory: Trajectory, row: int, css: str, style: PlannerStyle | None
    ) -> Iterator[Mark]:
        """The robot at a row, as `start`, `ghost` or `final`."""


@dataclass(frozen=True)
class Sheet:
    """A canvas, how the world comes onto it, and how what is in the world is drawn."""

    canvas: Canvas
    projection: Projection
    depiction: Depiction

    def line(self, points: FloatArray) -> str:
        """SVG path through points (N, 2 or 3) [m]; empty when nothing finite is left."""
        return self.canvas.line(self.projection.of(points))

    def outline(self, obstacle: Obstacle, position: FloatArray, orientation: FloatArray) -> str:
        """SVG path of an obstacle; empty when nothing is known of it."""
        outline = self.depiction.outline(obstacle, position, orientation, self.projection)
        return "" if outline is None else self.canvas.outline(outline)


def depiction_for(dimension: int) -> Depiction:
    """How problems of a dimension are drawn."""
    module, _, name = DEPICTIONS[dimension].partition(":")
    depiction: Depiction = getattr(import_module(module), name)()
    return depiction
