"""Fills a horizon's arguments from observations: targets and obstacles where they are predicted to be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pytest_lpb.planner.base import FloatArray, GoalInfo, ObstacleInfo
from pytest_lpb.planner.scene.fills import Fill, copy_of, fill_shapes, members_of, orientations
from pytest_lpb.planner.scene.layout import Slot


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
