"""Obstacles: a shape and how it moves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pytest_lpb.motion import Motion, angle_motion, motion_from
from pytest_lpb.problem.robot import FloatArray


class Obstacle:
    """One obstacle of a concrete problem.

    Args:
        entry: the obstacle's entry in a concrete problem.
    """

    def __init__(self, entry: Mapping[str, Any]) -> None:
        self.entry = dict(entry)
        self.name: str = entry["name"]
        self.shape: str = entry["shape"]
        self.radius: float | None = entry.get("radius")  # [m]
        self.size: tuple[float, ...] | None = tuple(entry["size"]) if "size" in entry else None  # [m] full lengths
        self.motion: Motion = motion_from(entry, key="position")
        self.turning: Motion = angle_motion(entry.get("orientation", 0.0))

    @property
    def moving(self) -> bool:
        """Whether its position or orientation depends on time."""
        return self.motion.moving or self.turning.moving

    @property
    def orientation(self) -> float:
        """Its angle at t = 0 [rad]."""
        return float(self.turning.evaluate(np.zeros(1))[0][0, 0])

    def poses(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (N, 2 or 3) [m] and angles (N,) [rad] at times t (N,) [s]."""
        return self.motion.evaluate(t)[0], self.turning.evaluate(t)[0][:, 0]
