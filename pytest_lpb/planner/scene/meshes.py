"""Meshes among the obstacles: of each the point that is nearest, as planners whose distances are to balls see it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.planner.base import FloatArray, ObstacleInfo
from pytest_lpb.planner.scene.shapes import TINY
from pytest_lpb.problem.spatial.rotations import matrix_of

SPACING_M = 0.02  # [m] between the points that stand for a mesh


class Mesh:
    """The points of a mesh, to be searched for the one nearest to a ball.

    Args:
        told: what the planner was told of the obstacle.
    """

    def __init__(self, told: ObstacleInfo) -> None:
        file = Path(told.file or "")
        stat = file.stat()
        self._tree, self._reach = _searchable(str(file), told.scale, told.concave, stat.st_mtime_ns, stat.st_size)

    def nearest(self, centres: FloatArray, position: FloatArray, orientation: FloatArray) -> FloatArray:
        """Points (n, 3) [m] in the world that centres (n, 3) are as near to as they may be to the mesh at a pose."""
        turn = np.array(matrix_of(orientation.tolist()))
        local = (centres - position) @ turn
        distance, nearest = self._tree.query(local)
        # The surface between the points may be nearer: as near as they leave room for.
        least = np.sqrt(np.maximum(distance * distance - self._reach * self._reach, 0.0))
        share = (least / np.maximum(distance, TINY))[:, None]
        found: FloatArray = (local + share * (self._tree.data[nearest] - local)) @ turn.T + position
        return found


@lru_cache(maxsize=64)
def _searchable(file: str, scale: float, concave: bool, _changed: int, _size: int) -> Any:
    from scipy.spatial import cKDTree  # late: few scenarios have meshes

    from pytest_lpb.problem.spatial.meshes import surface_sample

    points, reach = surface_sample(file, scale, SPACING_M, concave=concave)
    return cKDTree(points), reach
