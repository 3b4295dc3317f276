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
    """

    contact_slack_m: float
    q: list[float]
    u: list[float]
    holds_velocity: bool
    _dt: float
    _last: tuple[list[float], list[float], list[float]]  # q and u before the last step, and the action
    _travel: ObstacleTravel

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

    def prepare_bounds(self, speed_per_rate: Travel, *, holds_velocity: bool) -> None:
        """Set what bounds follow from.

        Args:
            speed_per_rate: bounds of the speed of any point, and of own bodies towards each other, per unit of max |u|.
            holds_velocity: whether u is constant during a step, as under velocity control.
        """
        self.holds_velocity = holds_velocity
        self._travel_per_rate = speed_per_rate[0] * self._dt
        self._own_travel_per_rate = speed_per_rate[1] * self._dt
        self._peak = 0.0  # max |u| at the last row

    def may_have_touched(self, row: int, gap: float, own_gap: float) -> bool:
        """Whether bounds leave it open that bodies touched on the way to this row; to be asked at each row.

        Args:
            row: the current row.
            gap, own_gap: sums of the clearances at both ends of the step, to obstacles and between own bodies [m].
        """
        before, peak = self._peak, 0.0
        for speed in self.u:  # `max(map(abs, u))` takes longer
            if speed > peak:
                peak = speed
            elif -speed > peak:
                peak = -speed
        self._peak = peak
        if before > peak and not self.holds_velocity:
            peak = before
        travel = peak * self._travel_per_rate
        if self._travel.moving:
            travel += self._travel.farthest(row)
        if not (gap < travel or own_gap < peak * self._own_travel_per_rate):
            return False
        slack = 2.0 * self.contact_slack_m
        travel, own_travel = self.travel_of(row, self._last[1], self.q, self.u)
        return gap + slack < travel or own_gap + slack < own_travel
