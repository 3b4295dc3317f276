"""Clearances of a spatial robot at single configurations, with obstacles where they are at t = 0."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import LpbError
from pytest_lpb.problem.collision import Clearance, ClosedAtTheEnd
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.clearance import CONTACT_SLACK_M, SpatialCollision
from pytest_lpb.problem.spatial.pool import borrow_world, give_back
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.world import World

ALWAYS = 64  # configurations in which a pair must overlap to be taken for one that always does
UNLIMITED_RANGE = np.pi  # [rad or m] within which unlimited joints are sampled


class SpatialSpace(ClosedAtTheEnd):
    """Collision space of a robot among obstacles; borrows a world until `close`.

    Args:
        robot: the robot.
        obstacles: those that count.
    """

    contact_slack_m = CONTACT_SLACK_M

    def __init__(self, robot: SpatialRobot, obstacles: Sequence[Obstacle]) -> None:
        self._robot = robot
        self._obstacles = list(obstacles)
        robot.self_collision_pairs  # noqa: B018 - the first time this needs the world itself
        self._world: World | None = borrow_world(robot)
        try:
            self._arrange(self._obstacles)
        except LpbError:
            self.world.close()  # whatever is in it, nobody else should have it
            raise

    @property
    def world(self) -> World:
        """The borrowed world. Raises LpbError after `close`."""
        if self._world is None:
            raise LpbError("this collision space is closed; make a new one")
        return self._world

    def _arrange(self, obstacles: Sequence[Obstacle]) -> None:
        self._arranged = list(obstacles)
        place_at_start(self.world, obstacles)
        self._collision = SpatialCollision(self._robot, self.world, [obstacle.name for obstacle in obstacles])

    def clearance(self, q: Sequence[float]) -> Clearance:
        """Signed distance [m] to the nearest obstacle with body and obstacle; NaN without obstacles."""
        return self._at(q, self._obstacles).obstacles.nearest()

    def self_clearance(self, q: Sequence[float]) -> Clearance:
        """Signed distance [m] between the robot's own bodies; NaN without pairs."""
        return self._at(q, self._arranged).own.nearest()

    def clearance_of(self, obstacle: Obstacle, q: Sequence[float]) -> float:
        """Signed distance [m] of the robot to one further obstacle."""
        return self._at(q, [obstacle]).obstacles.nearest()[0]

    def _at(self, q: Sequence[float], obstacles: Sequence[Obstacle]) -> SpatialCollision:
        if len(obstacles) != len(self._arranged) or any(
            one is not other for one, other in zip(obstacles, self._arranged, strict=True)
        ):
            self._arrange(obstacles)
        self.world.set_q(q)
        self._collision.forget()
        return self._collision

    def close(self) -> None:
        """Give the world back; again is no harm."""
        if self._world is not None:
            give_back(self._robot, self._world)
            self._world = None


def place_at_start(world: World, obstacles: Sequence[Obstacle]) -> None:
    """Have these obstacles in a world, where they are at t = 0."""
    world.set_obstacles(obstacles)
    for index, obstacle in enumerate(obstacles):
        positions, orientations = obstacle.poses(np.zeros(1))
        world.place(index, positions[0].tolist(), orientations[0].tolist())


def always_overlapping(robot: SpatialRobot, pairs: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Pairs of links whose collision geometry overlaps in every one of `ALWAYS` configurations within the limits.

    The configurations are the same each time. Their contact says nothing of how the robot moves.
    """
    generator = np.random.Generator(np.random.PCG64(0))
    limits = np.clip(robot.limits.position, -UNLIMITED_RANGE, UNLIMITED_RANGE)
    world = borrow_world(robot)
    world.set_obstacles([])
    left = list(pairs)
    for _ in range(ALWAYS):
        if not left:
            break
        world.set_q((limits[:, 0] + generator.random(robot.dof) * (limits[:, 1] - limits[:, 0])).tolist())
        left = [pair for pair in left if world.overlap(*pair)]
    give_back(robot, world)
    return left


def overlaps(robot: SpatialRobot, pairs: Sequence[tuple[str, str]], configurations: FloatArray) -> NDArray[np.bool_]:
    """Whether the collision geometry of pairs of links overlaps at each q (N, dof): (N, pairs)."""
    world = borrow_world(robot)
    found = np.zeros((len(configurations), len(pairs)), dtype=bool)
    try:
        world.set_obstacles([])
        for row, q in enumerate(configurations.tolist()):
            world.set_q(q)
            found[row] = [world.overlap(*pair) for pair in pairs]
    finally:
        give_back(robot, world)
    return found
