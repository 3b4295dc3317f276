"""A fabric composed for a robot, its goal and room for obstacles, as one CasADi function."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import casadi

from pytest_lpb.planner.base import GoalInfo
from pytest_lpb.planner.fabrics.geometries import Geometries
from pytest_lpb.planner.fabrics.leaves import Attractor
from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.fabrics.specs import SIGNS, Spec
from pytest_lpb.planner.fabrics.speed import controlled
from pytest_lpb.planner.scene.goals import ERRORS
from pytest_lpb.planner.scene.maps import Reference, State
from pytest_lpb.planner.scene.shapes import length
from pytest_lpb.problem.robot import Robot


class Composer:
    """Composes the fabric of a robot.

    Args:
        robot: any robot.
        goals: sub-goals, without their targets.
        capacities: slots per shape of obstacles.
        parameters: of the planner.
        period: of the planner [s], at whose end the brake looks.

    Attributes:
        state: symbols of the robot's state.
        geometries: what bends its motion.
    """

    def __init__(
        self,
        robot: Robot,
        goals: Sequence[GoalInfo],
        capacities: Mapping[str, int],
        parameters: FabricsParameters,
        period: float,
    ) -> None:
        self._parameters = parameters
        self._goals = goals
        self._capacities = capacities
        self._period = period
        self.state = State(robot)
        self.geometries = Geometries(self.state, parameters)

    def function(self) -> Any:
        """The composed function to the acceleration of the inputs, `action` (n,).

        Of `q` (dof,), the inputs `w` (n,), a matrix `goalK` (size, 3) per sub-goal (target, its velocity, its
        acceleration), and a matrix `obstacles_SHAPE` per shape with a column per slot as `layout.Slot` says.
        """
        targets = {
            f"goal{place}": casadi.SX.sym(f"goal{place}", goal.size, 3) for place, goal in enumerate(self._goals)
        }
        obstacles = {
            shape: self.geometries.obstacle_symbols(shape, capacity) for shape, capacity in self._capacities.items()
        }
        geometry = self.geometries.total(obstacles)
        forced, target_velocity, distance = self._forced(geometry, list(targets.values()))
        action = controlled(geometry, forced, self.state.inputs, target_velocity, distance, self._parameters)
        action = self._shortened(self._braked(action, obstacles))
        arguments = {
            "q": self.state.q,
            "w": self.state.inputs,
            **targets,
            **{f"obstacles_{shape}": symbols for shape, symbols in obstacles.items()},
        }
        return casadi.Function(
            "fabric",
            list(arguments.values()),
            [casadi.densify(action)],
            list(arguments),
            ["action"],
            {"cse": True},
        )

    def points(self) -> Any:
        """Function of q to the centres of all balls, (d, balls) [m], to find the nearest points of meshes."""
        places = casadi.horzcat(*(ball.place(self.state.frames) for ball in self.geometries.balls))
        return casadi.Function("points", [self.state.q], [casadi.densify(places)], ["q"], ["points"], {"cse": True})

    def _forced(self, geometry: Spec, targets: Sequence[Any]) -> tuple[Spec, Any, Any]:
        """The geometries with the attractors, the inputs' velocity that follows the targets, the distance left."""
        parameters, state = self._parameters, self.state
        attractor = Attractor(parameters.attractor_energy, parameters.attractor_potential)
        total, follow, left = geometry, casadi.SX.zeros(state.size, 1), []
        all_wanted = all(goal.tolerance is None for goal in self._goals if goal.weight)
        for goal, target in zip(self._goals, targets, strict=True):
            if not goal.weight:
                continue
            reference = Reference(*casadi.horzsplit(target))
            error = ERRORS[state.robot.dimension, goal.type](state, goal, reference.value, parameters.lookahead)
            mapped = state.mapped(error, reference)
            spec = attractor.spec(mapped, goal.weight)
            total += spec.pulled_back(mapped, SIGNS[parameters.curvature_term])
            # What the target's own motion does to the error is to be made good by the robot's.
            drift = casadi.jtimes(error, reference.value, reference.velocity)
            follow -= mapped.jacobian.T @ (spec.metric @ drift)
            if goal.tolerance is not None or all_wanted:
                left.append(error)
        return total, follow, length(casadi.vertcat(*left)) if left else casadi.SX(0.0)

    def _braked(self, action: Any, obstacles: Mapping[str, Any]) -> Any:
        """The action that leads to the velocity which the brake leaves of the one wanted after a period."""
        if not self._parameters.brake:
            return action
        wanted = self.state.inputs + self._period * action
        return (self.geometries.damping(obstacles, wanted).velocity(wanted) - self.state.inputs) / self._period

    def _shortened(self, action: Any) -> Any:
        """The action with its direction kept, within the robot's acceleration limits and the planner's own."""
        parameters = self._parameters
        ratios = [casadi.SX(1.0)]
        if parameters.respect_limits:
            limits = self.state.robot.limits.acceleration.tolist()
            for entry, (lower, upper) in zip(casadi.vertsplit(action), limits, strict=True):
                ratios += [entry / limit for limit in (lower, upper) if isfinite(limit) and limit]
        if parameters.largest_acceleration is not None:
            ratios.append(length(action) / parameters.largest_acceleration)
        return action / casadi.mmax(casadi.vertcat(*ratios)) if len(ratios) > 1 else action
