"""Artificial potential fields: the goal attracts, obstacles and joint limits repel.

Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", International Journal of Robotics Research
5(1), 1986: the attraction with a limited velocity, the FIRAS repulsion of points subjected to the potential, joint
limit avoidance, and forces brought to the joints by J^T Lambda (docs/planners.md has the equations).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import sqrt
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from pytest_lpb.motion.directions import LONGEST, lengths, scaled, unit
from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.planner.fields import ControlPoints, Distances, ObstacleField, Points, SelfDistances
from pytest_lpb.planner.known import check_shapes
from pytest_lpb.planner.spatial_fields import SpatialControlPoints, SpatialObstacleField, SpatialSelfDistances
from pytest_lpb.planner.task import SUPPORTED, Task, check_control, damped_inverse

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]

NOTHING = (np.zeros((0, 2, 0)), np.zeros((0, 2)))  # no points, no forces

# Control points, distances to obstacles and between the robot's own bodies, by dimension.
GEOMETRY: dict[int, tuple[Callable[..., Points], Callable[..., Distances], Callable[..., SelfDistances]]] = {
    2: (ControlPoints, ObstacleField, lambda robot, points, _: SelfDistances(robot, points)),
    3: (SpatialControlPoints, SpatialObstacleField, SpatialSelfDistances),
}


class PotentialField(Planner):
    """Khatib's potential field. The actuated velocities have unit inertia, so that forces are accelerations.

    It sees where obstacles are, never how they move, and it comes to rest in local minima.
    """

    name: ClassVar[str] = "potential_field"
    supports: ClassVar[Mapping[str, tuple[str, ...]]] = SUPPORTED

    @dataclass(frozen=True)
    class Parameters:
        """Gains of the attraction (stiffness, damping, speed) and of the repulsion (repulsion, influence)."""

        stiffness: NotNegative = 4.0  # k_p of the goal [1/s^2]
        damping: Positive = 4.0  # k_v [1/s]
        speed: Positive = 1.0  # largest speed a sub-goal asks for [m/s or rad/s]
        repulsion: NotNegative = 0.01  # eta of obstacles [m^4/s^2]
        influence: Positive = 0.4  # distance rho_0 from which an obstacle repels [m]
        self_influence: Positive = 0.15  # rho_0 of the robot's own bodies [m]
        closest: Positive = 0.05  # distances are not taken smaller than this, to bound the force [m or rad]
        limit_repulsion: NotNegative = 0.001  # eta of position limits [rad^4/s^2 or m^4/s^2]
        limit_influence: Positive = 0.2  # rho_0 of position limits [rad or m]
        joint_damping: NotNegative = 2.0  # of motions the goal says nothing about [1/s]
        regularisation: Positive = 0.1  # of Lambda, for singular arms [m]
        spacing: Positive = 0.1  # largest distance between control points along a link [m]
        lookahead: Positive = 0.3  # a non-holonomic base is steered by the point this far ahead of it [m]

    parameters: Parameters

    def setup(self, problem: PlannerProblem) -> None:
        """Place the control points and compose the goal's task."""
        check_control(self.name, problem)
        check_shapes(self.name, problem)
        parameters = self.parameters
        self._axes = np.arange(problem.dimension)
        self._task = Task(problem, parameters.lookahead)
        control_points, obstacle_field, own_distances = GEOMETRY[problem.dimension]
        self._points = control_points(problem.robot, parameters.spacing, parameters.lookahead)
        pairs = problem.robot.self_collision_pairs
        self._own = own_distances(problem.robot, self._points, parameters.self_influence) if pairs else None
        # A robot without collision geometry has no point that could be near to anything.
        met = bool(problem.obstacles) and len(self._points.radii) > 0
        self._obstacles = obstacle_field(problem.obstacles) if met else None
        self._limits = problem.robot.limits.position.T
        self._limited = bool(np.isfinite(self._limits).any())
        self._velocity_control = problem.control == "velocity"
        self._robot = problem.robot

    def compute_action(self, observation: Observation) -> FloatArray:
        """Acceleration of u, or u itself under velocity control: the velocity at which damping balances the forces."""
        return self._task.actuation.command(self._composed(observation), observation)

    def _composed(self, observation: Observation) -> FloatArray:
        """The action of the inputs: attraction, repulsion, limits."""
        q = observation["q"]
        action = self._attraction(observation)
        push = self._repulsion(observation, q) if self._obstacles is not None or self._own is not None else None
        if self._limited:
            limits = self._limit_force(q)
            columns = self._task.actuation.input_map(q)
            if columns is not None:
                limits = limits @ columns
            push = limits if push is None else push + limits
        if push is None:
            return action
        return action + push / self.parameters.damping if self._velocity_control else action + push

    def _attraction(self, observation: Observation) -> FloatArray:
        """F* = k_v (v_wanted - v), with v_wanted = (k_p / k_v) e no faster than `speed`, brought to the joints."""
        parameters, task = self.parameters, self._task
        u = task.actuation.inputs(observation)
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
                part[:] = limit * unit(part, np.float64(speed)) if speed > LONGEST else part * (limit / speed)
        return wanted + self._task.target_velocity(observation) if self._task.moving else wanted

    def _repulsion(self, observation: Observation, q: FloatArray) -> FloatArray:
        """FIRAS forces of obstacles and of the robot's own bodies, brought to the joints by J^T Lambda."""
        positions, jacobians = self._points.at(q)
        total: FloatArray = np.zeros(len(observation["u"]))
        for pushed, forces in (
            self._from_obstacles(positions, jacobians, observation),
            self._from_own_bodies(positions, jacobians),
        ):
            if len(forces):
                total += self._actuated(pushed, forces, q)
        return total

    def _from_obstacles(
        self, positions: FloatArray, jacobians: FloatArray, observation: Observation
    ) -> tuple[FloatArray, FloatArray]:
        """Jacobians (k, d, dof) and forces (k, d) of the control points nearest of their bodies to an obstacle."""
        parameters, points = self.parameters, self._points
        if self._obstacles is None:
            return NOTHING
        distance, away = self._obstacles.distances(positions, observation)
        distance -= points.radii[:, None]
        if distance.min() >= parameters.influence:
            return NOTHING
        bounded = np.maximum(distance, parameters.closest)
        pushes = firas(bounded, parameters.repulsion, parameters.influence) * points.nearest(distance)
        active = pushes.any(axis=1)
        return jacobians[active], (pushes[active, :, None] * away[active]).sum(axis=1)

    def _from_own_bodies(self, positions: FloatArray, jacobians: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Jacobians (k, d, dof) and forces (k, d) of points relative to the nearest ones of other bodies."""
        parameters = self.parameters
        if self._own is None:
            return NOTHING
        first, second, distance = self._own.nearest(positions, parameters.self_influence)
        if not len(first):
            return NOTHING
        offset = positions[first] - positions[second]
        offset, length = scaled(offset, lengths(offset))
        bounded = np.maximum(distance, parameters.closest)
        pushes = firas(bounded, parameters.repulsion, parameters.self_influence) / length
        return jacobians[first] - jacobians[second], pushes[:, None] * offset

    def _actuated(self, jacobians: FloatArray, forces: FloatArray, q: FloatArray) -> FloatArray:
        """Sum of J^T Lambda F over points with Jacobians (k, dimension, dof) and forces (k, dimension)."""
        jacobians = self._task.actuation.per_input(jacobians, q, 0.0)
        transposed = jacobians.transpose(0, 2, 1)
        square = jacobians @ transposed
        square[:, self._axes, self._axes] += self.parameters.regularisation * self.parameters.regularisation
        total: FloatArray = (transposed @ np.linalg.solve(square, forces[:, :, None])).sum(axis=0)[:, 0]
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
