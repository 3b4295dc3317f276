"""Artificial potential fields: the goal attracts, obstacles and joint limits repel.

Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", International Journal of Robotics Research
5(1), 1986: the attraction with a limited velocity, the FIRAS repulsion of points subjected to the potential, joint
limit avoidance, and forces brought to the joints by J^T Lambda (docs/planners.md has the equations).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import ClassVar

import numpy as np

from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.planner.fields import ControlPoints, ObstacleField
from pytest_lpb.planner.task import Task, damped_inverse


class PotentialField(Planner):
    """Khatib's potential field. The actuated velocities have unit inertia, so that forces are accelerations.

    It sees where obstacles are, never how they move, and it comes to rest in local minima.
    """

    name: ClassVar[str] = "potential_field"

    @dataclass(frozen=True)
    class Parameters:
        """Gains of the attraction (stiffness, damping, speed) and of the repulsion (repulsion, influence)."""

        stiffness: float = 4.0  # k_p of the goal [1/s^2]
        damping: float = 4.0  # k_v [1/s]
        speed: float = 1.0  # largest speed a sub-goal asks for [m/s or rad/s]
        repulsion: float = 0.01  # eta of obstacles [m^4/s^2]
        influence: float = 0.4  # distance rho_0 from which an obstacle repels [m]
        closest: float = 0.05  # distances are not taken smaller than this, to bound the force [m or rad]
        limit_repulsion: float = 0.001  # eta of position limits [rad^4/s^2 or m^4/s^2]
        limit_influence: float = 0.2  # rho_0 of position limits [rad or m]
        joint_damping: float = 2.0  # of motions the goal says nothing about [1/s]
        regularisation: float = 0.1  # of Lambda, for singular arms [m]
        spacing: float = 0.1  # largest distance between control points along a link [m]
        lookahead: float = 0.3  # a non-holonomic base is steered by the point this far ahead of it [m]

    parameters: Parameters

    def setup(self, problem: PlannerProblem) -> None:
        """Place the control points and compose the goal's task."""
        parameters = self.parameters
        self._task = Task(problem, parameters.lookahead)
        self._points = ControlPoints(problem.robot, parameters.spacing)
        self._obstacles = ObstacleField(problem.obstacles) if problem.obstacles else None
        self._limits = problem.robot.limits.position.T
        self._limited = bool(np.isfinite(self._limits).any())
        self._velocity_control = problem.control == "velocity"
        self._robot = problem.robot

    def compute_action(self, observation: Observation) -> FloatArray:
        """Acceleration of u, or u itself under velocity control: the velocity at which damping balances the forces."""
        q = observation["q"]
        action = self._attraction(observation)
        push = self._repulsion(observation, q) if self._obstacles is not None else None
        if self._limited:
            limits = self._limit_force(q)
            if not self._task.actuation.direct:
                limits = limits @ self._robot.action_map(q)
            push = limits if push is None else push + limits
        if push is None:
            return action
        return action + push / self.parameters.damping if self._velocity_control else action + push

    def _attraction(self, observation: Observation) -> FloatArray:
        """F* = k_v (v_wanted - v), with v_wanted = (k_p / k_v) e no faster than `speed`, brought to the joints."""
        parameters, task, u = self.parameters, self._task, observation["u"]
        if task.direct:
            wanted = self._wanted(observation["goal_position"] - observation["q"], observation)
            return wanted if self._velocity_control else parameters.damping * (wanted - u)
        error, jacobian = task.error(observation)
        wanted = self._wanted(error, observation)
        inverse = damped_inverse(jacobian, parameters.regularisation)  # J^T Lambda
        if self._velocity_control:
            slow: FloatArray = inverse @ wanted
            return slow
        velocity = jacobian @ u
        free = u - inverse @ velocity  # motion that the goal does not see
        action: FloatArray = inverse @ (parameters.damping * (wanted - velocity)) - parameters.joint_damping * free
        return action

    def _wanted(self, error: FloatArray, observation: Observation) -> FloatArray:
        """The velocity wanted of the task's value: each sub-goal's limited on its own, plus its target's velocity."""
        parameters = self.parameters
        wanted: FloatArray = (parameters.stiffness / parameters.damping) * error
        for rows, weight in self._task.blocks:
            part = wanted[rows]
            speed, limit = sqrt(float(part @ part)), weight * parameters.speed
            if speed > limit:
                part *= limit / speed
        return wanted + self._task.target_velocity(observation) if self._task.moving else wanted

    def _repulsion(self, observation: Observation, q: FloatArray) -> FloatArray:
        """FIRAS forces on the nearest control point of each body and obstacle, brought to the joints by J^T Lambda."""
        parameters, points = self.parameters, self._points
        assert self._obstacles is not None
        positions, jacobians = points.at(q)
        distance, away = self._obstacles.distances(positions, observation)
        distance -= points.radii[:, None]
        total: FloatArray = np.zeros(len(observation["u"]))
        if distance.min() >= parameters.influence:
            return total
        bounded = np.maximum(distance, parameters.closest)
        pushes = firas(bounded, parameters.repulsion, parameters.influence) * points.nearest(distance)
        forces = (pushes[:, :, None] * away).sum(axis=1)
        active = pushes.any(axis=1)
        jacobians = self._task.actuation.per_input(jacobians[active], q)
        transposed = jacobians.transpose(0, 2, 1)
        square = jacobians @ transposed
        square[:, [0, 1], [0, 1]] += parameters.regularisation * parameters.regularisation
        total += (transposed @ np.linalg.solve(square, forces[active][:, :, None])).sum(axis=0)[:, 0]
        return total

    def _limit_force(self, q: FloatArray) -> FloatArray:
        """FIRAS forces of the lower and upper position limits, (dof,)."""
        parameters = self.parameters
        margins = np.abs(q - self._limits)
        if margins.min() >= parameters.limit_influence:
            return np.zeros(len(q))
        margins = np.maximum(margins, parameters.closest)
        pushes = firas(margins, parameters.limit_repulsion, parameters.limit_influence)
        force: FloatArray = pushes[0] - pushes[1]
        return force


def firas(distance: FloatArray, gain: float, influence: float) -> FloatArray:
    """Minus the slope of 1/2 gain (1/rho - 1/rho_0)^2: gain (1/rho - 1/rho_0)/rho^2 within the influence rho_0, else 0.

    `distance` is rho > 0 in any shape.
    """
    push: FloatArray = np.where(
        distance < influence, gain * (1.0 / distance - 1.0 / influence) / (distance * distance), 0.0
    )
    return push
