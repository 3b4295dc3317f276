"""The PyBullet engine: spatial robots, moved exactly or by simulated forces, with exact clearance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import Protocol

import numpy as np

from pytest_lpb.environment.bullet_dynamics import DynamicMotion
from pytest_lpb.environment.continuous import NO_BOUND, StepBounds, Travel
from pytest_lpb.environment.limits import check_measure
from pytest_lpb.environment.obstacle_travel import ObstacleTravel
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.collision import Clearance
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.clearance import CONTACT_SLACK_M, SpatialCollision
from pytest_lpb.problem.spatial.pool import borrow_world, give_back
from pytest_lpb.problem.spatial.robot import Frame, SpatialRobot
from pytest_lpb.problem.spatial.space import place_at_start
from pytest_lpb.problem.spatial.swept_bodies import SpatialStep, SpatialSweptBodies
from pytest_lpb.problem.spatial.world import World

BEYOND_MEASURE = 1e6  # [m or rad] beyond this a position is a sign of divergence


class Motion(Protocol):
    """How actions move the robot of a world; state in, state out."""

    def start(self, q: list[float], u: list[float]) -> tuple[list[float], list[float]]:
        """Put the robot into a state; the state it has then."""

    def advance(self, q: list[float], u: list[float], action: list[float]) -> tuple[list[float], list[float]]:
        """Move by one step under a constant action; the state after it."""

    def rates(self, row: int, before: list[float], q: list[float], u: list[float]) -> list[float]:
        """Bounds (dof,) of the rates of q on the way to a row, see `SpatialRobot.peak_rates`.

        Args:
            row: at the end of the step.
            before: u at its beginning.
            q, u: at its end.
        """

    def path(self, row: int, q: list[float], u: list[float], action: list[float]) -> Callable[[float], Sequence[float]]:
        """The configuration at a share of the way to a row, by the state before it and the action."""

    def release(self) -> None:
        """Let go of the world."""


class KinematicMotion:
    """Exact motion: the low-level controller is perfect, as the paper assumes."""

    def __init__(self, problem: Problem, robot: SpatialRobot, world: World) -> None:
        self._robot = robot
        self._world = world
        self._dt = problem.dt
        self._holds_velocity = problem.control == "velocity"

    def start(self, q: list[float], u: list[float]) -> tuple[list[float], list[float]]:
        """Put the robot into a state."""
        self._world.set_q(q)
        return q, u

    def advance(self, q: list[float], u: list[float], action: list[float]) -> tuple[list[float], list[float]]:
        """State after dt under a constant action, in closed form."""
        q, u = self._robot.integrate(q, u, action, self._dt)
        self._world.set_q(q)
        return q, u

    def rates(self, row: int, before: list[float], q: list[float], u: list[float]) -> list[float]:  # noqa: ARG002
        """Bounds of the rates of q, from the actuated velocity at both ends."""
        return self._robot.peak_rates(q, u if self._holds_velocity else before, u, self._dt)

    def path(self, row: int, q: list[float], u: list[float], action: list[float]) -> Callable[[float], Sequence[float]]:  # noqa: ARG002
        """The exact motion."""

        def at(share: float) -> list[float]:
            return self._robot.integrate(q, u, action, share * self._dt)[0]

        return at

    def release(self) -> None:
        """Give the world back: it is as good as new."""
        give_back(self._robot, self._world)


class LinkFrames:
    """Frames of the robot's links in the world, asked of PyBullet one by one."""

    def __init__(self, world: World) -> None:
        self._world = world

    def __getitem__(self, link: int) -> Frame:
        return self._world.frame(link)


