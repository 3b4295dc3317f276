"""How far obstacles move during each step: bounds, found in blocks like the motions themselves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pytest_lpb.environment.timeline import BLOCK
from pytest_lpb.motion import Motion
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import FloatArray

PARTS = 64  # of a step in which a motion has no bounded speed, such as sqrt(|t - 1|) at t = 1
ROUND = frozenset({"circle", "sphere"})  # shapes that rotation does not change


class ObstacleTravel:
    """Bounds of how far any point of each obstacle moves during each step.

    An obstacle's speed is no more than that of its position and its circumradius times its angular rate together.

    Args:
        obstacles: all obstacles of a problem.
        radii: of balls around their positions that hold them [m].
        dt: step [s].
    """

    def __init__(self, obstacles: Sequence[Obstacle], radii: Sequence[float], dt: float) -> None:
        self._obstacles = obstacles
        self._radii = radii
        self._dt = dt
        self._first = -1
        self.still = [0.0] * len(obstacles)
        self.moving = any(obstacle.moving for obstacle in obstacles)

    def farthest(self, row: int) -> float:
        """Bound for all obstacles, during the step that ends with this row [m]."""
        if not self.moving:
            return 0.0
        index = row - 1 - self._first
        if self._first < 0 or not 0 <= index < BLOCK:
            index = self._fill(row)
        return self._farthest[index]

    def each(self, row: int) -> list[float]:
        """Bounds (n,) for each obstacle, during the step that ends with this row [m]."""
        if not self.moving:
            return self.still
        self.farthest(row)
        travel: list[float] = self._travel[row - 1 - self._first].tolist()
        return travel

    def _fill(self, row: int) -> int:
        """Evaluate the block of a row; the row's index in it."""
        index = (row - 1) % BLOCK
        self._first = row - 1 - index
        start = np.arange(self._first, self._first + BLOCK, dtype=np.float64) * self._dt
        self._travel = np.zeros((BLOCK, len(self._obstacles)))
        for column, (obstacle, radius) in enumerate(zip(self._obstacles, self._radii, strict=True)):
            self._travel[:, column] = self._dt * self._speed(obstacle.motion, start)
            if obstacle.turning.moving and obstacle.shape not in ROUND:
                rate = self._speed(obstacle.turning, start)
                if obstacle.turning.size == 4:
                    rate *= 2.0  # a quaternion moves by half of the angle
                self._travel[:, column] += self._dt * radius * rate
        self._farthest: list[float] = self._travel.max(axis=1).tolist()
        return index

    def _speed(self, motion: Motion, start: FloatArray) -> FloatArray:
        """Bounds of |dp/dt| during steps that begin at `start` (N,) [s]."""
        if not motion.moving:
            return np.zeros(len(start))
        speed = motion.speed_bound(start, start + self._dt)
        for row in np.flatnonzero(~np.isfinite(speed)):
            speed[row] = _speed_in_parts(motion, float(start[row]), self._dt)
        return speed


def _speed_in_parts(motion: Motion, start: float, length: float) -> float:
    """The bound over short parts of a span; where there is none in a part either, the speed of its chord."""
    edges = start + np.linspace(0.0, length, PARTS + 1)
    speed = motion.speed_bound(edges[:-1], edges[1:])
    chords = np.sqrt((np.diff(motion.evaluate(edges)[0], axis=0) ** 2).sum(axis=1)) * (PARTS / length)
    return float(np.where(np.isfinite(speed), speed, chords).max())
