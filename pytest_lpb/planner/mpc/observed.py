"""Fills a horizon's arguments from observations: targets and obstacles where they are predicted to be."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from pytest_lpb.planner.base import FloatArray, GoalInfo, Observation, ObstacleInfo
from pytest_lpb.planner.scene.fills import Fill, copy_of, fill_shapes, members_of, orientations
from pytest_lpb.planner.scene.layout import FAR_M, Slot
from pytest_lpb.planner.scene.meshes import Mesh
from pytest_lpb.planner.scene.shapes import MESH


def goal_fills(goals: Sequence[GoalInfo], targets: FloatArray) -> list[Fill]:
    """Functions that fill in the targets of all sub-goals, (N, sizes)."""
    fills: list[Fill] = []
    start = 0
    for goal in goals:
        part = targets[:, start : start + goal.size]
        fills.append(copy_of(f"goal_{goal.name}_preview" if goal.moving else f"goal_{goal.name}", part))
        start += goal.size
    return fills


def obstacle_fills(
    obstacles: Sequence[ObstacleInfo], arguments: Mapping[str, FloatArray], steps: int, dimension: int
) -> list[Fill]:
    """Functions that fill in obstacles of shapes known in closed form; their sizes and presence are filled in here."""
    fills: list[Fill] = []
    for shape, members in members_of(obstacles):
        slot = Slot(shape, dimension)
        numbers = arguments[f"obstacles_{shape}"].reshape(steps, -1, slot.length)
        fill_shapes(slot, numbers, [obstacles[index] for index in members])
        moving = any(obstacles[index].moving for index in members)
        fills += _of_shape(slot, members, numbers[:, : len(members)], moving=moving)
    return fills


def _of_shape(slot: Slot, members: list[int], numbers: FloatArray, *, moving: bool) -> list[Fill]:
    """Positions along the horizon, and orientations if they matter."""
    positions = numbers[:, :, slot.of_time(0)]
    if moving:
        fills = [copy_of("obstacle_position_preview", positions.transpose(1, 0, 2), members)]
    else:
        fills = [copy_of("obstacle_position", positions, members)]
    turns = orientations(slot, numbers)
    return fills if turns is None else [*fills, copy_of("obstacle_orientation", turns, members)]


class MeshFill:
    """Fills in the nearest point of each mesh to each ball of the robot at each step of the horizon.

    Args:
        obstacles: all of a problem.
        balls: centres of the robot's balls at the q of each step (N, dof): (N, balls, 3) [m].
        numbers: the argument, for each step a row per mesh and ball.
        steps: of the horizon.
    """

    def __init__(
        self,
        obstacles: Sequence[ObstacleInfo],
        balls: Callable[[FloatArray], FloatArray],
        numbers: FloatArray,
        steps: int,
    ) -> None:
        self._members = [index for index, obstacle in enumerate(obstacles) if obstacle.shape == MESH]
        self._meshes = [Mesh(obstacles[index]) for index in self._members]
        self._moving = [obstacles[index].moving for index in self._members]
        self._balls = balls
        self._slot = Slot(MESH, 3)
        self._numbers = numbers.reshape(steps, -1, self._slot.length)
        self._numbers[:] = 0.0
        self._numbers[:, :, self._slot.of_time(0)] = FAR_M

    def fill(self, observation: Observation, q: FloatArray) -> None:
        """Fill in the points nearest to where the robot will be, q (N, dof)."""
        centres = self._balls(q)
        count, slot = centres.shape[1], self._slot
        for row, (index, mesh) in enumerate(zip(self._members, self._meshes, strict=True)):
            numbers = self._numbers[:, row * count : (row + 1) * count]
            orientation, position = observation["obstacle_orientation"][index], observation["obstacle_position"][index]
            if self._moving[row]:
                for step, there in enumerate(observation["obstacle_position_preview"][index]):
                    numbers[step, :, slot.of_time(0)] = mesh.nearest(centres[step], there, orientation)
            else:
                nearest = mesh.nearest(centres.reshape(-1, 3), position, orientation)
                numbers[:, :, slot.of_time(0)] = nearest.reshape(centres.shape)
            numbers[:, :, slot.present] = 1.0
