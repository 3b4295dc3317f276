"""How numbers about obstacles lie in the arguments of composed functions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pytest_lpb.planner.base import ObstacleInfo
from pytest_lpb.planner.scene.parts import ObstacleSymbols
from pytest_lpb.planner.scene.shapes import SHAPES
from pytest_lpb.symbolic.kinematics import TURNS

ORIENTATION_SIZES = {2: 1, 3: 4}  # numbers of an orientation, by dimension
FAR_M = 1e6  # [m] where slots without an obstacle are


@dataclass(frozen=True)
class Slot:
    """The numbers of one obstacle, in this order: position, velocity, acceleration, orientation, size, presence.

    Orientation and size are left out for shapes that have none.
    """

    shape: str
    dimension: int

    @property
    def turn(self) -> slice:
        """Place of the orientation."""
        start = 3 * self.dimension
        return slice(start, start + (ORIENTATION_SIZES[self.dimension] if SHAPES[self.shape].turns else 0))

    @property
    def sizes(self) -> slice:
        """Place of the size."""
        start = self.turn.stop
        return slice(start, start + SHAPES[self.shape].count)

    @property
    def present(self) -> int:
        """Place of the presence: 1, or 0 where there is no obstacle."""
        return int(self.sizes.stop)

    @property
    def length(self) -> int:
        """How many numbers there are."""
        return self.present + 1

    def of_time(self, derivative: int) -> slice:
        """Place of the position, or of its first or second derivative."""
        return slice(derivative * self.dimension, (derivative + 1) * self.dimension)

    def symbols(self, numbers: Any) -> ObstacleSymbols:
        """An obstacle as the symbols (length, 1) say."""
        turn = TURNS[self.dimension](numbers[self.turn]) if self.turn.stop > self.turn.start else None
        return ObstacleSymbols(self.shape, turn, numbers[self.sizes])


def capacities(obstacles: Sequence[ObstacleInfo]) -> dict[str, int]:
    """Slots per shape: the next of 1, 2, 3, 4, 6, 8, 12, 16, .. that hold the obstacles."""
    counts = Counter(obstacle.shape for obstacle in obstacles)
    return {shape: _capacity(counts[shape]) for shape in sorted(counts)}


def _capacity(count: int) -> int:
    power = 1 << (count - 1).bit_length()
    return 3 * power // 4 if count <= 3 * power // 4 and power > 2 else power
