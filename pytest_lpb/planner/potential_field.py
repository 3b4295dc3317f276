"""Artificial potential fields: the goal attracts, obstacles and joint limits repel.

Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", International Journal of Robotics Research
5(1), 1986: the attraction with a velocity limit (equations 16 and 17), the repulsion of a point subject to the
potential (FIRAS, equation 19), and forces mapped to joints by transposed Jacobians (equation 5).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.planner.fields import ControlPoints, ObstacleField
from pytest_lpb.planner.task import Task


class PotentialField(Planner):
    """Khatib's potential field; forces act on unit masses, so they are accelerations of the actuated velocities."""

    name: ClassVar[str] = "potential_field"

    @dataclass(frozen=True)
    class Parameters:
        """Gains of the attraction (k_p, k_v, speed) and of the repulsion (eta, influence)."""

        stiffness: float = 4.0  # k_p of the goal [1/s^2]
        damping: float = 4.0  # k_v [1/s]
        speed: float = 1.0  # largest speed the goal asks for [m/s, or rad/s for joint goals]
        repulsion: float = 0.1  # eta [m^4/s^2]
        influence: float = 0.5  # distance rho_0 from which an obstacle repels [m]
        closest: float = 0.02  # distances are not taken smaller than this, to bound the force [m]
        limit_repulsion: float = 0.01  # eta of joint limits [rad^4/s^2]
        limit_influence: float = 0.2  # rho_0 of joint limits [rad]
        joint_damping: float = 1.0  # of motions the goal says nothing about [1/s]
        spacing: float = 0.25  # between control points along a link [m]
        lookahead: float = 0.3  # a non-holonomic base is steered by the point this far ahead of it [m]

    parameters: Parameters

    def setup(self, problem: PlannerProblem) -> None:
        """Place the control points and compose the goal's task."""
        parameters = self.parameters
        self._task = Task(problem, parameters.lookahead)
        self._points = ControlPoints(problem.robot, parameters.spacing)
        self._obstacles = ObstacleField(problem.obstacles) if problem.obstacles else None
        self._limits = problem.robot.limits.position
        self._limited = bool(np.isfinite(self._limits).any())
        self._velocity_control = problem.control == "velocity"
        self._map = problem.robot.action_map

    def compute_action(self, observation: Observation) -> FloatArray:
        """Acceleration of u, or u itself under velocity control: the velocity at which damping balances the forces."""
        q, u = observation["q"], observation["u"]
        force = self._attraction(observation)
        if self._obstacles is not None:
            force += self._repulsion(observation, q)
        if self._limited:
            force += self._limit_force(q) @ self._map(q)
        if self._velocity_control:
            velocity: FloatArray = force / self.parameters.damping
            return velocity
        damped: FloatArray = force - self.parameters.joint_damping * u
        return damped

    def _attraction(self, observation: Observation) -> FloatArray:
        parameters = self.parameters
        error, jacobian = self._task.error(observation)
        wanted = (parameters.stiffness / parameters.damping) * error
        speed = float(np.sqrt(wanted @ wanted))
        if speed > parameters.speed:
            wanted *= parameters.speed / speed
        if not self._velocity_control:
            wanted = wanted - jacobian @ observation["u"]
        force: FloatArray = parameters.damping * (jacobian.T @ wanted)
        return force

    def _repulsion(self, observation: Observation, q: FloatArray) -> FloatArray:
        parameters = self.parameters
        points, jacobians = self._points.at(q)
        assert self._obstacles is not None
        distance, away = self._obstacles.distances(points, observation)
        distance = np.maximum(distance - self._points.radii[:, None], parameters.closest)
        pushes = firas(distance, parameters.repulsion, parameters.influence)
        forces = (pushes[:, :, None] * away).sum(axis=1)
        total: FloatArray = np.zeros(len(observation["u"]))
        for point in np.flatnonzero(pushes.any(axis=1)):
            total += forces[point] @ self._task.actuation.per_input(jacobians[point], q)
        return total

    def _limit_force(self, q: FloatArray) -> FloatArray:
        parameters = self.parameters
        margins = np.maximum(np.stack([q - self._limits[:, 0], self._limits[:, 1] - q]), parameters.closest)
        pushes = firas(margins, parameters.limit_repulsion, parameters.limit_influence)
        force: FloatArray = pushes[0] - pushes[1]
        return force


def firas(distance: FloatArray, gain: float, influence: float) -> FloatArray:
    """Khatib's repulsion gain (1/rho - 1/rho_0)/rho^2 within the influence rho_0, else 0; shapes as `distance`."""
    push: FloatArray = np.where(
        distance < influence, gain * (1.0 / distance - 1.0 / influence) / (distance * distance), 0.0
    )
    return push
