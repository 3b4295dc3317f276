"""Planar bodies along one step: their exact motion under a constant action, and bounds of how fast they move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from pytest_lpb.problem.continuous_collision import EITHER, Span
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.planar.collision import Capsule, PlanarCollision
from pytest_lpb.problem.planar.robot import PlanarRobot


class BodySpeeds:
    """Bounds of the speeds of a robot's capsules while its actuated velocity changes linearly between two values.

    A point of a capsule's axis at the distance r from the frame of its link is no faster than that frame and r times
    the link's angular rate together. A joint at the rate w changes the distance between two bodies by no more than w
    times the lever of either.
    """

    def __init__(self, robot: PlanarRobot, collision: PlanarCollision) -> None:
        self._robot = robot
        self._levers = [(link, max(hypot(ax, ay), hypot(bx, by))) for link, (ax, ay, bx, by, _) in collision.placed]
        self._pair_levers = [robot.pair_levers(self._levers[i], self._levers[j]) for i, j in collision.pairs]
        self._largest = [max(levers) for levers in zip(*self._pair_levers, strict=True)]

    def fastest(self, before: list[float], after: list[float]) -> tuple[float, float]:
        """Bounds for all bodies [m/s]: of their speed, and of how fast two of them close in on each other."""
        speeds = self._robot.link_speeds(before, after)
        fastest = closing = 0.0
        for link, lever in self._levers:
            linear, angular = speeds[link]
            speed = linear + lever * angular
            if speed > fastest:  # `max` takes longer
                fastest = speed
        for lever, first, last in zip(self._largest, before, after, strict=False):  # nothing without pairs
            closing += lever * max(abs(first), abs(last))
        return fastest, closing

    def of_bodies(self, before: list[float], after: list[float]) -> list[float]:
        """Bounds of the speed of each capsule's axis [m/s]."""
        speeds = self._robot.link_speeds(before, after)
        return [speeds[link][0] + lever * speeds[link][1] for link, lever in self._levers]

    def of_pairs(self, before: list[float], after: list[float]) -> list[float]:
        """Bounds of how fast each pair of the robot's own bodies closes in [m/s]."""
        peaks = [max(abs(first), abs(last)) for first, last in zip(before, after, strict=True)]
        return [sum(lever * peak for lever, peak in zip(levers, peaks, strict=True)) for levers in self._pair_levers]


@dataclass(frozen=True)
class PlanarStep:
    """One step of a trial: the state before it, what is applied, and when.

    Attributes:
        q, u: state before the step.
        action: constant during the step.
        peaks: values of u between which it lies during the step.
        t, dt: when the step begins, and its length [s].
        obstacle_travel: bound of how far a point of each obstacle moves during the step (n,) [m].
    """

    q: list[float]
    u: list[float]
    action: list[float]
    peaks: tuple[list[float], list[float]]
    t: float
    dt: float
    obstacle_travel: Sequence[float]


class PlanarSweptBodies:
    """Distances of a planar robot's bodies along one step, see `SweptBodies`. It moves the shapes of `collision`.

    Pairs of body and obstacle are counted body by body, then come the pairs of the robot's own bodies.
    """

    def __init__(
        self,
        robot: PlanarRobot,
        collision: PlanarCollision,
        speeds: BodySpeeds,
        obstacles: Sequence[Obstacle],
        step: PlanarStep,
    ) -> None:
        self._robot = robot
        self._collision = collision
        self._speeds = speeds
        self._moving = [(index, obstacle) for index, obstacle in enumerate(obstacles) if obstacle.moving]
        self._count = len(obstacles)
        self._own = len(collision.placed) * self._count  # index of the first pair of own bodies
        self._step = step

    def capsules(self, share: float) -> list[Capsule]:
        """The robot's bodies at a share of the step; obstacles that move are placed as well."""
        step = self._step
        q, _ = self._robot.integrate(step.q, step.u, step.action, share * step.dt)
        if self._moving:
            time = np.array([step.t + share * step.dt])
            for index, obstacle in self._moving:
                positions, angles = obstacle.poses(time)
                self._collision.shapes[index].place(float(positions[0, 0]), float(positions[0, 1]), float(angles[0]))
        return self._collision.capsules(self._robot.frames(q))

    def distances(self, share: float, pairs: Sequence[int]) -> list[float]:
        """Signed distances [m] of pairs at a share of the step."""
        capsules = self.capsules(share)
        return [self._distance(pair, capsules) for pair in pairs]

    def _distance(self, pair: int, capsules: Sequence[Capsule]) -> float:
        if pair >= self._own:
            return self._collision.pair_distance(pair - self._own, capsules)
        body, obstacle = divmod(pair, self._count)
        return self._collision.distance(capsules[body], obstacle)

    def spans(self, floor: float, kinds: Sequence[bool] = EITHER) -> list[Span]:
        """The whole step for each pair that may come nearer than `floor` [m]."""
        travels = self._travels()
        near = self._near_at_the_end(self.capsules(1.0), travels, floor, kinds)
        if not near:
            return []
        before = self.distances(0.0, [pair for pair, _ in near])
        spans = [Span(0.0, first, last, pair, travels[pair]) for (pair, last), first in zip(near, before, strict=True)]
        return [span for span in spans if span.bound < floor]

    def _travels(self) -> list[float]:
        """Bound of the change of each pair's distance [m]."""
        step = self._step
        bodies = [speed * step.dt for speed in self._speeds.of_bodies(*step.peaks)]
        own = [speed * step.dt for speed in self._speeds.of_pairs(*step.peaks)] if self._collision.pairs else []
        return [body + obstacle for body in bodies for obstacle in step.obstacle_travel] + own

    def _near_at_the_end(
        self, capsules: Sequence[Capsule], travels: Sequence[float], floor: float, kinds: Sequence[bool]
    ) -> list[tuple[int, float]]:
        """Pairs that end the step so near that they may have been nearer than `floor`, with their distances then."""
        near = []
        for pair, travel in enumerate(travels):
            if self.is_own(pair) not in kinds:
                continue
            if pair < self._own:
                body, obstacle = divmod(pair, self._count)
                # Discs around both exclude most pairs.
                if self._collision.disc_distance(capsules[body], obstacle) - travel >= floor:
                    continue
            distance = self._distance(pair, capsules)
            if distance - travel < floor:
                near.append((pair, distance))
        return near

    def names(self, pair: int) -> tuple[str, str]:
        """Of both sides of a pair."""
        names = self._collision.body_names
        if pair >= self._own:
            first, second = self._collision.pairs[pair - self._own]
            return names[first], names[second]
        body, obstacle = divmod(pair, self._count)
        return names[body], self._collision.obstacle_names[obstacle]

    def is_own(self, pair: int) -> bool:
        """Whether both sides are the robot's."""
        return pair >= self._own
