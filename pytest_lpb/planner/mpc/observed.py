"""Fills a horizon's arguments from observations: targets and obstacles where they are predicted to be."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from pytest_lpb.planner.base import FloatArray, GoalInfo, Observation, ObstacleInfo
from pytest_lpb.planner.fabrics.layout import FAR_M, Slot
from pytest_lpb.planner.fabrics.shapes import MESH, SHAPES

Fill = Callable[[Observation], None]


def goal_fills(goals: Sequence[GoalInfo], targets: FloatArray) -> list[Fill]:
    """Functions that fill in the targets of all sub-goals, (N, sizes)."""
    fills: list[Fill] = []
    start = 0
    for goal in goals:
        part = targets[:, start : start + goal.size]
        fills.append(_copy(f"goal_{goal.name}_preview" if goal.moving else f"goal_{goal.name}", part))
        start += goal.size
    return fills


def _copy(key: str, target: FloatArray) -> Fill:
    def fill(observation: Observation) -> None:
        target[:] = observation[key]

    return fill


def obstacle_fills(
    obstacles: Sequence[ObstacleInfo], arguments: Mapping[str, FloatArray], steps: int, dimension: int
) -> list[Fill]:
    """Functions that fill in obstacles of shapes known in closed form; their sizes and presence are filled in here."""
    fills: list[Fill] = []
    for shape in sorted({obstacle.shape for obstacle in obstacles} - {MESH}):
        members = [index for index, obstacle in enumerate(obstacles) if obstacle.shape == shape]
        slot = Slot(shape, dimension)
        numbers = arguments[f"obstacles_{shape}"].reshape(steps, -1, slot.length)
        numbers[:] = 0.0
        numbers[:, :, slot.of_time(0)] = FAR_M
        if slot.turn.stop - slot.turn.start == 4:
            numbers[:, :, slot.turn.start] = 1.0
        numbers[:, :, slot.sizes] = 1.0
        for row, index in enumerate(members):
            numbers[:, row, slot.sizes] = SHAPES[shape].sizes(obstacles[index])
            numbers[:, row, slot.present] = 1.0
        fills += _of_shape(slot, members, numbers[:, : len(members)], obstacles)
    return fills


def _of_shape(slot: Slot, members: list[int], numbers: FloatArray, obstacles: Sequence[ObstacleInfo]) -> list[Fill]:
    """Positions along the horizon, and orientations if they matter."""
    positions = numbers[:, :, slot.of_time(0)]
    if any(obstacles[index].moving for index in members):
        fills = [_preview(members, positions.transpose(1, 0, 2))]
    else:
        fills = [_still(members, positions)]
    if slot.turn.stop > slot.turn.start:
        turns = numbers[:, :, slot.turn]
        fills.append(_turns(members, turns if turns.shape[2] > 1 else turns[:, :, 0]))
    return fills


def _preview(members: list[int], target: FloatArray) -> Fill:
    def fill(observation: Observation) -> None:
        target[:] = observation["obstacle_position_preview"][members]

    return fill


def _still(members: list[int], target: FloatArray) -> Fill:
    def fill(observation: Observation) -> None:
        target[:] = observation["obstacle_position"][members]

    return fill


def _turns(members: list[int], target: FloatArray) -> Fill:
    def fill(observation: Observation) -> None:
        target[:] = observation["obstacle_orientation"][members]

    return fill
