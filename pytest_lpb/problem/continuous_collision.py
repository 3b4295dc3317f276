"""Continuous collision detection: whether, when and how close bodies come to each other in between two rows.

Along a step, s = 0..1 is the share of it that has passed. A pair of bodies whose distance d changes by no more than
L (b - a) between the shares a and b keeps at least

    d(s) >= (d(a) + d(b) - L (b - a)) / 2    for a <= s <= b,

since it has to come down from d(a) and up again to d(b) within L (b - a). Spans of a step in which this excludes
contact are settled; others are halved and measured in their middle. This is conservative advancement (Mirtich,
Impulse-based Dynamic Simulation of Rigid Body Systems, 1996; Zhang et al., Interactive continuous collision detection
for non-convex polyhedra, 2006) from both ends at once. All open spans are halved together, not one after the other, so
that the effort allowed is spent evenly on the whole step.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from typing import Protocol

SHARE_RESOLUTION = 2.0**-11  # of the step, to which the time of contact is found
MAX_MEASUREMENTS = 1024  # of distances within one step, before what is still open is only searched at its minima
MAX_PER_PAIR = 256  # the same for each pair that the whole step leaves open, where that is more
NEAR = 1e-3  # share of a distance below which a parabola has to go to be followed
EITHER = (False, True)
CLEARANCE_TOLERANCE_M = 1e-4  # [m] to which least clearances between rows are found


@dataclass(frozen=True, slots=True)
class Span:
    """A pair of bodies between two shares of a step.

    Attributes:
        start: share at which the span begins.
        before, after: distances at both ends [m], or lower bounds that exclude contact.
        pair: index of the pair.
        travel: bound of the change of the distance within the span [m].
    """

    start: float
    before: float
    after: float
    pair: int
    travel: float

    @property
    def bound(self) -> float:
        """Lower bound of the distance within the span [m]."""
        return 0.5 * (self.before + self.after - self.travel)

    def halves(self, middle: float, distance: float) -> tuple[Span, Span]:
        """The two parts, of which one ends and one begins at the share `middle`, where the distance is this [m]."""
        travel = 0.5 * self.travel
        return (
            Span(self.start, self.before, distance, self.pair, travel),
            Span(middle, distance, self.after, self.pair, travel),
        )


class SweptBodies(Protocol):
    """All pairs of bodies along one step; pairs of robot and obstacle come before those of the robot's own bodies."""

    def spans(self, floor: float, kinds: Sequence[bool] = EITHER) -> list[Span]:
        """The whole step for each pair that may come nearer than `floor` [m].

        `kinds` says which: False for pairs of robot and obstacle, True for those of the robot's own bodies.
        """

    def distances(self, share: float, pairs: Sequence[int]) -> list[float]:
        """Distances [m] of pairs at a share of the step."""

    def names(self, pair: int) -> tuple[str, str]:
        """Of both sides of a pair."""

    def is_own(self, pair: int) -> bool:
        """Whether both sides are the robot's."""


@dataclass(frozen=True)
class Touch:
    """First contact within a step: share of the step, and index of the pair."""

    share: float
    pair: int


def most_measurements(pairs: int) -> int:
    """How many distances are measured within a step that leaves so many pairs open: many pairs do not starve one."""
    return max(MAX_MEASUREMENTS, MAX_PER_PAIR * pairs)


def first_touch(bodies: SweptBodies, deepest: float) -> Touch | None:
    """The first time at which a pair is nearer than `deepest` [m], a negative number; None where none ever is.

    The time is found to `SHARE_RESOLUTION`. Contact is proved or excluded, unless bodies stay within a hair of each
    other for so long that `most_measurements` do not settle it; what is left is then searched at minima of parabolas.
    """
    spans = bodies.spans(deepest)
    first: Touch | None = None
    for span in spans:
        if span.after < deepest:
            first = Touch(1.0, span.pair)
            break
    width, measured, most = 1.0, 0, most_measurements(len(spans))
    while spans and (measured := measured + len(spans)) <= most:
        width *= 0.5
        parts: list[Span] = []
        for middle, group, distances in _measured(bodies, spans, width, first):
            halves = [span.halves(middle, d) for span, d in zip(group, distances, strict=True)]
            touching = [span.pair for span, d in zip(group, distances, strict=True) if d < deepest]
            parts += [before for before, _ in halves]
            if touching:
                first = Touch(middle, touching[0])
                break
            parts += [after for _, after in halves]
        resolved = width <= SHARE_RESOLUTION
        spans = [part for part in parts if part.bound < deepest and not (resolved and part.after < deepest)]
    return _touch_at_a_minimum(bodies, spans, width, deepest, first)


def _measured(
    bodies: SweptBodies, spans: Sequence[Span], half: float, first: Touch | None
) -> Iterator[tuple[float, list[Span], list[float]]]:
    """Spans that begin together, and before the first contact known: their middle, and the distances there."""
    for start, members in groupby(spans, key=attrgetter("start")):
        if first is not None and start >= first.share:
            return
        group = list(members)
        yield start + half, group, bodies.distances(start + half, [span.pair for span in group])


def _touch_at_a_minimum(
    bodies: SweptBodies, spans: Sequence[Span], width: float, deepest: float, first: Touch | None
) -> Touch | None:
    """Contact in what could not be settled: at the middles of spans and the minima of the parabolas through them."""
    for middle, group, distances in _measured(bodies, spans, 0.5 * width, first):
        for span, distance in zip(group, distances, strict=True):
            if distance < deepest:
                return Touch(middle, span.pair)
            slope, bend = span.after - span.before, span.before - 2.0 * distance + span.after
            if bend > 0.0 and abs(slope) < 2.0 * bend and distance - 0.125 * slope * slope / bend < NEAR * distance:
                lowest = middle - 0.25 * width * slope / bend
                if bodies.distances(lowest, [span.pair])[0] < deepest:
                    return Touch(lowest, span.pair)
    return first


def least_distance(bodies: SweptBodies, known: float, floor: float, *, own: bool = False) -> float:
    """The least distance to obstacles, or of the robot's own pairs, within the step [m].

    It is `known` where it is not below `known` and below `floor` [m].
    It is found to `CLEARANCE_TOLERANCE_M`, unless `most_measurements` do not settle it.
    """
    least = known
    spans = bodies.spans(min(least, floor) - CLEARANCE_TOLERANCE_M, (own,))
    width, measured, most = 1.0, 0, most_measurements(len(spans))
    while spans and (measured := measured + len(spans)) <= most:
        width *= 0.5
        parts: list[Span] = []
        for middle, group, distances in _measured(bodies, spans, width, None):
            halves = [span.halves(middle, d) for span, d in zip(group, distances, strict=True)]
            parts += [before for before, _ in halves]
            parts += [after for _, after in halves]
            least = min(least, *distances)
        wanted = min(least, floor) - CLEARANCE_TOLERANCE_M
        spans = [part for part in parts if part.bound < wanted]
    return least
