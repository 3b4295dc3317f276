"""Copies observations to the arguments of composed functions: arrays in, no objects."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from pytest_lpb.planner.base import FloatArray, Observation, ObstacleInfo
from pytest_lpb.planner.scene.layout import FAR_M, Slot
from pytest_lpb.planner.scene.shapes import MESH, SHAPES

Fill = Callable[[Observation], None]


def copy_of(key: str, target: FloatArray, rows: Any = ...) -> Fill:
    """What copies an entry of the observation, or some rows of it, to where it is wanted."""

    def fill_all(observation: Observation) -> None:
        target[:] = observation[key]

    def fill_rows(observation: Observation) -> None:
        target[:] = observation[key][rows]

    return fill_all if rows is ... else fill_rows


def members_of(obstacles: Sequence[ObstacleInfo]) -> Iterator[tuple[str, list[int]]]:
    """Each shape that is known in closed form, with the places of its obstacles."""
    for shape in sorted({obstacle.shape for obstacle in obstacles} - {MESH}):
        yield shape, [index for index, obstacle in enumerate(obstacles) if obstacle.shape == shape]


def fill_shapes(slot: Slot, numbers: FloatArray, members: Sequence[ObstacleInfo]) -> None:
    """Fill in sizes and presence of obstacles of one shape; slots that are left over hold none, far away.

    Args:
        slot: how the numbers of one lie.
        numbers: (.., slots, slot.length).
        members: the obstacles, at most as many as there are slots.
    """
    numbers[:] = 0.0
    numbers[..., slot.of_time(0)] = FAR_M
    if slot.turn.stop - slot.turn.start == 4:
        numbers[..., slot.turn.start] = 1.0
    numbers[..., slot.sizes] = 1.0
    for row, obstacle in enumerate(members):
        numbers[..., row, slot.sizes] = SHAPES[slot.shape].sizes(obstacle)
        numbers[..., row, slot.present] = 1.0


def orientations(slot: Slot, numbers: FloatArray) -> FloatArray | None:
    """Where the orientations belong, shaped as observations give them; None if they do not matter."""
    if slot.turn.stop == slot.turn.start:
        return None
    turns: FloatArray = numbers[..., slot.turn]
    return turns if turns.shape[-1] > 1 else turns[..., 0]
