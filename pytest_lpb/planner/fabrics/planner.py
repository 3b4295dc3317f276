"""Optimization fabrics as a planner; docs/fabrics.md has the equations and what each parameter does."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, ClassVar

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.actuation import actuation_of
from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.planner.fabrics.composition import Composer
from pytest_lpb.planner.fabrics.observed import goal_fills, obstacle_fills
from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.known import check_shapes
from pytest_lpb.planner.scene.fills import Fill
from pytest_lpb.planner.scene.meshes import MeshFill
from pytest_lpb.planner.scene.shapes import MESH
from pytest_lpb.planner.scene.structure import Structure
from pytest_lpb.planner.task import SUPPORTED, check_control
from pytest_lpb.symbolic.buffered import BufferedFunction
from pytest_lpb.symbolic.compiled import compiled

CACHED = 64  # composed fabrics that are kept


class Fabrics(Planner):
    """Dynamic optimization fabrics (Spahn, Wisse and Alonso-Mora, arXiv:2205.08454).

    Geometries of obstacles, limits and the robot's own bodies bend its path; attractors force it to the goal; a speed
    control keeps what is left stable. The fabric is composed once per robot, goal structure and room for obstacles.
    """

    name: ClassVar[str] = "fabrics"
    supports: ClassVar[Mapping[str, tuple[str, ...]]] = SUPPORTED
    Parameters = FabricsParameters

    parameters: FabricsParameters

    def setup(self, problem: PlannerProblem) -> None:
        """Compose the fabric, or take the composed one of an equal structure."""
        check_control(self.name, problem)
        check_shapes(self.name, problem)
        _check_planes(problem, self.parameters)
        _check_shortening(problem, self.parameters)
        composed = _composed_for(problem, self.parameters)
        self._fabric = BufferedFunction(composed.function)
        arguments = self._fabric.arguments
        self._q, self._inputs = arguments["q"], arguments["w"]
        self._action = self._fabric.results["action"]
        self._actuation = actuation_of(problem.robot, problem.control, problem.period, self.parameters.lookahead)
        self._fills: list[Fill] = goal_fills(problem.goal, arguments)
        self._fills += obstacle_fills(problem.obstacles, arguments, problem.dimension)
        if composed.points is not None:
            meshes = MeshFill(problem.obstacles, composed.points, arguments[f"obstacles_{MESH}"])
            self._fills.append(_mesh_fill(meshes))
        # Under velocity control the action is the velocity after one period.
        self._step = problem.period if problem.control == "velocity" else None

    def compute_action(self, observation: Observation) -> FloatArray:
        """The acceleration of u that the fabric asks for, or u after one period of it under velocity control."""
        self._q[:] = observation["q"]
        inputs = self._actuation.inputs(observation)
        self._inputs[:] = inputs
        for fill in self._fills:
            fill(observation)
        self._fabric.evaluate()
        action = self._action.copy() if self._step is None else inputs + self._step * self._action
        return self._actuation.command(action, observation)


def _check_planes(problem: PlannerProblem, parameters: FabricsParameters) -> None:
    """Raise ConfigurationError for planes of another dimension."""
    for plane in parameters.planes:
        if len(plane) != problem.dimension + 1:
            raise ConfigurationError(
                f"planes: found {list(plane)}; in {problem.dimension} dimensions a plane has "
                f"{problem.dimension} numbers of its normal and an offset"
            )


def _check_shortening(problem: PlannerProblem, parameters: FabricsParameters) -> None:
    """Raise ConfigurationError for bounds of actions that the planner's inputs are not."""
    if problem.robot.base == "bicycle" and (parameters.respect_limits or parameters.largest_acceleration):
        raise ConfigurationError(
            "respect_limits and largest_acceleration: a bicycle is planned for as a cart, "
            "whose inputs are not its actions; leave them out for it"
        )


@dataclasses.dataclass(frozen=True, eq=False)
class Composed:
    """A composed fabric; `points` gives the balls' centres where meshes ask for them."""

    function: Any
    points: Any


def _composed_for(problem: PlannerProblem, parameters: FabricsParameters) -> Composed:
    # Where nothing moves, what is composed for obstacles that stand does the same with fewer operations.
    moving = parameters.obstacle_motion and any(obstacle.moving for obstacle in problem.obstacles)
    period = problem.period if parameters.brake else 0.0
    return _composed(Structure(problem, dataclasses.replace(parameters, obstacle_motion=moving), period))


@lru_cache(maxsize=CACHED)
def _composed(structure: Structure) -> Composed:
    problem, parameters = structure.problem, structure.parameters
    composer = Composer(problem.robot, problem.goal, structure.capacities, parameters, problem.period)
    function = composer.function()
    if parameters.compile:
        function = compiled(function)
    return Composed(function, composer.points() if MESH in structure.capacities else None)


def _mesh_fill(meshes: MeshFill) -> Fill:
    return lambda observation: meshes.fill(observation, observation["q"])
