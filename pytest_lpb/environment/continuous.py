"""Which steps need a look between their two rows: almost all are excluded by one comparison."""

from __future__ import annotations

from abc import ABC, abstractmethod

from pytest_lpb.environment.obstacle_travel import ObstacleTravel
from pytest_lpb.problem.continuous_collision import SweptBodies

Travel = tuple[float, float]  # [m] of the robot towards obstacles, and of its own bodies towards each other

NO_BOUND = 1e30  # [m/s] large, and finite: at rest it bounds nothing as zero


class StepBounds(ABC):
    """Bounds of how much distances changed during the last step, for engines whose motion is known.

    Where d(0) and d(1) are the clearances at both ends of a step and no distance changes by more than `travel` during
    it, no distance was below (d(0) + d(1) - travel) / 2 on the way.

    Attributes (besides the engine's own):
        speed_per_rate: bounds of the speed of any point, and of own bodies towards each other, per unit of max |u| [m].
        holds_velocity: whether u is constant during a step, as under velocity control.
    """

    contact_slack_m: float
    q: list[float]
    u: list[float]
    speed_per_rate: Travel
    holds_velocity: bool
    _dt: float
    _last: tuple[list[float], list[float], list[float]]  # q and u before the last step, and the action
    _travel: ObstacleTravel
    _peak: tuple[list[float] | None, float] = (None, 0.0)  # the u last looked at, and its largest entry

    @abstractmethod
    def travel_of(self, row: int, before: list[float], q: list[float], u: list[float]) -> Travel:
        """Bounds of how much distances changed on the way to a row [m], obstacles' own motion included.

        Args:
            row: at the end of the step.
            before: u at its beginning.
            q, u: at its end.
        """

    @abstractmethod
    def swept_bodies(self, row: int) -> SweptBodies:
        """All pairs of bodies on the way to this row; it may move bodies, so call `restore` when done."""

    @abstractmethod
    def swept_bodies_of(
        self, row: int, q: list[float], u: list[float], action: list[float], after: tuple[list[float], list[float]]
    ) -> SweptBodies:
        """The same for any step of the trial, by the state before it, the action, and the state (q, u) after it."""

    @abstractmethod
    def restore(self) -> None:
        """Put all bodies back to where they are at the current row."""

    def may_have_touched(self, row: int, gap: float, own_gap: float) -> bool:
        """Whether bounds leave it open that bodies touched on the way to this row.

        Args:
            row: the current row.
            gap, own_gap: sums of the clearances at both ends of the step, to obstacles and between own bodies [m].
        """
        seen, peak = self._peak
        largest = max(map(abs, self.u))
        self._peak = (self.u, largest)
        if self.holds_velocity:
            peak = largest
        elif seen is not self._last[1]:
            peak = max(largest, *map(abs, self._last[1]))
        elif peak < largest:
            peak = largest
        duration = peak * self._dt
        speed, closing = self.speed_per_rate
        slack = 2.0 * self.contact_slack_m
        travel = self._travel
        moved = travel.farthest(row) if travel.moving else 0.0
        if not (gap + slack < speed * duration + moved or own_gap + slack < closing * duration):
            return False
        farthest, closest = self.travel_of(row, self._last[1], self.q, self.u)
        return gap + slack < farthest or own_gap + slack < closest