class BulletEngine(StepBounds):
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
        self._world = World(robot, simulated=True) if problem.dynamics else borrow_world(robot)
        self._motion: Motion = (DynamicMotion if problem.dynamics else KinematicMotion)(problem, robot, self._world)
        self.frames = LinkFrames(self._world)
        try:
            self._world.set_obstacles(problem.obstacles)
        except ScenarioError:
            self._world.close()
            raise
        self._collision = SpatialCollision(robot, self._world, [obstacle.name for obstacle in problem.obstacles])
        self._obstacles = problem.obstacles
        self._dt = problem.dt
        self.prepare_bounds(self._speed_per_rate(problem), holds_velocity=problem.control == "velocity")
        self._travel = ObstacleTravel(problem.obstacles, self._world.obstacle_radii, problem.dt)
        # Simulated forces have a history: bodies are moved along a step in another world.
        self._geometry: tuple[World, SpatialCollision] | None = (
            None
            if problem.dynamics
            else (
                self._world,
                self._collision,
            )
        )
        self._positions = np.full((len(problem.obstacles), 3), inf)
        self._orientations = np.zeros((len(problem.obstacles), 4))

    def set_state(self, q: list[float], u: list[float]) -> None:
        """Put the robot into a state: q (dof,), u (n_actions,)."""
        self.q, self.u = self._motion.start(q, u)
        self.qd = self._robot.joint_velocity(self.q, self.u)
        self._peak = max(map(abs, self.u))
        self._collision.forget()

    def advance(self, action: list[float]) -> None:
        """Move by dt under a constant action (n_actions,)."""
        before = self.q
        try:
            q, u = self._motion.advance(before, self.u, action)
        except (OverflowError, ValueError):
            q, u = [inf], self.u
        check_measure(q, action, BEYOND_MEASURE)
        self._last = (before, self.u, action)
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

    @property
    def continuous(self) -> StepBounds:
        """Itself: it knows all motions, simulated ones by their substeps."""
        return self

    def _speed_per_rate(self, problem: Problem) -> Travel:
        """See `StepBounds`; none where forces are simulated, or a steering angle counts as well."""
        robot = self._robot
        if problem.dynamics or robot.steers:
            return NO_BOUND, NO_BOUND
        units = [1.0] * robot.n_actions
        return self._collision.farthest(robot.peak_rates([0.0] * robot.dof, units, units, self._dt))

    def travel_of(self, row: int, before: list[float], q: list[float], u: list[float]) -> Travel:
        """Bounds of how much distances changed on the way to a row [m], see `StepBounds`."""
        farthest, closing = self._collision.farthest(self._motion.rates(row, before, q, u))
        return farthest * self._dt + self._travel.farthest(row), closing * self._dt

    def swept_bodies(self, row: int) -> SpatialSweptBodies:
        """All pairs of bodies on the way to this row; call `restore` when done."""
        known = np.concatenate([self._collision.obstacles.bounds, self._collision.own.bounds])
        return self._swept_bodies(row, *self._last, self.q, self.u, known)

    def swept_bodies_of(
        self, row: int, q: list[float], u: list[float], action: list[float], after: tuple[list[float], list[float]]
    ) -> SpatialSweptBodies:
        """The same for any step of the trial, by the state before it, the action, and the state (q, u) after it."""
        return self._swept_bodies(row, q, u, action, *after, None)

    def _swept_bodies(
        self,
        row: int,
        q: list[float],
        u: list[float],
        action: list[float],
        q_after: list[float],
        u_after: list[float],
        bounds: FloatArray | None,
    ) -> SpatialSweptBodies:
        if self._geometry is None:
            world = borrow_world(self._robot)
            place_at_start(world, self._obstacles)
            self._geometry = world, SpatialCollision(self._robot, world, [o.name for o in self._obstacles])
        step = SpatialStep(
            self._motion.path(row, q, u, action),
            np.array(self._motion.rates(row, u, q_after, u_after)),
            (row - 1) * self._dt,
            self._dt,
            self._travel.each(row),
            bounds,
        )
        return SpatialSweptBodies(*self._geometry, self._obstacles, step)

    def restore(self) -> None:
        """Put robot and obstacles back to where they are at the current row."""
        if self._geometry is None or self._geometry[0] is not self._world:
            return
        self._world.set_q(self.q)
        for index, obstacle in enumerate(self._obstacles):
            if obstacle.moving:
                self._world.place(index, self._positions[index].tolist(), self._orientations[index].tolist())

    def close(self) -> None:
        """Let the world go; again is no harm."""
        if self._motion is not None:
            self._motion.release()
            if self._geometry is not None and self._geometry[0] is not self._world:
                give_back(self._robot, self._geometry[0])
            self._motion = None  # type: ignore[assignment] # nobody moves a closed engine
