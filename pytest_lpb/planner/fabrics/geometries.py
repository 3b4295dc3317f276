"""The geometries of a fabric: what bends its motion. Each is a map to a task space and a spec over it.

Every leaf is pulled back analytically from places, Jacobians and curvature terms that are composed once per part; what
lies between a part and obstacles is summed over obstacles in the part's own space first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import isfinite
from typing import Any

import casadi
import numpy as np

from pytest_lpb.motion.directions import LONGEST, SHORTEST
from pytest_lpb.planner.fabrics.brake import Damping
from pytest_lpb.planner.fabrics.leaves import ScalarLeaf
from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.fabrics.specs import SIGNS, Spec
from pytest_lpb.planner.scene.layout import Slot
from pytest_lpb.planner.scene.maps import Mapped, State, derivatives
from pytest_lpb.planner.scene.parts import Ball, Part, ends_of
from pytest_lpb.planner.scene.robot_parts import parts_of
from pytest_lpb.planner.scene.segments import segment_derivatives
from pytest_lpb.planner.scene.self_collision import pairs_of
from pytest_lpb.planner.scene.shapes import MESH, SHAPES


@dataclass(frozen=True)
class Leaf:
    """A map to a task space and the spec there; of one coordinate its unit [m or rad]."""

    mapped: Mapped
    spec: Spec
    unit: Any = 1.0


class Geometries:
    """All geometries of a robot, symbolic.

    Args:
        state: the robot's state.
        parameters: of the planner.

    Attributes:
        parts: parts of the robot that move and meet obstacles.
    """

    def __init__(self, state: State, parameters: FabricsParameters) -> None:
        self._state = state
        self._parameters = parameters
        self._sign = SIGNS[parameters.curvature_term]
        exact = parameters.links == "exact"
        parts = parts_of(state.robot, parameters, exact=exact, lookahead=parameters.lookahead)
        self.parts = [part for part in parts if self._moves(part)]

    def _moves(self, part: Part) -> bool:
        return bool(casadi.depends_on(part.place(self._state.frames), self._state.q))

    @cached_property
    def balls(self) -> list[Ball]:
        """Balls that hold the parts, for obstacles whose distance to a part is not known in closed form."""
        return [ball for part in self.parts for ball in part.balls(self._parameters.sphere_excess)]

    def obstacle_symbols(self, shape: str, capacity: int) -> Any:
        """Symbols of the numbers of obstacles, a column per slot; of meshes a column per mesh and ball."""
        slots = capacity * len(self.balls) if shape == MESH else capacity
        return casadi.SX.sym(f"obstacles_{shape}", Slot(shape, self._state.robot.dimension).length, slots)

    def total(self, obstacles: Mapping[str, Any]) -> Spec:
        """The sum of all geometries over the inputs; `obstacles` are the symbols by shape."""
        total = self._base()
        for leaf in (*self._of_one, *self._obstacles(obstacles)):
            total += leaf.spec.pulled_back(leaf.mapped, self._sign)
        return total

    @cached_property
    def _of_one(self) -> list[Leaf]:
        """Leaves of one coordinate that the state alone decides."""
        return [*self._limits(), *self._planes(), *self._own_bodies()]

    def damping(self, obstacles: Mapping[str, Any], wanted: Any) -> Damping:
        """The brake's dampers along all distances, where the inputs (n, 1) are wanted to be `wanted`."""
        total = Damping.nothing(self._state.size)
        parameters = self._parameters
        for leaf in self._of_one:
            mapped = leaf.mapped
            left = mapped.value - parameters.margin / leaf.unit
            rate = mapped.jacobian @ wanted
            total += Damping.along(left, mapped.jacobian, rate, 0.0, _mobility(mapped), parameters.brake)
        for part, mapped, slots in self._meetings(obstacles):
            there = Damping.nothing(mapped.value.numel())
            functions = {shape: self._damping_to(part, mapped.value.numel(), shape) for shape in slots}
            arguments = mapped.value, mapped.jacobian @ wanted, _mobility(mapped)
            for shape, columns in slots.items():
                for column in columns:
                    there += Damping(*functions[shape](*arguments, column))
            total += there.pulled_back(mapped.jacobian)
        return total

    def _leaf(self, energy: str, geometry: str) -> ScalarLeaf:
        return ScalarLeaf(energy, geometry, self._parameters.closest)

    def _base(self) -> Spec:
        """Every input's own energy, without a geometry."""
        leaf = self._leaf(self._parameters.base_energy, "0")
        nowhere = casadi.SX.zeros(1, 1)
        specs = [leaf.spec(nowhere, speed) for speed in casadi.vertsplit(self._state.inputs)]
        return Spec(
            casadi.diag(casadi.vertcat(*(spec.metric for spec in specs))),
            casadi.vertcat(*(spec.force for spec in specs)),
            casadi.vertcat(*(spec.energy_force for spec in specs)),
        )

    def _limits(self) -> Iterator[Leaf]:
        """Distances of the joints to their limits."""
        leaf = self._leaf(self._parameters.limit_energy, self._parameters.limit_geometry)
        limits = self._state.robot.limits.position.tolist()
        for q, (lower, upper) in zip(casadi.vertsplit(self._state.q), limits, strict=True):
            for value, limit in ((q - lower, lower), (upper - q, upper)):
                if isfinite(limit):
                    mapped = self._state.mapped(value)
                    yield Leaf(mapped, leaf.spec(mapped.value, mapped.velocity))

    def _planes(self) -> Iterator[Leaf]:
        """Distances of balls to planes [m]."""
        leaf = self._leaf(self._parameters.plane_energy, self._parameters.plane_geometry)
        for plane in self._parameters.planes:
            *normal, offset = plane
            length = float(np.linalg.norm(normal))
            if not SHORTEST < length < LONGEST:
                largest = max(map(abs, normal))
                *normal, offset = (number / largest for number in plane)
                length = float(np.linalg.norm(normal))
            outward = casadi.DM(np.array(normal) / length)
            for ball in self.balls:
                height = casadi.dot(outward, ball.place(self._state.frames))
                mapped = self._state.mapped(height - offset / length - ball.radius)
                yield Leaf(mapped, leaf.spec(mapped.value, mapped.velocity))

    def _places(self, parts: Sequence[Part]) -> list[Mapped]:
        """Places of parts, differentiated together: what they share is composed once."""
        places = [part.place(self._state.frames) for part in parts]
        if not places:
            return []
        mapped = self._state.mapped(casadi.vertcat(*places))
        ends = [0, *np.cumsum([place.numel() for place in places]).tolist()]
        return [mapped.rows(slice(start, end)) for start, end in pairwise(ends)]

    def _obstacles(self, obstacles: Mapping[str, Any]) -> Iterator[Leaf]:
        """Of each part, its leaves to all obstacles, summed in the part's space."""
        for part, mapped, slots in self._meetings(obstacles):
            total = Spec.nothing(mapped.value.numel())
            for shape, columns in slots.items():
                spec_of = self._to_obstacle(part, mapped.value.numel(), shape)
                for column in columns:
                    total += Spec(*spec_of(mapped.value, mapped.velocity, column))
            yield Leaf(mapped, total)

    def _meetings(self, obstacles: Mapping[str, Any]) -> Iterator[tuple[Part, Mapped, dict[str, list[Any]]]]:
        """Parts with the maps to their places, and the symbols of the obstacles that each meets, by shape."""
        columns: dict[Part, dict[str, list[Any]]] = {}
        for shape, symbols in obstacles.items():
            slots = casadi.horzsplit(symbols)
            if shape == MESH:
                for place, ball in enumerate(self.balls):
                    columns.setdefault(ball, {})[shape] = slots[place :: len(self.balls)]
                continue
            for part in self._meeting(shape):
                columns.setdefault(part, {})[shape] = slots
        for part, mapped in zip(columns, self._places(list(columns)), strict=True):
            yield part, mapped, columns[part]

    def _meeting(self, shape: str) -> Iterator[Part]:
        """The parts as they are where their distance to a shape is known, else balls that hold them."""
        for part in self.parts:
            if shape in part.exact:
                yield part
            else:
                yield from part.balls(self._parameters.sphere_excess)

    def _to_obstacle(self, part: Part, size: int, shape: str) -> Any:
        """Function of a part's place, its velocity and an obstacle's numbers to the spec in the part's space."""
        parameters = self._parameters
        near = _Near(part, size, Slot(shape, self._state.robot.dimension), parameters)
        mapped = derivatives(near.distance, (near.offset, near.rate))
        mapped = replace(mapped, drift=-mapped.jacobian @ near.acceleration)
        leaf = self._leaf(parameters.obstacle_energy, parameters.obstacle_geometry)
        spec = leaf.spec(mapped.value, mapped.velocity, near.present).pulled_back(mapped, self._sign)
        return near.function([spec.metric, spec.force, spec.energy_force])

    def _damping_to(self, part: Part, size: int, shape: str) -> Any:
        """Function of a part's place, the velocity wanted of it, its mobility and an obstacle's numbers to a damper."""
        near = _Near(part, size, Slot(shape, self._state.robot.dimension), self._parameters)
        mobility = casadi.SX.sym("mobility", size, size)
        gradient = casadi.jacobian(near.distance, near.offset)
        own, along = -gradient @ near.velocity, gradient @ mobility @ gradient.T
        left = near.distance - self._parameters.margin / near.unit
        damping = Damping.along(left, gradient, gradient @ near.rate, own, along, self._parameters.brake)
        parts = (damping.matrix, damping.push)
        return near.function([casadi.if_else(near.present, part, 0.0) for part in parts], mobility)

    def _own_bodies(self) -> Iterator[Leaf]:
        """Distances between the robot's own bodies, per sum of their radii."""
        parameters = self._parameters
        leaf = self._leaf(parameters.self_collision_energy, parameters.self_collision_geometry)
        pairs = [] if leaf.idle else pairs_of(self._state.robot, parameters)
        places = iter(self._places([part for pair in pairs for part in pair]))
        for (first, second), one, other in zip(pairs, places, places, strict=True):
            mapped = _between(first, second, one, other)
            yield Leaf(mapped, leaf.spec(mapped.value, mapped.velocity), first.radius + second.radius)


