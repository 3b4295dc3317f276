"""Bodies in space along one step: their exact motion, or the straight lines between substeps of simulated forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pytest_lpb.problem.continuous_collision import EITHER, Span
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.clearance import SpatialCollision
from pytest_lpb.problem.spatial.world import World

SLACK_M = 1e-9  # [m] by which travels are taken to be longer, for rounding


@dataclass(frozen=True)
class SpatialStep:
    """One step of a trial.

    Attributes:
        path: configuration (dof,) at a share of the step.
        rates: bounds (dof,) of the rate of each entry of q during the step, see `SpatialRobot.peak_rates`.
        t, dt: when the step begins, and its length [s].
        obstacle_travel: bound of how far a point of each obstacle moves during the step (n,) [m].
        bounds: lower bounds of the distances of all pairs at the end of the step [m]; None: not known.
    """

    path: Callable[[float], Sequence[float]]
    rates: FloatArray
    t: float
    dt: float
    obstacle_travel: Sequence[float]
    bounds: FloatArray | None = None


class SpatialSweptBodies:
    """Distances of a robot's bodies along one step, see `SweptBodies`. It moves robot and obstacles of `world`.

    Pairs of body and obstacle are counted body by body, then come the pairs of the robot's own bodies.
    """

    def __init__(
        self, world: World, collision: SpatialCollision, obstacles: Sequence[Obstacle], step: SpatialStep
    ) -> None:
        self._world = world
        self._collision = collision
        self._moving = [(index, obstacle) for index, obstacle in enumerate(obstacles) if obstacle.moving]
        self._own = len(collision.obstacles.names)  # index of the first pair of own bodies
        self._step = step
        self._travels = collision.travels(step.rates * step.dt, np.array(step.obstacle_travel)) + SLACK_M
        self._within = self._travels  # up to where distances are measured, not only bounded

    def move_to(self, share: float) -> None:
        """Put the robot, and obstacles that move, where they are at a share of the step."""
        step = self._step
        self._world.set_q(step.path(share))
        if self._moving:
            time = np.array([step.t + share * step.dt])
            for index, obstacle in self._moving:
                positions, orientations = obstacle.poses(time)
                self._world.place(index, positions[0].tolist(), orientations[0].tolist())

    def distances(self, share: float, pairs: Sequence[int]) -> list[float]:
        """Signed distances [m] of pairs at a share of the step; of far ones a lower bound beyond their travel."""
        self.move_to(share)
        return [self._distance(pair) for pair in pairs]

    def _distance(self, pair: int) -> float:
        within = float(self._within[pair])
        if pair >= self._own:
            return self._collision.own.distance(pair - self._own, within)
        return self._collision.obstacles.distance(pair, within)

    def spans(self, floor: float, kinds: Sequence[bool] = EITHER) -> list[Span]:
        """The whole step for each pair that may come nearer than `floor` [m]."""
        bounds = self._step.bounds
        # A pair that may come nearer than the floor is never farther apart than this.
        self._within = max(floor, 0.0) + 1.5 * self._travels
        lowest = np.full(len(self._travels), -np.inf) if bounds is None else bounds - self._travels
        pairs = [pair for pair in np.flatnonzero(lowest < floor).tolist() if self.is_own(pair) in kinds]
        after = self.distances(1.0, pairs)
        near = [(p, d) for p, d in zip(pairs, after, strict=True) if d - self._travels[p] < floor]
        if not near:
            return []
        before = self.distances(0.0, [pair for pair, _ in near])
        spans = [
            Span(0.0, first, last, pair, float(self._travels[pair]))
            for (pair, last), first in zip(near, before, strict=True)
        ]
        return [span for span in spans if span.bound < floor]

    def names(self, pair: int) -> tuple[str, str]:
        """Of both sides of a pair."""
        own = pair >= self._own
        return self._collision.own.names[pair - self._own] if own else self._collision.obstacles.names[pair]

    def is_own(self, pair: int) -> bool:
        """Whether both sides are the robot's."""
        return pair >= self._own


def polyline(points: FloatArray) -> Callable[[float], list[float]]:
    """The configuration at a share of the way along points (N + 1, dof), which are equally far apart in time."""
    last = len(points) - 1

    def at(share: float) -> list[float]:
        index = min(int(share * last), last - 1)
        part = share * last - index
        values: list[float] = (points[index] + part * (points[index + 1] - points[index])).tolist()
        return values

    return at


def polyline_rates(points: FloatArray, dt: float) -> FloatArray:
    """Bounds (dof,) of the rates along such points within dt [s]."""
    rates: FloatArray = np.abs(np.diff(points, axis=0)).max(axis=0) * ((len(points) - 1) / dt)
    return rates
