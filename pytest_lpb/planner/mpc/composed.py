"""A composed horizon: what takes long to build, kept for problems of equal structure."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from pytest_lpb.planner.base import FloatArray, PlannerProblem
from pytest_lpb.planner.mpc.bounds import guard_of, planned_limits
from pytest_lpb.planner.mpc.converged import NonlinearProgram, compose
from pytest_lpb.planner.mpc.model import Model, lead_of
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.program import Sizes, Weights
from pytest_lpb.planner.mpc.stages import Stage
from pytest_lpb.planner.scene.shapes import MESH
from pytest_lpb.planner.scene.structure import Structure
from pytest_lpb.problem.robot import Limits
from pytest_lpb.symbolic.compiled import compiled

CACHED = 32  # composed horizons that are kept


@dataclass(frozen=True, eq=False)
class Composed:
    """A composed horizon.

    Attributes:
        sizes: of its programs.
        limits: as planned with.
        stage: `Stage.function()` at all steps.
        rollout, slopes: of the model; no slopes where they are the same everywhere.
        guard: as composed by `guard_of`.
        points: `Stage.points()` at all steps, where meshes ask for them.
        nonlinear: the program itself, where it is to be solved to convergence.
    """

    model: Model
    sizes: Sizes
    limits: Limits
    stage: Any
    rollout: Any
    slopes: Any
    guard: Any
    points: Any
    nonlinear: NonlinearProgram | None


def composed_for(problem: PlannerProblem, parameters: MpcParameters) -> Composed:
    """The horizon of a problem, composed or kept from another one of equal structure."""
    lead = lead_of(problem.robot, problem.dt, problem.period)
    return _composed(Structure(problem, parameters, [problem.period, lead.tolist()]))


@lru_cache(maxsize=CACHED)
def _composed(structure: Structure) -> Composed:
    problem, parameters = structure.problem, structure.parameters
    robot, steps = problem.robot, parameters.horizon
    model = Model(robot, parameters.step, lead_of(robot, problem.dt, problem.period))
    limits = planned_limits(robot.limits, model, parameters)
    stage = Stage(robot, problem.goal, structure.capacities, parameters)
    single = stage.function()
    horizon = single.map(steps)
    sizes = Sizes(steps, model.inputs, model.states, model.dof, single.size1_out("d"))
    return Composed(
        model,
        sizes,
        limits,
        compiled(horizon) if parameters.compile else horizon,
        model.rollout(steps),
        None if model.linear else model.slopes(steps),
        guard_of(model, limits, steps, problem.period),
        stage.points().map(steps) if MESH in structure.capacities else None,
        _nonlinear(parameters, stage, single, model, sizes),
    )


def _nonlinear(
    parameters: MpcParameters, stage: Stage, single: Any, model: Model, sizes: Sizes
) -> NonlinearProgram | None:
    if parameters.solver == "sqp":
        return None
    weights, goal_weights = weights_of(parameters), goal_weights_of(parameters)
    return compose(parameters.solver, single, stage.errors(), model, sizes, weights, goal_weights, parameters.tolerance)


def weights_of(parameters: MpcParameters) -> Weights:
    """Weights of all but the errors."""
    return Weights(
        parameters.velocity,
        parameters.velocity_end,
        parameters.input,
        parameters.input_change,
        parameters.slack,
        parameters.slack_squared,
    )


def goal_weights_of(parameters: MpcParameters) -> FloatArray:
    """Of the squared errors after each step, (N,)."""
    weights = np.full(parameters.horizon, parameters.goal)
    weights[-1] = parameters.goal_end
    return weights
