"""Meshes among the obstacles: of each the point that is nearest, as planners whose distances are to balls see it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.planner.base import FloatArray, Observation, ObstacleInfo
from pytest_lpb.planner.scene.layout import FAR_M, Slot
from pytest_lpb.planner.scene.shapes import MESH, TINY
from pytest_lpb.problem.spatial.content import file_digest
from pytest_lpb.problem.spatial.rotations import matrix_of
from pytest_lpb.symbolic.buffered import BufferedFunction

SPACING_M = 0.02  # [m] between the points that stand for a mesh


class Mesh:
    """The points of a mesh, to be searched for the one nearest to a ball.

    Args:
        told: what the planner was told of the obstacle.
    """

    def __init__(self, told: ObstacleInfo) -> None:
        file = Path(told.file or "")
        self._tree, self._reach = _searchable(str(file), told.scale, told.concave, file_digest(file))

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
def _searchable(file: str, scale: float, concave: bool, _digest: str) -> Any:
    from scipy.spatial import cKDTree  # late: few scenarios have meshes

    from pytest_lpb.problem.spatial.meshes import surface_sample

    points, reach = surface_sample(file, scale, SPACING_M, concave=concave)
    return cKDTree(points), reach


class MeshFill:
    """Fills in the point of each mesh that is nearest to each ball of the robot, at each step ahead.

    Args:
        obstacles: all of a problem.
        points: composed function of `q` at all steps to the `points` (3, balls) of each [m].
        numbers: the argument, for each step a row per mesh and ball.
        steps: that are looked ahead, from the preview of the observation; 1: now.
    """

    def __init__(self, obstacles: Sequence[ObstacleInfo], points: Any, numbers: FloatArray, steps: int = 1) -> None:
        self._members = [index for index, obstacle in enumerate(obstacles) if obstacle.shape == MESH]
        self._meshes = [Mesh(obstacles[index]) for index in self._members]
        self._ahead = [obstacles[index].moving and steps > 1 for index in self._members]
        self._points = BufferedFunction(points)
        self._steps = steps
        self._slot = Slot(MESH, 3)
        self._numbers = numbers.reshape(steps, -1, self._slot.length)
        self._numbers[:] = 0.0
        self._numbers[:, :, self._slot.of_time(0)] = FAR_M

    def fill(self, observation: Observation, q: FloatArray) -> None:
        """Fill in the points nearest to where the robot is or will be, q (dof,) or (N, dof)."""
        centres = self._centres(q)
        count, slot = centres.shape[1], self._slot
        for row, (index, mesh) in enumerate(zip(self._members, self._meshes, strict=True)):
            numbers = self._numbers[:, row * count : (row + 1) * count]
            orientation = observation["obstacle_orientation"][index]
            if self._ahead[row]:
                for step, there in enumerate(observation["obstacle_position_preview"][index]):
                    numbers[step, :, slot.of_time(0)] = mesh.nearest(centres[step], there, orientation)
            else:
                here = observation["obstacle_position"][index]
                nearest = mesh.nearest(centres.reshape(-1, 3), here, orientation)
                numbers[:, :, slot.of_time(0)] = nearest.reshape(centres.shape)
            numbers[:, :, slot.of_time(1)] = observation["obstacle_velocity"][index]
            numbers[:, :, slot.of_time(2)] = observation["obstacle_acceleration"][index]
            numbers[:, :, slot.present] = 1.0

    def _centres(self, q: FloatArray) -> FloatArray:
        """Centres of the balls at each step, (N, balls, 3) [m]."""
        argument = self._points.arguments["q"]
        argument[:] = q.reshape(argument.shape)
        self._points()
        return self._points.results["points"].reshape(self._steps, -1, 3)
