"""A fabric composed for a robot, its goal and room for obstacles, as one CasADi function.

Every leaf is pulled back analytically from places, Jacobians and curvature terms that are composed once per part; what
lies between a part and obstacles is summed over obstacles in the part's own space first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from math import isfinite
from typing import Any

import casadi
import numpy as np

from pytest_lpb.planner.base import GoalInfo
from pytest_lpb.planner.fabrics.goals import ERRORS
from pytest_lpb.planner.fabrics.layout import Slot
from pytest_lpb.planner.fabrics.leaves import Attractor, ScalarLeaf
from pytest_lpb.planner.fabrics.maps import Reference, State, derivatives
from pytest_lpb.planner.fabrics.parameters import NAMED, FabricsParameters
from pytest_lpb.planner.fabrics.parts import Ball, Part, distance_between
from pytest_lpb.planner.fabrics.robot_parts import parts_of
from pytest_lpb.planner.fabrics.self_collision import pairs_of
from pytest_lpb.planner.fabrics.shapes import MESH, SHAPES, length
from pytest_lpb.planner.fabrics.specs import SIGNS, Mapped, Spec
from pytest_lpb.planner.fabrics.speed import controlled
from pytest_lpb.problem.robot import Robot


class Composer:
    """Composes the fabric of a robot.

    Args:
        robot: any robot.
        goals: sub-goals, without their targets.
        capacities: slots per shape of obstacles; of meshes, meshes.
        parameters: of the planner.

    Attributes:
        state: its symbols.
        parts: parts of the robot that move and meet obstacles.
    """

    def __init__(
        self, robot: Robot, goals: Sequence[GoalInfo], capacities: Mapping[str, int], parameters: FabricsParameters
    ) -> None:
        self._parameters = parameters
        self._sign = SIGNS[parameters.curvature_term]
        self._goals = goals
        self._capacities = capacities
        self.state = State(robot)
        self.parts = [part for part in parts_of(robot, parameters) if self._moves(part)]

    def _moves(self, part: Part) -> bool:
        return bool(casadi.depends_on(part.place(self.state.frames), self.state.q))

    def function(self) -> Any:
        """The composed function: q, w, goals and obstacles (slot by slot) to the acceleration of the inputs."""
        targets = [casadi.SX.sym(f"goal{place}", goal.size, 3) for place, goal in enumerate(self._goals)]
        obstacles = {shape: self._symbols(shape, count) for shape, count in self._capacities.items()}
        geometry = self.geometry(obstacles)
        forced, target_velocity, distance = self._forced(geometry, targets)
        acceleration = controlled(
            geometry, forced, self.state.inputs, target_velocity, distance, self._parameters
        )
        names = ["q", "w", *(f"goal{place}" for place in range(len(targets))), *(f"obstacles_{s}" for s in obstacles)]
        action = casadi.densify(acceleration.action)
        return casadi.Function(
            "fabric",
            [self.state.q, self.state.inputs, *targets, *obstacles.values()],
            [self._within_limits(action)],
            names,
            ["action"],
            {"cse": True},
        )

    def points(self) -> Any:
        """Function of q to the centres of all balls, (d, balls): what nearest points of meshes are asked for."""
        places = casadi.horzcat(*(ball.place(self.state.frames) for ball in self.balls))
        return casadi.Function("points", [self.state.q], [casadi.densify(places)], ["q"], ["points"], {"cse": True})

    def _symbols(self, shape: str, count: int) -> Any:
        slots = count * len(self.balls) if shape == MESH else count
        return casadi.SX.sym(f"obstacles_{shape}", Slot(shape, self.state.robot.dimension).length, slots)

    @cached_property
    def balls(self) -> list[Ball]:
        """Balls that hold the parts, for obstacles whose distance to a part is not known in closed form."""
        return [ball for part in self.parts for ball in part.balls(self._parameters.sphere_excess)]

    def geometry(self, obstacles: Mapping[str, Any]) -> Spec:
        """Sum of all geometries over the inputs: base, position limits, obstacles, planes, the robot's own bodies."""
        total = self._base()
        for mapped, spec in (
            *self._limits(),
            *self._obstacles(obstacles),
            *self._planes(),
            *self._own_bodies(),
        ):
            total += spec.pulled_back(mapped, self._sign)
        return total

    def _base(self) -> Spec:
        """Every input's own energy, without a geometry."""
        leaf = _leaf(self._parameters.base_energy, "none", self._parameters)
        inputs = self.state.inputs
        specs = [leaf.spec(casadi.SX.zeros(1, 1), inputs[i]) for i in range(self.state.size)]
        forces = casadi.vertcat(*(spec.force for spec in specs))
        energy_forces = casadi.vertcat(*(spec.energy_force for spec in specs))
        return Spec(casadi.diag(casadi.vertcat(*(spec.metric for spec in specs))), forces, energy_forces)

    def _limits(self) -> Iterator[tuple[Mapped, Spec]]:
        """Distances of the joints to their limits."""
        parameters = self._parameters
        leaf = _leaf(parameters.limit_energy, parameters.limit_geometry, parameters)
        for joint, (lower, upper) in enumerate(self.state.robot.limits.position.tolist()):
            q = self.state.q[joint]
            for value in ([q - lower] if isfinite(lower) else []) + ([upper - q] if isfinite(upper) else []):
                mapped = self.state.mapped(value)
                yield mapped, leaf.spec(mapped.value, mapped.velocity)

    def _obstacles(self, obstacles: Mapping[str, Any]) -> Iterator[tuple[Mapped, Spec]]:
        """Of each part, its leaves to all obstacles, summed in the part's space."""
        by_part: dict[Part, list[tuple[str, Any]]] = {}
        for shape, symbols in obstacles.items():
            slots = casadi.horzsplit(symbols)
            exact = [part for part in self.parts if shape in part.exact]
            round_ = [ball for part in self.parts if shape not in part.exact for ball in part.balls(self._parameters.sphere_excess)]
            for part in exact + round_:
                by_part.setdefault(part, [])
                if shape == MESH:
                    place = self.balls.index(part)
                    by_part[part] += [(shape, column) for column in slots[place :: len(self.balls)]]
                else:
                    by_part[part] += [(shape, column) for column in slots]
        for part, mapped in zip(by_part, self._places(list(by_part)), strict=True):
            total = Spec.nothing(mapped.value.numel())
            functions: dict[str, Any] = {}
            for shape, column in by_part[part]:
                if shape not in functions:
                    functions[shape] = self._to_obstacle(part, mapped.value.numel(), shape)
                total += Spec(*functions[shape](mapped.value, mapped.velocity, column))
            yield mapped, total

    def _places(self, parts: Sequence[Part]) -> Iterator[Mapped]:
        """Places of parts, differentiated together: what they share is composed once."""
        places = [part.place(self.state.frames) for part in parts]
        if not places:
            return
        mapped = self.state.mapped(casadi.vertcat(*places))
        start = 0
        for place in places:
            yield mapped.rows(slice(start, start + place.numel()))
            start += place.numel()

    def _to_obstacle(self, part: Part, size: int, shape: str) -> Any:
        """Function of a part's place, its velocity and an obstacle's numbers to the spec in the part's space."""
        parameters = self._parameters
        slot = Slot(shape, self.state.robot.dimension)
        place, velocity = casadi.SX.sym("place", size), casadi.SX.sym("velocity", size)
        numbers = casadi.SX.sym("obstacle", slot.length)
        obstacle = slot.symbols(numbers)
        x = part.distance(place, obstacle)
        if parameters.distance == "relative":
            inscribed = 0.0 if shape == MESH else SHAPES[shape].inscribed(obstacle.size)
            x /= part.radius + inscribed
        rate = casadi.SX(slot.length, 1)
        change = casadi.SX(slot.length, 1)
        if parameters.obstacle_motion:
            rate[slot.of_time(0)] = numbers[slot.of_time(1)]
            change[slot.of_time(0)] = numbers[slot.of_time(2)]
        mapped = derivatives(x, (place, velocity), Reference(numbers, rate, change))
        leaf = _leaf(parameters.obstacle_energy, parameters.obstacle_geometry, parameters)
        spec = leaf.spec(mapped.value, mapped.velocity, numbers[slot.present]).pulled_back(mapped, self._sign)
        return casadi.Function(
            "to_obstacle",
            [place, velocity, numbers],
            [casadi.densify(x) for x in (spec.metric, spec.force, spec.energy_force)],
            {"cse": True},
        )

    def _planes(self) -> Iterator[tuple[Mapped, Spec]]:
        """Distances of balls to planes [m]."""
        parameters = self._parameters
        leaf = _leaf(parameters.plane_energy, parameters.plane_geometry, parameters)
        for *normal, offset in parameters.planes:
            outward = np.array(normal) / np.linalg.norm(normal)
            for ball in self.balls:
                height = casadi.dot(casadi.DM(outward), ball.place(self.state.frames))
                mapped = self.state.mapped(height - offset - ball.radius)
                yield mapped, leaf.spec(mapped.value, mapped.velocity)

    def _own_bodies(self) -> Iterator[tuple[Mapped, Spec]]:
        """Distances between the robot's own bodies, per sum of radii."""
        parameters = self._parameters
        if parameters.self_collision_geometry in ("none", "0"):
            return
        leaf = _leaf(parameters.self_collision_energy, parameters.self_collision_geometry, parameters)
        pairs = pairs_of(self.state.robot, parameters.self_collision_reach)
        places = self._places([part for pair in pairs for part in pair])
        for (first, second), one, other in zip(pairs, places, places, strict=True):
            yield self._own_pair(first, second, one, other, leaf)

    def _own_pair(
        self, first: Part, second: Part, one: Mapped, other: Mapped, leaf: ScalarLeaf
    ) -> tuple[Mapped, Spec]:
        sizes = one.value.numel(), other.value.numel()
        place, velocity = casadi.SX.sym("place", sum(sizes)), casadi.SX.sym("velocity", sum(sizes))
        distance = distance_between(first, second, (place[: sizes[0]], place[sizes[0] :]))
        x = distance / (first.radius + second.radius)
        inner = derivatives(x, (place, velocity), Reference.none())
        function = casadi.Function(
            "pair",
            [place, velocity],
            [casadi.densify(value) for value in (inner.value, inner.velocity, inner.jacobian, inner.curvature)],
            {"cse": True},
        )
        value, rate, gradient, curvature = function(
            casadi.vertcat(one.value, other.value), casadi.vertcat(one.velocity, other.velocity)
        )
        jacobian = gradient @ casadi.vertcat(one.jacobian, other.jacobian)
        curved = curvature + gradient @ casadi.vertcat(one.curvature, other.curvature)
        return Mapped(value, rate, jacobian, curved, casadi.SX(1, 1)), leaf.spec(value, rate)

    def _forced(self, geometry: Spec, targets: Sequence[Any]) -> tuple[Spec, Any, Any]:
        """The geometries with the attractors, the inputs' velocity that follows the targets, the distance left."""
        parameters = self._parameters
        attractor = Attractor(
            NAMED.get(parameters.attractor_energy, parameters.attractor_energy),
            NAMED.get(parameters.attractor_potential, parameters.attractor_potential),
        )
        total, follow, distances = geometry, casadi.SX.zeros(self.state.size, 1), []
        needed = [goal.tolerance is not None for goal in self._goals]
        for goal, target, counts in zip(self._goals, targets, needed, strict=True):
            reference = Reference(target[:, 0], target[:, 1], target[:, 2])
            error = ERRORS[self.state.robot.dimension, goal.type](self.state, goal, reference.value, parameters.lookahead)
            mapped = self.state.mapped(error, reference)
            spec = attractor.spec(mapped, goal.weight)
            total += spec.pulled_back(mapped, self._sign)
            rate = casadi.jtimes(error, reference.value, reference.velocity)
            follow -= mapped.jacobian.T @ (spec.metric @ rate)
            if counts or not any(needed):
                distances.append(error)
        return total, follow, length(casadi.vertcat(*distances))

    def _within_limits(self, action: Any) -> Any:
        """The action, shortened to the acceleration limits where it is to respect them."""
        if not self._parameters.respect_limits:
            return action
        ratios = [casadi.SX(1.0)]
        for entry, (lower, upper) in enumerate(self.state.robot.limits.acceleration.tolist()):
            ratios += [action[entry] / limit for limit in (lower, upper) if isfinite(limit) and limit]
        return action / casadi.mmax(casadi.vertcat(*ratios))


def _leaf(energy: str, geometry: str, parameters: FabricsParameters) -> ScalarLeaf:
    return ScalarLeaf(NAMED.get(energy, energy), NAMED.get(geometry, geometry), parameters.closest)
