"""Model predictive control in real time; docs/mpc.md has the problem and what each parameter does.

Multiple shooting (Bock and Plitt, 1984) with real-time iterations (Diehl et al., "Real-time optimization and nonlinear
model predictive control of processes governed by differential-algebraic equations", J. Process Control 12, 2002).
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from math import inf
from typing import Any, ClassVar

import numpy as np

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.planner.mpc.converged import ConvergedSolver, NonlinearProgram, compose, guess_of
from pytest_lpb.planner.mpc.model import Model
from pytest_lpb.planner.mpc.observed import MeshFill, goal_fills, obstacle_fills
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.program import Program, Sizes, Weights
from pytest_lpb.planner.mpc.solver import PiqpSolver, Solution
from pytest_lpb.planner.mpc.stages import Stage
from pytest_lpb.planner.scene.fills import Fill
from pytest_lpb.planner.scene.shapes import MESH
from pytest_lpb.planner.scene.structure import Structure
from pytest_lpb.planner.task import check_control
from pytest_lpb.problem.preview import Preview
from pytest_lpb.symbolic.buffered import BufferedFunction
from pytest_lpb.symbolic.compiled import compiled

CACHED = 32  # composed horizons that are kept
ROUNDING = 1e-6  # relative
INSET = 2e-2  # [rad or m] by which plans stay within position limits: programs are solved to a tolerance
GIVE = 1e-6  # [rad, m, ..] by which bounds give way beyond what braking needs


class Mpc(Planner):
    """Plans over a horizon at each call, by one or two quadratic programs, and carries out the beginning."""

    name: ClassVar[str] = "mpc"
    Parameters = MpcParameters

    parameters: MpcParameters

    @classmethod
    def preview_for(cls, parameters: Any) -> Preview:
        """Where obstacles and goals will be after each step of the horizon."""
        return Preview(parameters.horizon, parameters.step)

    def setup(self, problem: PlannerProblem) -> None:
        """Compose the horizon, or take the composed one of an equal structure."""
        check_control(self.name, problem)
        _check_period(problem, self.parameters)
        _check_solver(self.parameters)
        parameters, robot = self.parameters, problem.robot
        composed = _composed(Structure(problem, parameters))
        steps = parameters.horizon
        self._stage = BufferedFunction(composed.stage)
        self._rollout = BufferedFunction(composed.rollout)
        self._slopes = None if composed.slopes is None else BufferedFunction(composed.slopes)
        self._model = composed.model
        model = composed.model
        rows = self._stage.results["d"].reshape(steps, -1).shape[1]
        self._sizes = Sizes(steps, model.inputs, model.states, model.dof, rows)
        self._program = Program(self._sizes)
        self._solver = PiqpSolver(self._program, parameters.tolerance)
        self._converged = None
        if composed.nonlinear is not None:
            self._converged = ConvergedSolver(composed.nonlinear, self._sizes)
        self._weights = _weights(parameters)
        arguments = self._stage.arguments
        self._fills: list[Fill] = goal_fills(problem.goal, arguments["goals"].reshape(steps, -1))
        self._fills += obstacle_fills(problem.obstacles, arguments, steps, problem.dimension)
        self._meshes: MeshFill | None = None
        if composed.points is not None:
            self._meshes = _mesh_fill(problem, composed.points, arguments, steps)
        self._limits = dataclasses.replace(
            robot.limits,
            acceleration=_within(robot.limits.acceleration, parameters.input_limit),
            velocity=_within(robot.limits.velocity, parameters.velocity_limit),
        )
        self._share = problem.period / parameters.step
        self._period = problem.period if problem.control == "velocity" else None
        self._plan: FloatArray = np.zeros((steps, model.inputs))
        self._last = np.zeros(model.inputs)
        self._first = True
        self._failed = inf  # so many calls ago there was a plan: before the first there is none
        self._goal_weights = _goal_weights(parameters)

    def compute_action(self, observation: Observation) -> FloatArray:
        """The first inputs of a new plan, or u after one period of them under velocity control."""
        state = np.concatenate([observation["q"], observation["u"]])
        self._seen = observation
        for fill in self._fills:
            fill(observation)
        parameters = self.parameters
        if not self._first:
            self._plan = _shifted(self._plan, self._share)
        iterations = parameters.first_iterations if self._first else parameters.iterations
        self._first = False
        solution = self._iterate(state) if self._converged is None else self._converge(state, self._converged)
        for _ in range(iterations - 1 if self._converged is None else 0):
            if solution.solved:
                solution = self._iterate(state)
        self._failed = 0.0 if solution.solved else self._failed + 1.0
        if self._failed * self._share > len(self._plan):
            # Nothing is left of the last plan that was one: to rest, as fast as the limits allow.
            u = state[self._sizes.dof :]
            self._plan = _braking(u, self._limits.acceleration, len(self._plan), parameters.step)
        self.diagnostics = {
            "solved": float(solution.solved),
            "iterations": float(solution.iterations),
            "residual": solution.residual,
        }
        lower, upper = self._limits.acceleration.T
        self._last = np.clip(self._plan[0], lower, upper)
        if self._period is None:
            return self._last.copy()
        return np.asarray(observation["u"] + self._period * self._last)

    def _converge(self, state: FloatArray, solver: ConvergedSolver) -> Solution:
        """The nonlinear program itself, started from the plan."""
        self._bound(state)
        path = self._path(state, self._plan)
        if self._meshes is not None:
            self._meshes.fill(self._seen, path[:, : self._sizes.dof])
        guess = guess_of(self._sizes, self._plan, path)
        program = self._program
        solution = solver.solve(state, self._last, self._stage.arguments, program.lower, program.upper, guess)
        if solution.solved:
            self._plan = solution.z[self._sizes.input_places]
        return solution

    def _iterate(self, state: FloatArray) -> Solution:
        """One quadratic program around the plan, which becomes its solution if there is one."""
        sizes = self._sizes
        path = self._path(state, self._plan)
        self._judge(path)
        self._move(state, path)
        self._bound(state)
        solution = self._solver.solve()
        if solution.solved:
            self._plan = solution.z[sizes.input_places]
        return solution

    def _path(self, state: FloatArray, plan: FloatArray) -> FloatArray:
        """States after each step of a plan, (N, m)."""
        rollout = self._rollout
        rollout.arguments["x"][:] = state
        rollout.arguments["a"][:] = plan.reshape(rollout.arguments["a"].shape)
        rollout.evaluate()
        return rollout.results["path"].reshape(self._sizes.steps, -1)

    def _judge(self, path: FloatArray) -> None:
        """Fill in the cost and the distances, around a path."""
        sizes, stage, parameters = self._sizes, self._stage, self.parameters
        q = path[:, : sizes.dof]
        stage.arguments["q"][:] = q.reshape(stage.arguments["q"].shape)
        if self._meshes is not None:
            self._meshes.fill(self._seen, q)
        stage.evaluate()
        results = stage.results
        weight = self._goal_weights
        hessians = results["H"].reshape(sizes.steps, sizes.dof, sizes.dof) * weight[:, None, None]
        hessians[:, np.arange(sizes.dof), np.arange(sizes.dof)] += parameters.proximal
        gradients = results["g"].reshape(sizes.steps, sizes.dof) * weight[:, None] - parameters.proximal * q
        self._program.cost(hessians, gradients, self._weights, self._last)
        if sizes.rows:
            # CasADi stores columns first.
            slopes = results["J"].reshape(sizes.steps, sizes.dof, sizes.rows).transpose(0, 2, 1)
            distances = results["d"].reshape(sizes.steps, sizes.rows)
            self._program.distances(slopes, (slopes @ q[:, :, None])[:, :, 0] - distances)

    def _move(self, state: FloatArray, path: FloatArray) -> None:
        """Fill in the motion, linear around a path."""
        sizes, model = self._sizes, self._model
        before = np.vstack([state, path[:-1]])
        if self._slopes is None:
            by_state = np.broadcast_to(model.by_state, (sizes.steps, sizes.states, sizes.states))
            by_input = np.broadcast_to(model.by_input, (sizes.steps, sizes.states, sizes.inputs))
        else:
            slopes = self._slopes
            slopes.arguments["x"][:] = before.reshape(slopes.arguments["x"].shape)
            slopes.arguments["a"][:] = self._plan.reshape(slopes.arguments["a"].shape)
            slopes.evaluate()
            by_state = slopes.results["A"].reshape(sizes.steps, sizes.states, sizes.states).transpose(0, 2, 1)
            by_input = slopes.results["B"].reshape(sizes.steps, sizes.inputs, sizes.states).transpose(0, 2, 1)
        offsets = path - (by_input @ self._plan[:, :, None])[:, :, 0]
        offsets[1:] -= (by_state[1:] @ before[1:, :, None])[:, :, 0]
        self._program.motion(by_state[1:], by_input, offsets)

    def _bound(self, state: FloatArray) -> None:
        """Fill in the bounds; those of states give way where braking cannot keep them."""
        sizes, limits, program = self._sizes, self._limits, self._program
        program.lower[sizes.input_places], program.upper[sizes.input_places] = limits.acceleration.T
        program.lower[sizes.slack_places] = 0.0
        braking = _braking(state[sizes.dof :], limits.acceleration, sizes.steps, self.parameters.step)
        held = self._path(state, braking)
        lower = np.concatenate([limits.position[:, 0] + INSET, limits.velocity[:, 0]])
        upper = np.concatenate([limits.position[:, 1] - INSET, limits.velocity[:, 1]])
        program.lower[sizes.state_places] = np.minimum(lower, held) - GIVE
        program.upper[sizes.state_places] = np.maximum(upper, held) + GIVE


def _check_period(problem: PlannerProblem, parameters: MpcParameters) -> None:
    """Raise ConfigurationError for a period that is longer than a step: inputs are held for a period."""
    if problem.period > parameters.step * (1.0 + ROUNDING):
        raise ConfigurationError(
            f"step: found {parameters.step:g} s; a step of the plan must last at least a period, {problem.period:g} s"
        )


def _check_solver(parameters: MpcParameters) -> None:
    """Raise ConfigurationError for rows that are picked, which solvers that converge cannot take."""
    if parameters.solver != "sqp" and (parameters.nearest or parameters.own_nearest):
        raise ConfigurationError(
            f"solver: {parameters.solver} needs distances that are smooth: "
            f"nearest: 0 and own_nearest: 0, found {parameters.nearest} and {parameters.own_nearest}"
        )


def _within(limits: FloatArray, bound: float | None) -> FloatArray:
    """Limits (n, 2), no farther from 0 than a bound."""
    return limits if bound is None else np.clip(limits, -bound, bound)


def _shifted(plan: FloatArray, share: float) -> FloatArray:
    """A plan a share of a step later."""
    later = np.vstack([plan[1:], np.zeros((1, plan.shape[1]))])
    shifted: FloatArray = (1.0 - share) * plan + share * later
    return shifted


def _braking(velocity: FloatArray, limits: FloatArray, steps: int, step: float) -> FloatArray:
    """Inputs that bring velocities (n,) to rest as fast as limits (n, 2) allow, (steps, n)."""
    inputs = np.empty((steps, len(velocity)))
    left = velocity.copy()
    for row in inputs:
        row[:] = np.clip(-left / step, limits[:, 0], limits[:, 1])
        left += step * row
    return inputs


@dataclasses.dataclass(frozen=True, eq=False)
class Composed:
    """A composed horizon."""

    model: Model
    stage: Any
    rollout: Any
    slopes: Any
    points: Any  # centres of the balls at each step, where meshes ask for them
    nonlinear: NonlinearProgram | None  # where it is to be solved to convergence


@lru_cache(maxsize=CACHED)
def _composed(structure: Structure) -> Composed:
    problem, parameters = structure.problem, structure.parameters
    steps = parameters.horizon
    model = Model(problem.robot, parameters.step)
    stage = Stage(problem.robot, problem.goal, structure.capacities, parameters)
    single = stage.function()
    horizon = single.map(steps)
    if parameters.compile:
        horizon = compiled(horizon)
    slopes = None if model.linear else model.slopes(steps)
    points = stage.points().map(steps) if MESH in structure.capacities else None
    return Composed(model, horizon, model.rollout(steps), slopes, points, _nonlinear(parameters, stage, single, model))


def _nonlinear(parameters: MpcParameters, stage: Stage, single: Any, model: Model) -> NonlinearProgram | None:
    if parameters.solver == "sqp":
        return None
    sizes = Sizes(parameters.horizon, model.inputs, model.states, model.dof, single.size1_out("d"))
    weights, goal_weights = _weights(parameters), _goal_weights(parameters)
    return compose(parameters.solver, single, stage.errors(), model, sizes, weights, goal_weights, parameters.tolerance)


def _weights(parameters: MpcParameters) -> Weights:
    return Weights(
        parameters.velocity,
        parameters.velocity_end,
        parameters.input,
        parameters.input_change,
        parameters.slack,
        parameters.slack_squared,
    )


def _goal_weights(parameters: MpcParameters) -> FloatArray:
    """Of the squared errors after each step, (N,)."""
    weights = np.full(parameters.horizon, parameters.goal)
    weights[-1] = parameters.goal_end
    return weights


def _mesh_fill(problem: PlannerProblem, points: Any, arguments: Any, steps: int) -> MeshFill:
    buffered = BufferedFunction(points)

    def balls(q: FloatArray) -> FloatArray:
        buffered.arguments["q"][:] = q.reshape(buffered.arguments["q"].shape)
        buffered()
        return buffered.results["points"].reshape(steps, -1, 3)

    return MeshFill(problem.obstacles, balls, arguments[f"obstacles_{MESH}"], steps)