class _Near:
    """A part near an obstacle, symbolic: what depends on where it is from it, as dynamic fabrics have it.

    Attributes:
        offset, rate: place (k, 1) of the part from the obstacle, and its rate.
        distance: x of the barrier, in units of `unit` [m].
        velocity, acceleration: of the obstacle, as changes of the part's place (k, 1).
        present: 1, or 0 where the slot is empty.
    """

    def __init__(self, part: Part, size: int, slot: Slot, parameters: FabricsParameters) -> None:
        self._numbers = casadi.SX.sym("obstacle", slot.length)
        obstacle = slot.symbols(self._numbers)
        self.offset, self.rate = casadi.SX.sym("offset", size), casadi.SX.sym("rate", size)
        relative = parameters.distance == "relative"
        self.unit = part.radius + SHAPES[slot.shape].inscribed(obstacle.size) if relative else 1.0
        self.distance = part.distance(self.offset, obstacle) / self.unit
        position, velocity, acceleration = (part.shift(self._numbers[slot.of_time(order)]) for order in range(3))
        self._position = position
        self.velocity = velocity if parameters.obstacle_motion else casadi.SX(size, 1)
        self.acceleration = acceleration if parameters.obstacle_motion else casadi.SX(size, 1)
        self.present = self._numbers[slot.present]

    def function(self, results: list[Any], *further: Any) -> Any:
        """Function of the part's place, its velocity, further symbols and the obstacle's numbers."""
        place, velocity = casadi.SX.sym("place", self.offset.numel()), casadi.SX.sym("velocity", self.offset.numel())
        relative = [place - self._position, velocity - self.velocity]
        parts = casadi.substitute(results, [self.offset, self.rate], relative)
        arguments = [place, velocity, *further, self._numbers]
        return casadi.Function("near", arguments, [casadi.densify(part) for part in parts], {"cse": True})


def _mobility(mapped: Mapped) -> Any:
    """J J^T of a map: how much of a task space's velocity the inputs can change."""
    return mapped.jacobian @ mapped.jacobian.T


def _between(first: Part, second: Part, one: Mapped, other: Mapped) -> Mapped:
    """The map to the distance between two parts, per sum of their radii, of the maps to their places."""
    inner = segment_derivatives(
        ends_of(first, one.value),
        ends_of(second, other.value),
        ends_of(first, one.velocity),
        ends_of(second, other.velocity),
    )
    unit = first.radius + second.radius
    curvature = inner.curvature + inner.jacobian @ casadi.vertcat(one.curvature, other.curvature)
    return Mapped(
        inner.value / unit - 1.0,
        inner.velocity / unit,
        inner.jacobian @ casadi.vertcat(one.jacobian, other.jacobian) / unit,
        curvature / unit,
        inner.drift,
    )
