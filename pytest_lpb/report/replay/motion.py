"""What differs between replays in the plane and in space. One class per dimension."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle
    from pytest_lpb.problem.robot import Robot

FloatArray = NDArray[np.float64]

# Dimension -> "module:Class".
MOTIONS: dict[int, str] = {
    2: "pytest_lpb.report.replay.planar:PlanarMotion",
    3: "pytest_lpb.report.replay.spatial:SpatialMotion",
}


class Motion(Protocol):
    """Geometry in the frames of bodies, and where these frames are: poses are rows of numbers.

    In the plane x, y [m] and the angle [rad]; in space x, y, z [m] and a quaternion wxyz.
    """

    meshes: list[Path]  # files that parts refer to by their place, in the order in which they were met

    def extent(self, robot: Robot, q: FloatArray) -> FloatArray:
        """Points (M, 2 or 3) [m] around what collides of a robot, at q (N, dof)."""

    def heading(self, robot: Robot) -> list[Any] | None:
        """Place of the body along whose x-axis the base heads, and the length of its arrow [m]; None without one."""

    def robot(self, robot: Robot) -> list[Any]:
        """Parts of a robot, each with the place of its body in `poses`."""

    def poses(self, robot: Robot, q: FloatArray) -> FloatArray:
        """Poses (N, bodies, numbers) of the bodies that have parts, at q (N, dof)."""

    def obstacle(self, obstacle: Obstacle) -> list[Any]:
        """Parts of an obstacle in its own frame."""

    def obstacle_poses(self, obstacle: Obstacle, t: FloatArray) -> FloatArray:
        """Poses (N, numbers) of an obstacle at times t (N,) [s]."""

    def around(self, obstacle: Obstacle, t: FloatArray) -> FloatArray:
        """Points (M, 2 or 3) [m] around an obstacle at times t (N,) [s]."""


def motion_for(dimension: int) -> Motion:
    """How trials of a dimension are replayed."""
    module, _, name = MOTIONS[dimension].partition(":")
    motion: Motion = getattr(import_module(module), name)()
    return motion
