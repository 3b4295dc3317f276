"""Obstacles: a shape and how it moves."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pytest_lpb.motion import Motion, angle_motion, motion_from, turning_motion
from pytest_lpb.problem.registries import shapes
from pytest_lpb.problem.robot import FloatArray

UPRIGHT = (1.0, 0.0, 0.0, 0.0)  # quaternion wxyz


def _own_keys(entry: Mapping[str, Any]) -> dict[str, Any]:
    registered = shapes.get(entry["shape"])
    return {} if registered is None else {key: entry[key] for key in registered.keys if key in entry}


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
        self.size: tuple[float, ...] | None = (
            tuple(entry["size"]) if isinstance(entry.get("size"), list | tuple) else None
        )  # [m] full lengths
        self.length: float | None = entry.get("length")  # [m] along z; of a capsule between its cap centres
        self.file: str | None = entry.get("file")  # of a mesh
        self.scale: float = entry.get("scale", 1.0)  # of a mesh
        self.concave: bool = entry.get("concave", False)  # of a mesh
        self.parameters = _own_keys(entry)  # of a registered shape
        self.motion: Motion = motion_from(entry, key="position")
        turn = entry.get("orientation")
        if self.motion.size == 3:
            self.turning = turning_motion(UPRIGHT if turn is None else turn)
        else:
            self.turning = angle_motion(0.0 if turn is None else turn)

    @property
    def moving(self) -> bool:
        """Whether its position or orientation depends on time."""
        return self.motion.moving or self.turning.moving

    def poses(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (N, 2 or 3) [m] and orientations at times t (N,) [s]: angles (N,) [rad], or quaternions (N, 4)."""
        turns = self.turning.evaluate(t)[0]
        return self.motion.evaluate(t)[0], turns if turns.shape[1] == 4 else turns[:, 0]

    def hashed(self) -> dict[str, Any]:
        """What identifies the obstacle, wherever a mesh's file lies."""
        if self.file is None:
            return self.entry
        from pytest_lpb.problem.spatial.assets import assets_digest

        return {**{k: v for k, v in self.entry.items() if k != "file"}, "assets": assets_digest(Path(self.file))}
