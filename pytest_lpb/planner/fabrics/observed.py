"""Fills a composed fabric's arguments from observations: arrays in, no objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.planner.base import FloatArray, GoalInfo, Observation, ObstacleInfo
from pytest_lpb.planner.fabrics.layout import FAR_M, Slot
from pytest_lpb.planner.fabrics.shapes import MESH, SHAPES, TINY
from pytest_lpb.problem.spatial.rotations import matrix_of

SPACING_M = 0.02  # [m] between the points that stand for a mesh
KEYS = ("obstacle_position", "obstacle_velocity", "obstacle_acceleration")
TIMES = ("", "_velocity", "_acceleration")

Fill = Callable[[Observation], None]


def goal_fills(goals: Sequence[GoalInfo], arguments: Mapping[str, FloatArray]) -> list[Fill]:
    """One function per number of each sub-goal that changes: value, and of moving ones velocity and acceleration."""
    fills: list[Fill] = []
    for place, goal in enumerate(goals):
        for row, suffix in enumerate(TIMES if goal.moving else TIMES[:1]):
            fills.append(copy_of(f"goal_{goal.name}{suffix}", arguments[f"goal{place}"][row]))
    return fills


def copy_of(key: str, target: FloatArray) -> Fill:
    """What copies an entry of the observation to where it is wanted."""

    def fill(observation: Observation) -> None:
        target[:] = observation[key]

    return fill


def obstacle_fills(
    obstacles: Sequence[ObstacleInfo], arguments: Mapping[str, FloatArray], dimension: int
) -> list[Fill]:
    """Functions that fill in obstacles of shapes known in closed form; their sizes and presence are filled in here."""
    fills: list[Fill] = []
    for shape in sorted({obstacle.shape for obstacle in obstacles} - {MESH}):
        members = [index for index, obstacle in enumerate(obstacles) if obstacle.shape == shape]
        slot = Slot(shape, dimension)
        numbers = arguments[f"obstacles_{shape}"].reshape(-1, slot.length)  # one slot alone is no matrix
        numbers[:] = 0.0
        numbers[:, slot.of_time(0)] = FAR_M
        if slot.turn.stop - slot.turn.start == 4:
            numbers[:, slot.turn.start] = 1.0
        numbers[:, slot.sizes] = 1.0
        for row, index in enumerate(members):
            numbers[row, slot.sizes] = SHAPES[shape].sizes(obstacles[index])
            numbers[row, slot.present] = 1.0
        moving = any(obstacles[index].moving for index in members)
        fills += _of_shape(slot, members, numbers, moving=moving)
    return fills


def _of_shape(slot: Slot, members: list[int], numbers: FloatArray, *, moving: bool) -> list[Fill]:
    """Positions, velocities and accelerations if anything moves, orientations if they matter."""
    whole = members == list(range(members[0], members[0] + len(members)))
    rows: slice | list[int] = slice(members[0], members[0] + len(members)) if whole else members
    targets = [(key, numbers[: len(members), slot.of_time(row)]) for row, key in enumerate(KEYS[: 3 if moving else 1])]
    if slot.turn.stop > slot.turn.start:
        turns = numbers[: len(members), slot.turn]
        targets.append(("obstacle_orientation", turns if turns.shape[1] > 1 else turns[:, 0]))
    return [_copy_rows(key, rows, target) for key, target in targets]


def _copy_rows(key: str, rows: slice | list[int], target: FloatArray) -> Fill:
    def fill(observation: Observation) -> None:
        target[:] = observation[key][rows]

    return fill


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


class MeshFill:
    """Fills in the nearest point of each mesh to each ball of the robot.

    Args:
        obstacles: all of a problem.
        balls: centres of the robot's balls at q, (balls, 3) [m].
        numbers: the argument, a row per mesh and ball.
    """

    def __init__(
        self, obstacles: Sequence[ObstacleInfo], balls: Callable[[FloatArray], FloatArray], numbers: FloatArray
    ) -> None:
        self._members = [index for index, obstacle in enumerate(obstacles) if obstacle.shape == MESH]
        self._meshes = [Mesh(obstacles[index]) for index in self._members]
        self._balls = balls
        self._slot = Slot(MESH, 3)
        self._numbers = numbers.reshape(-1, self._slot.length)
        self._numbers[:] = 0.0
        self._numbers[:, self._slot.of_time(0)] = FAR_M

    def __call__(self, observation: Observation) -> None:
        """Fill in the points nearest to where the robot is."""
        centres = self._balls(observation["q"])
        count = len(centres)
        slot = self._slot
        for row, (index, mesh) in enumerate(zip(self._members, self._meshes, strict=True)):
            position, orientation = (observation[f"obstacle_{key}"][index] for key in ("position", "orientation"))
            numbers = self._numbers[row * count : (row + 1) * count]
            numbers[:, slot.of_time(0)] = mesh.nearest(centres, position, orientation)
            numbers[:, slot.of_time(1)] = observation["obstacle_velocity"][index]
            numbers[:, slot.of_time(2)] = observation["obstacle_acceleration"][index]
            numbers[:, slot.present] = 1.0
