"""The planar engine: exact motion under constant input, exact distances; scalars throughout."""

from __future__ import annotations

from math import inf

from pytest_lpb.environment.continuous import StepBounds, Travel
from pytest_lpb.environment.limits import check_measure
from pytest_lpb.environment.obstacle_travel import ObstacleTravel
from pytest_lpb.problem.collision import Clearance
from pytest_lpb.problem.planar.collision import CONTACT_SLACK_M, PlanarCollision
from pytest_lpb.problem.planar.robot import Frame, PlanarRobot
from pytest_lpb.problem.planar.swept_bodies import BodySpeeds, PlanarStep, PlanarSweptBodies
from pytest_lpb.problem.problem import Problem

BEYOND_MEASURE = 1e12  # [m or rad] beyond this a position is a sign of divergence, and sines lose all digits


class PlanarEngine(StepBounds):
    """Kinematic simulation in the plane: the low-level controller is perfect, as the paper assumes."""

    contact_slack_m = CONTACT_SLACK_M

    q: list[float]
    u: list[float]
    qd: list[float]
    frames: list[Frame]

    def __init__(self, problem: Problem) -> None:
        robot = problem.robot
        assert isinstance(robot, PlanarRobot), f"{robot.model} is no planar robot"
        self._robot = robot
        self._dt = problem.dt
        self._collision = PlanarCollision(robot, problem.obstacles)
        self._obstacles = problem.obstacles
        # A robot of a user's own may not say how fast its links move.
        self._is_continuous = type(robot).link_speeds is not PlanarRobot.link_speeds
        if self._is_continuous:
            self._speeds = BodySpeeds(robot, self._collision)
            units = [1.0] * robot.n_actions
            self.prepare_bounds(self._speeds.fastest(units, units), holds_velocity=problem.control == "velocity")
        radii = [shape.circumradius for shape in self._collision.shapes]
        self._travel = ObstacleTravel(problem.obstacles, radii, problem.dt)

    def set_state(self, q: list[float], u: list[float]) -> None:
        """Put the robot into a state: q (dof,), u (n_actions,)."""
        self.q, self.u = q, u
        self._peak = max(map(abs, u))
        self._refresh()

    def advance(self, action: list[float]) -> None:
        """Move by dt under a constant action (n_actions,)."""
        try:
            q, u = self._robot.integrate(self.q, self.u, action, self._dt)
        except (OverflowError, ValueError):
            q, u = [inf], self.u
        check_measure(q, action, BEYOND_MEASURE)
        self._last = (self.q, self.u, action)
        self.q, self.u = q, u
        self._refresh()

    def _refresh(self) -> None:
        self.frames = self._robot.frames(self.q)
        self.qd = self._robot.joint_velocity(self.q, self.u)

    def place_obstacles(self, positions: list[list[float]], orientations: list[float]) -> None:
        """Move all obstacles: positions (n, 2) [m], angles (n,) [rad]."""
        for shape, (x, y), angle in zip(self._collision.shapes, positions, orientations, strict=True):
            shape.place(x, y, angle)

    def clearance(self) -> tuple[Clearance, Clearance]:
        """Signed distance to the nearest obstacle, and between the robot's own bodies."""
        capsules = self._collision.capsules(self.frames)
        return self._collision.clearance(capsules), self._collision.self_clearance(capsules)

    @property
    def continuous(self) -> StepBounds | None:
        """Itself, unless the robot does not say how fast its links move."""
        return self if self._is_continuous else None

    def travel_of(self, row: int, before: list[float], q: list[float], u: list[float]) -> Travel:  # noqa: ARG002
        """Bounds of how much distances changed on the way to a row [m], see `StepBounds`."""
        farthest, closing = self._speeds.fastest(u if self.holds_velocity else before, u)
        dt = self._dt
        return farthest * dt + self._travel.farthest(row), closing * dt

    def swept_bodies(self, row: int) -> PlanarSweptBodies:
        """All pairs of bodies on the way to this row; call `restore` when done."""
        return self.swept_bodies_of(row, *self._last, (self.q, self.u))

    def swept_bodies_of(
        self, row: int, q: list[float], u: list[float], action: list[float], after: tuple[list[float], list[float]]
    ) -> PlanarSweptBodies:
        """The same for any step of the trial, by the state before it, the action, and the state (q, u) after it."""
        peaks = (after[1] if self.holds_velocity else u, after[1])
        step = PlanarStep(q, u, action, peaks, (row - 1) * self._dt, self._dt, self._travel.each(row))
        return PlanarSweptBodies(self._robot, self._collision, self._speeds, self._obstacles, step)

    def restore(self) -> None:
        """Nothing to do: where any obstacle moves, all are placed anew at each row."""

    def close(self) -> None:
        """Nothing to free."""
