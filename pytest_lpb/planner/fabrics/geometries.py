"""The geometries of a fabric: what bends its motion. Each is a map to a task space and a spec over it.

Every leaf is pulled back analytically from places, Jacobians and curvature terms that are composed once per part; what
lies between a part and obstacles is summed over obstacles in the part's own space first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from math import isfinite
from typing import Any

import casadi
import numpy as np

from pytest_lpb.planner.fabrics.layout import Slot
from pytest_lpb.planner.fabrics.leaves import Foresight, ScalarLeaf
from pytest_lpb.planner.fabrics.maps import State, derivatives
from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.fabrics.parts import Ball, Part, distance_between
from pytest_lpb.planner.fabrics.robot_parts import parts_of
from pytest_lpb.planner.fabrics.self_collision import pairs_of
from pytest_lpb.planner.fabrics.shapes import MESH, SHAPES
from pytest_lpb.planner.fabrics.specs import SIGNS, Mapped, Spec

Leaf = tuple[Mapped, Spec]  # a map to a task space, and the spec there


class Geometries:
    """All geometries of a robot, symbolic.

    Args:
        state: the robot's state.
        parameters: of the planner.
        step: [s] of an implicit step; 0: explicit.

    Attributes:
        parts: parts of the robot that move and meet obstacles.
    """

    def __init__(self, state: State, parameters: FabricsParameters, step: float) -> None:
        self._state = state
        self._foresight = Foresight(step, parameters.braking, parameters.closest)
        self._parameters = parameters
        self._sign = SIGNS[parameters.curvature_term]
        self.parts = [part for part in parts_of(state.robot, parameters) if self._moves(part)]

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
        for leaves in (self._limits(), self._obstacles(obstacles), self._planes(), self._own_bodies()):
            for mapped, spec in leaves:
                total += spec.pulled_back(mapped, self._sign)
        return total

    def _leaf(self, energy: str, geometry: str) -> ScalarLeaf:
        return ScalarLeaf(energy, geometry, self._foresight)

    def _base(self) -> Spec:
        """Every input's own energy, without a geometry."""
        leaf = self._leaf(self._parameters.base_energy, "0")
        nowhere = casadi.SX.zeros(1, 1)
        specs = [leaf.spec(nowhere, speed) for speed in casadi.vertsplit(self._state.inputs)]
        return Spec(
            casadi.diag(casadi.vertcat(*(spec.metric for spec in specs))),
            casadi.vertcat(*(spec.force for spec in specs)),
            casadi.vertcat(*(spec.energy_force for spec in specs)),
            casadi.SX(len(specs), len(specs)),
        )

    def _limits(self) -> Iterator[Leaf]:
        """Distances of the joints to their limits."""
        leaf = self._leaf(self._parameters.limit_energy, self._parameters.limit_geometry)
        limits = self._state.robot.limits.position.tolist()
        for q, (lower, upper) in zip(casadi.vertsplit(self._state.q), limits, strict=True):
            for value, limit in ((q - lower, lower), (upper - q, upper)):
                if isfinite(limit):
                    mapped = self._state.mapped(value)
                    yield mapped, leaf.spec(mapped.value, mapped.velocity)

    def _planes(self) -> Iterator[Leaf]:
        """Distances of balls to planes [m]."""
        leaf = self._leaf(self._parameters.plane_energy, self._parameters.plane_geometry)
        for *normal, offset in self._parameters.planes:
            outward = casadi.DM(np.array(normal) / np.linalg.norm(normal))
            for ball in self.balls:
                height = casadi.dot(outward, ball.place(self._state.frames))
                mapped = self._state.mapped(height - offset - ball.radius)
                yield mapped, leaf.spec(mapped.value, mapped.velocity)

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
            total = Spec.nothing(mapped.value.numel())
            for shape, slots in columns[part].items():
                spec_of = self._to_obstacle(part, mapped.value.numel(), shape)
                for column in slots:
                    total += Spec(*spec_of(mapped.value, mapped.velocity, column))
            yield mapped, total

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
        slot = Slot(shape, self._state.robot.dimension)
        numbers = casadi.SX.sym("obstacle", slot.length)
        # Distances depend on where the part is from the obstacle: relative coordinates, as dynamic fabrics have them.
        offset, rate = casadi.SX.sym("offset", size), casadi.SX.sym("rate", size)
        obstacle = slot.symbols(numbers)
        unit = part.radius + SHAPES[shape].inscribed(obstacle.size) if parameters.distance == "relative" else 1.0
        mapped = derivatives(part.distance(offset, obstacle) / unit, (offset, rate))
        moving = casadi.SX.zeros(slot.dimension, 1)
        if parameters.obstacle_motion:
            moving = numbers[slot.of_time(1)]
            mapped = replace(mapped, drift=-mapped.jacobian @ part.shift(numbers[slot.of_time(2)]))
        leaf = self._leaf(parameters.obstacle_energy, parameters.obstacle_geometry)
        spec = leaf.spec(mapped.value, mapped.velocity, unit, numbers[slot.present]).pulled_back(mapped, self._sign)
        place, velocity = casadi.SX.sym("place", size), casadi.SX.sym("velocity", size)
        relative = [place - part.shift(numbers[slot.of_time(0)]), velocity - part.shift(moving)]
        parts = casadi.substitute([spec.metric, spec.force, spec.energy_force, spec.damping], [offset, rate], relative)
        return casadi.Function(
            "to_obstacle", [place, velocity, numbers], [casadi.densify(each) for each in parts], {"cse": True}
        )

    def _own_bodies(self) -> Iterator[Leaf]:
        """Distances between the robot's own bodies, per sum of their radii."""
        parameters = self._parameters
        leaf = self._leaf(parameters.self_collision_energy, parameters.self_collision_geometry)
        pairs = [] if leaf.idle else pairs_of(self._state.robot, parameters.self_collision_reach)
        places = iter(self._places([part for pair in pairs for part in pair]))
        for (first, second), one, other in zip(pairs, places, places, strict=True):
            mapped = _between(first, second, one, other)
            yield mapped, leaf.spec(mapped.value, mapped.velocity, first.radius + second.radius)


def _between(first: Part, second: Part, one: Mapped, other: Mapped) -> Mapped:
    """The map to the distance between two parts, of the maps to their places."""
    sizes = one.value.numel(), other.value.numel()
    place, velocity = casadi.SX.sym("place", sum(sizes)), casadi.SX.sym("velocity", sum(sizes))
    x = distance_between(first, second, casadi.vertsplit(place, [0, sizes[0], sum(sizes)]))
    inner = derivatives(x / (first.radius + second.radius), (place, velocity))
    parts = [casadi.densify(each) for each in (inner.value, inner.velocity, inner.jacobian, inner.curvature)]
    function = casadi.Function("between", [place, velocity], parts, {"cse": True})
    value, rate, gradient, curvature = function(
        casadi.vertcat(one.value, other.value), casadi.vertcat(one.velocity, other.velocity)
    )
    jacobian = gradient @ casadi.vertcat(one.jacobian, other.jacobian)
    return Mapped(
        value,
        rate,
        jacobian,
        curvature + gradient @ casadi.vertcat(one.curvature, other.curvature),
        casadi.SX.zeros(1, 1),
    )
