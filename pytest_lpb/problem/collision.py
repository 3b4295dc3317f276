"""Where a robot's clearance can be asked for, in the plane and in space alike."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Protocol, Self

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle

Clearance = tuple[float, str, str]  # signed distance [m] (NaN: nothing to measure), body, obstacle or other body


class CollisionSpace(Protocol):
    """A robot among obstacles where they are at t = 0.

    Attributes: contact_slack_m, the depth from which bodies collide: touching within rounding is none.
    """

    contact_slack_m: float

    def clearance(self, q: Sequence[float]) -> Clearance:
        """Signed distance [m] to the nearest obstacle with body and obstacle; NaN without obstacles."""

    def self_clearance(self, q: Sequence[float]) -> Clearance:
        """Signed distance [m] between the robot's own bodies; NaN without pairs."""

    def clearance_of(self, obstacle: Obstacle, q: Sequence[float]) -> float:
        """Signed distance [m] to one further obstacle."""

    def close(self) -> None:
        """Free what the space holds; again is no harm."""


class ClosedAtTheEnd:
    """Makes a collision space one for `with`."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free what the space holds."""
