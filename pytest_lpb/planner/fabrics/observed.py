"""Fills a composed fabric's arguments from observations: arrays in, no objects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pytest_lpb.planner.base import FloatArray, GoalInfo, ObstacleInfo
from pytest_lpb.planner.scene.fills import Fill, copy_of, fill_shapes, members_of, orientations
from pytest_lpb.planner.scene.layout import Slot

KEYS = ("obstacle_position", "obstacle_velocity", "obstacle_acceleration")
TIMES = ("", "_velocity", "_acceleration")


def goal_fills(goals: Sequence[GoalInfo], arguments: Mapping[str, FloatArray]) -> list[Fill]:
    """One function per number of each sub-goal that changes: value, and of moving ones velocity and acceleration."""
    fills: list[Fill] = []
    for place, goal in enumerate(goals):
        for row, suffix in enumerate(TIMES if goal.moving else TIMES[:1]):
            fills.append(copy_of(f"goal_{goal.name}{suffix}", arguments[f"goal{place}"][row]))
    return fills


def obstacle_fills(
    obstacles: Sequence[ObstacleInfo], arguments: Mapping[str, FloatArray], dimension: int
) -> list[Fill]:
    """Functions that fill in obstacles of shapes known in closed form; their sizes and presence are filled in here."""
    fills: list[Fill] = []
    for shape, members in members_of(obstacles):
        slot = Slot(shape, dimension)
        numbers = arguments[f"obstacles_{shape}"].reshape(-1, slot.length)  # one slot alone is no matrix
        fill_shapes(slot, numbers, [obstacles[index] for index in members])
        moving = any(obstacles[index].moving for index in members)
        fills += _of_shape(slot, members, numbers[: len(members)], moving=moving)
    return fills


def _of_shape(slot: Slot, members: list[int], numbers: FloatArray, *, moving: bool) -> list[Fill]:
    """Positions, velocities and accelerations if anything moves, orientations if they matter."""
    whole = members == list(range(members[0], members[0] + len(members)))
    rows: slice | list[int] = slice(members[0], members[0] + len(members)) if whole else members
    keys = KEYS if moving else KEYS[:1]
    fills = [copy_of(key, numbers[:, slot.of_time(derivative)], rows) for derivative, key in enumerate(keys)]
    turns = orientations(slot, numbers)
    return fills if turns is None else [*fills, copy_of("obstacle_orientation", turns, rows)]
