"""Pictures of a trial while it runs: the seam between environment and what draws. One class per dimension."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from time import perf_counter, sleep
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import LpbError
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray

# Dimension -> "module:Class".
PICTURES: dict[int, str] = {
    2: "pytest_lpb.environment.planar_picture:PlanarPicture",
    3: "pytest_lpb.environment.spatial_picture:SpatialPicture",
}


class Picture(Protocol):
    """Draws robot, goal, obstacles and the path so far.

    Args:
        show: whether in a window, in real time; raises LpbError where there is no display.
        around: places (N, 2 or 3) [m] to be held in the picture besides start, goal and obstacles.
    """

    def __init__(self, *, show: bool, around: FloatArray | None = None) -> None: ...

    def draw(self, problem: Problem, row: int, q: list[float]) -> NDArray[np.uint8] | None:
        """Draw a row at the joint positions q (dof,); (height, width, 3) without a window, None with one."""

    def close(self) -> None:
        """Close the window; again is no harm."""


class RealTime:
    """Waits so that simulated seconds take as long as real ones."""

    def __init__(self) -> None:
        self._started = perf_counter()

    def restart(self, t: float) -> None:
        """It is the simulated time t [s] now."""
        self._started = perf_counter() - t

    def wait_for(self, t: float) -> None:
        """Wait until the simulated time t [s]. Time lost is not made up for: who is late starts anew."""
        ahead = self._started + t - perf_counter()
        if ahead > 0.0:
            sleep(ahead)
        else:
            self._started -= ahead


def picture_for(dimension: int, *, show: bool, around: FloatArray | None = None) -> Picture:
    """The picture of problems of a dimension. Raises LpbError when `show` and there is no display."""
    module, _, name = PICTURES[dimension].partition(":")
    picture: Picture = getattr(import_module(module), name)(show=show, around=around)
    return picture


def check_display() -> None:
    """Raise LpbError where no window can be opened."""
    # Windows and macOS have a display of their own.
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise LpbError(
            "--lpb-render (render_mode 'human') needs a display, and there is none (DISPLAY is not set): run it on a "
            "desktop, use render_mode 'rgb_array', or make a video of a finished run: lpb-report RUN --trial NODEID "
            "--video out.mp4"
        )
