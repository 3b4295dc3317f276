"""The planar engine: exact motion under constant input, exact distances; scalars throughout."""

from __future__ import annotations

from math import inf

from pytest_lpb.environment.limits import check_measure
from pytest_lpb.problem.collision import Clearance
from pytest_lpb.problem.planar.collision import CONTACT_SLACK_M, PlanarCollision
from pytest_lpb.problem.planar.robot import Frame, PlanarRobot
from pytest_lpb.problem.problem import Problem

BEYOND_MEASURE = 1e12  # [m or rad] beyond this a position is a sign of divergence, and sines lose all digits


class PlanarEngine:
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

    def set_state(self, q: list[float], u: list[float]) -> None:
        """Put the robot into a state: q (dof,), u (n_actions,)."""
        self.q, self.u = q, u
        self._refresh()

    def advance(self, action: list[float]) -> None:
        """Move by dt under a constant action (n_actions,)."""
        try:
            q, u = self._robot.integrate(self.q, self.u, action, self._dt)
        except (OverflowError, ValueError):
            q, u = [inf], self.u
        check_measure(q, action, BEYOND_MEASURE)
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

    def close(self) -> None:
        """Nothing to free."""
