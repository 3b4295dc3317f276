"""The dynamic window approach (Fox, Burgard, Thrun 1997), for a disc that can accelerate in every direction.

Velocities that can be reached within one window are sampled. Those from which the disc can still brake before it hits
an obstacle (moving on at its present velocity) are admissible; the one that promises most is aimed at.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb import Planner

FloatArray = NDArray[np.float64]


class DynamicWindow(Planner):
    """Chooses a velocity by progress and time to collision."""

    name = "dynamic_window"

    @dataclass(frozen=True)
    class Parameters:
        """Of the window and of the choice."""

        window: float = 0.25  # [s] in which a velocity is to be reached
        samples: int = 15  # per axis
        speed: float = 1.2  # [m/s] largest
        margin: float = 0.05  # [m] kept from obstacles
        horizon: float = 2.5  # [s] collisions later than that do not count
        caution: float = 0.6  # [m/s] what a collision at the end of braking costs, of progress

    def setup(self, problem: Any) -> None:
        """Note sizes and limits."""
        self._radii = np.array([obstacle.radius for obstacle in problem.obstacles]) + problem.robot.body_radius
        self._acceleration = float(problem.robot.limits.acceleration[:, 1].min())

    def compute_action(self, observation: Any) -> FloatArray:
        """Acceleration towards the best admissible velocity; full braking without one."""
        parameters = self.parameters
        position, velocity = observation["q"], observation["u"]
        velocities = self._reachable(velocity)
        free = self._times_to_collision(
            velocities, observation["obstacle_position"] - position, observation["obstacle_velocity"]
        )
        speeds = np.linalg.norm(velocities, axis=1)
        braking = speeds / self._acceleration + parameters.window
        admissible = (free > braking) & (speeds <= parameters.speed)
        if not admissible.any():
            return -velocity / parameters.window
        target = self._towards(observation["goal_position"] - position)
        danger = np.clip((parameters.horizon - free) / (parameters.horizon - braking), 0.0, 1.0)
        cost = np.linalg.norm(velocities - target, axis=1) + parameters.caution * danger
        cost[~admissible] = np.inf
        return (velocities[np.argmin(cost)] - velocity) / parameters.window

    def _reachable(self, velocity: FloatArray) -> FloatArray:
        """Velocities of the window, (n, 2) [m/s]."""
        reach = np.linspace(-1.0, 1.0, self.parameters.samples) * self._acceleration * self.parameters.window
        changes = np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 2)
        return velocity + changes

    def _towards(self, error: FloatArray) -> FloatArray:
        """The velocity that is wished for, (2,) [m/s]: straight to the goal, and slow enough to stop there."""
        distance = float(np.linalg.norm(error))
        speed = min(self.parameters.speed, np.sqrt(self._acceleration * distance), 2.0 * distance)
        return error * (speed / max(distance, 1e-9))

    def _times_to_collision(self, velocities: FloatArray, offset: FloatArray, moving: FloatArray) -> FloatArray:
        """Time until each velocity (n, 2) meets the first obstacle, (n,) [s]; infinite when it meets none.

        With relative position p and velocity v, the first root of |p + v t| = R; inside of the margin, only
        velocities that lead away are free.
        """
        if not len(offset):
            return np.full(len(velocities), np.inf)
        relative = moving[None] - velocities[:, None]  # (n, obstacles, 2)
        gap = np.sum(offset**2, axis=1) - (self._radii + self.parameters.margin) ** 2
        approach = np.einsum("noi,oi->no", relative, offset)
        square = np.maximum(np.sum(relative**2, axis=2), 1e-12)
        root = approach**2 - square * gap
        time = np.where((root > 0) & (approach < 0), (-approach - np.sqrt(np.maximum(root, 0))) / square, np.inf)
        return np.maximum(time, 0.0).min(axis=1)
