"""The PyBullet engine: spatial robots, moved exactly or by simulated forces, with exact clearance."""

from __future__ import annotations

from math import inf
from typing import Protocol

import numpy as np

from pytest_lpb.environment.bullet_dynamics import DynamicMotion
from pytest_lpb.environment.limits import check_measure
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.collision import Clearance
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.spatial.clearance import CONTACT_SLACK_M, SpatialCollision
from pytest_lpb.problem.spatial.pool import borrow_world, give_back
from pytest_lpb.problem.spatial.robot import Frame, SpatialRobot
from pytest_lpb.problem.spatial.world import World

BEYOND_MEASURE = 1e6  # [m or rad] beyond this a position is a sign of divergence


class Motion(Protocol):
    """How actions move the robot of a world; state in, state out."""

    def start(self, q: list[float], u: list[float]) -> tuple[list[float], list[float]]:
        """Put the robot into a state; the state it has then."""

    def advance(self, q: list[float], u: list[float], action: list[float]) -> tuple[list[float], list[float]]:
        """Move by one step under a constant action; the state after it."""

    def release(self) -> None:
        """Let go of the world."""


class KinematicMotion:
    """Exact motion: the low-level controller is perfect, as the paper assumes."""

    def __init__(self, problem: Problem, robot: SpatialRobot, world: World) -> None:
        self._robot = robot
        self._world = world
        self._dt = problem.dt

    def start(self, q: list[float], u: list[float]) -> tuple[list[float], list[float]]:
        """Put the robot into a state."""
        self._world.set_q(q)
        return q, u

    def advance(self, q: list[float], u: list[float], action: list[float]) -> tuple[list[float], list[float]]:
        """State after dt under a constant action, in closed form."""
        q, u = self._robot.integrate(q, u, action, self._dt)
        self._world.set_q(q)
        return q, u

    def release(self) -> None:
        """Give the world back: it is as good as new."""
        give_back(self._robot, self._world)


class LinkFrames:
    """Frames of the robot's links in the world, asked of PyBullet one by one."""

    def __init__(self, world: World) -> None:
        self._world = world

    def __getitem__(self, link: int) -> Frame:
        return self._world.frame(link)


class BulletEngine:
    """Simulation of a spatial robot in a PyBullet client of its own."""

    contact_slack_m = CONTACT_SLACK_M

    q: list[float]
    u: list[float]
    qd: list[float]
    frames: LinkFrames

    def __init__(self, problem: Problem) -> None:
        robot = problem.robot
        assert isinstance(robot, SpatialRobot), f"{robot.name} is no spatial robot"
        self._robot = robot
        robot.self_collision_pairs  # noqa: B018 - finding them needs a world, which can then be this one
        self._world = World(robot) if problem.dynamics else borrow_world(robot)
        self._motion: Motion = (DynamicMotion if problem.dynamics else KinematicMotion)(problem, robot, self._world)
        self.frames = LinkFrames(self._world)
        try:
            self._world.set_obstacles(problem.obstacles)
        except ScenarioError:
            self._world.close()
            raise
        self._collision = SpatialCollision(robot, self._world, [obstacle.name for obstacle in problem.obstacles])
        self._positions = np.full((len(problem.obstacles), 3), inf)
        self._orientations = np.zeros((len(problem.obstacles), 4))

    def set_state(self, q: list[float], u: list[float]) -> None:
        """Put the robot into a state: q (dof,), u (n_actions,)."""
        self.q, self.u = self._motion.start(q, u)
        self.qd = self._robot.joint_velocity(self.q, self.u)
        self._collision.forget()

    def advance(self, action: list[float]) -> None:
        """Move by dt under a constant action (n_actions,)."""
        before = self.q
        try:
            q, u = self._motion.advance(before, self.u, action)
        except (OverflowError, ValueError):
            q, u = [inf], self.u
        check_measure(q, action, BEYOND_MEASURE)
        self.q, self.u = q, u
        self.qd = self._robot.joint_velocity(q, u)
        self._collision.moved(np.subtract(q, before))

    def place_obstacles(self, positions: list[list[float]], orientations: list[list[float]]) -> None:
        """Move all obstacles: positions (n, 3) [m], orientations wxyz (n, 4)."""
        if not positions:
            return
        wanted, turned = np.array(positions), np.array(orientations)
        shift, turn = wanted - self._positions, turned - self._orientations
        for index in np.flatnonzero(shift.any(axis=1) | turn.any(axis=1)).tolist():
            self._world.place(index, positions[index], orientations[index])
        self._positions, self._orientations = wanted, turned
        self._collision.obstacles_moved(shift, turn)

    def clearance(self) -> tuple[Clearance, Clearance]:
        """Signed distance to the nearest obstacle, and between the robot's own bodies."""
        return self._collision.obstacles.nearest(), self._collision.own.nearest()

    def close(self) -> None:
        """Let the world go; again is no harm."""
        if self._motion is not None:
            self._motion.release()
            self._motion = None  # type: ignore[assignment] # nobody moves a closed engine
