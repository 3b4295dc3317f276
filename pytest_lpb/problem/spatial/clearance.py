"""Exact clearance of a robot in a PyBullet world, measured for as few pairs of bodies as that takes.

Between two steps no point of a body moves farther than its `travel`, so the distance of a pair cannot shrink by more
than both travels; of two bodies of the robot only the joints between them count. Each pair carries the lower bound that
follows from its last measurement; a query measures pairs in the order of their bounds until the next bound is no
smaller than the least distance found. What it returns is exact: the bounds only decide what need not be measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, nan
from operator import mul

import numpy as np

from pytest_lpb.problem.collision import Clearance
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.bodies import NO_LINK, Body
from pytest_lpb.problem.spatial.client import pybullet
from pytest_lpb.problem.spatial.near_contact import NEAR_M
from pytest_lpb.problem.spatial.reach import reach_between
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.world import DISTANCE, World

CONTACT_SLACK_M = 1e-6  # [m] depth from which bodies collide: the accuracy of distances
NOTHING: Clearance = (nan, "", "")

FARTHEST_M = 1e7  # [m] beyond all coordinates of scenarios
AHEAD_M = 0.5  # [m] beyond the nearest up to which others are measured, so that they need no measuring for a while
SLACK_M = 1e-9  # [m] by which bounds are lowered once more, for rounding
CONSISTENT_M = 1e-4  # [m] by which Bullet's distance may leave what the last one and the motion since allow


class Pairs:
    """Pairs of bodies whose least distance is asked for.

    Args:
        world: where they are.
        first: bodies of the robot, one per pair.
        others: of the other side: bodies of the robot, or PyBullet's ids of obstacles.
        margins: [m] to add to the distance of each pair.
        names: of both sides.
    """

    def __init__(
        self,
        world: World,
        first: Sequence[Body],
        others: Sequence[Body | int],
        margins: Sequence[float],
        names: Sequence[tuple[str, str]],
    ) -> None:
        self._client = world.client.id
        self._world = world
        both = list(zip(first, others, strict=True))
        self._first = [(one.id, one.link) for one in first]
        self._others = [(other, NO_LINK) if isinstance(other, int) else (other.id, other.link) for other in others]
        # Bodies that follow a link, to be put to their places before they are measured.
        following = [[body for body in pair if isinstance(body, Body) and body.carrier is not None] for pair in both]
        self._following = following if any(following) else []
        self._pairs = both
        self._margins = margins
        self.names = names
        self.bounds: FloatArray = np.full(len(names), -inf)
        self._last = [inf] * len(names)  # distances at the last measurement [m]; inf: not known

    def forget(self) -> None:
        """Nothing is known any more of how far apart the bodies are."""
        self.bounds.fill(-inf)
        self._last = [inf] * len(self._last)

    def nearest(self) -> Clearance:
        """The least distance [m] with the names of both bodies; NaN without pairs."""
        bounds = self.bounds
        if not len(bounds):
            return NOTHING
        least, found = inf, -1
        while True:
            pair = int(bounds.argmin())
            if bounds[pair] >= least:
                return (least, *self.names[found])
            low = float(bounds[pair])
            # The bound has been lowered by all motion since the last measurement; so much more may the distance be.
            distance = self._measure(pair, least, low, 2.0 * self._last[pair] - low)
            bounds[pair] = distance
            if distance < least:
                least, found = distance, pair

    def distance(self, pair: int, within: float) -> float:
        """Distance of a pair [m], or a lower bound beyond `within` if it is larger; changes no bounds."""
        last = self._last[pair]
        distance = self._measure(pair, within, -inf, inf)
        self._last[pair] = last
        return distance

    def _measure(self, pair: int, enough: float, low: float, high: float) -> float:
        """Distance of a pair [m], or a lower bound beyond `enough` if it is larger.

        Bullet's distances of shapes whose faces are exactly parallel are now and then far too large. So it is measured
        anew, by our own algorithm, what lies near contact, what is measured for the first time, and what leaves the
        range `low` to `high` [m] that the last measurement and the motion since allow.
        """
        if self._following:
            for following in self._following[pair]:
                self._world.bring(following)
        first, first_link = self._first[pair]
        body, link = self._others[pair]
        margin = self._margins[pair]
        within = min(max(enough, 0.0) + AHEAD_M, FARTHEST_M)
        points = pybullet.getClosestPoints(first, body, within, first_link, link, physicsClientId=self._client)
        if not points and within <= high + CONSISTENT_M:
            self._last[pair] = inf
            return within
        distance = min((point[DISTANCE] for point in points), default=within) + margin
        if distance <= NEAR_M or not low - CONSISTENT_M <= distance <= high + CONSISTENT_M or high == inf:
            distance = self._world.exact_distance(*self._pairs[pair], distance)
        self._last[pair] = distance
        return distance


class SpatialCollision:
    """Clearances of one robot among the obstacles of a world, over the steps of a trial.

    Args:
        robot: gives the pairs of its own bodies to look at.
        world: has the robot and the obstacles.
        names: of the obstacles.
    """

    def __init__(self, robot: SpatialRobot, world: World, names: Sequence[str]) -> None:
        bodies = world.bodies
        self._reach = world.reach
        self._radii = np.array(world.obstacle_radii)
        self.obstacles = Pairs(
            world,
            [body for body in bodies for _ in names],
            [obstacle for _ in bodies for obstacle in world.obstacles],
            [body.margin + margin for body in bodies for margin in world.obstacle_margins],
            [(body.name, name) for body in bodies for name in names],
        )
        self._shape = (len(bodies), len(names))
        pairs = own_pairs(bodies, robot.self_collision_pairs)
        self.own = Pairs(
            world,
            [bodies[i] for i, _ in pairs],
            [bodies[j] for _, j in pairs],
            [bodies[i].margin + bodies[j].margin for i, j in pairs],
            [(bodies[i].name, bodies[j].name) for i, j in pairs],
        )
        self._own_reach = reach_between(robot, bodies, pairs)
        self._largest: list[float] = self._reach.max(axis=0, initial=0.0).tolist()
        self._largest_own: list[float] = self._own_reach.max(axis=0, initial=0.0).tolist()

    def travels(self, change: FloatArray, obstacles: FloatArray) -> FloatArray:
        """Bounds of how much the distance of each pair changes [m]: with obstacles, body by body, then own pairs.

        Args:
            change: how much each entry of q moves (dof,) [rad or m].
            obstacles: how far each obstacle moves (n,) [m].
        """
        bodies = self._reach @ change
        return np.concatenate([(bodies[:, None] + obstacles).ravel(), self._own_reach @ change])

    def farthest(self, rates: Sequence[float]) -> tuple[float, float]:
        """Bounds [m/s] of how fast any body moves, and any two of the robot's own close in, at rates (dof,) of q."""
        return sum(map(mul, self._largest, rates)), sum(map(mul, self._largest_own, rates))

    def forget(self) -> None:
        """The robot was put somewhere else."""
        self.obstacles.forget()
        self.own.forget()

    def moved(self, change: FloatArray) -> None:
        """The robot's joints have moved by `change` (dof,) [rad or m]."""
        distance = np.abs(change)
        travel = self._reach @ distance
        travel += SLACK_M
        if len(self._own_reach):
            self.own.bounds -= self._own_reach @ distance + 2.0 * SLACK_M
        bounds = self.obstacles.bounds.reshape(self._shape)
        bounds -= travel[:, None]

    def obstacles_moved(self, shift: FloatArray, turn: FloatArray) -> None:
        """The obstacles have moved by `shift` (n, 3) [m], their quaternions by `turn` (n, 4).

        A ball of radius r around a turning origin moves by no more than 2 r sin(angle / 2) <= 2 r |turn|.
        """
        travel = np.sqrt((shift * shift).sum(axis=1)) + 2.0 * self._radii * np.sqrt((turn * turn).sum(axis=1))
        bounds = self.obstacles.bounds.reshape(self._shape)
        bounds -= travel + SLACK_M


def own_pairs(bodies: Sequence[Body], pairs: Sequence[tuple[str, str]]) -> list[tuple[int, int]]:
    """Indices of the bodies of each pair of links; a link may have several."""
    owned: dict[str, list[int]] = {}
    for index, body in enumerate(bodies):
        owned.setdefault(body.name, []).append(index)
    return [(i, j) for first, second in pairs for i in owned.get(first, ()) for j in owned.get(second, ())]
