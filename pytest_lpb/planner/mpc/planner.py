"""Model predictive control in real time; docs/mpc.md has the problem and what each parameter does.

Multiple shooting (Bock and Plitt, 1984) with real-time iterations (Diehl et al., "Real-time optimization and nonlinear
model predictive control of processes governed by differential-algebraic equations", J. Process Control 12, 2002).
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any, ClassVar

import numpy as np

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.planner.known import check_shapes
from pytest_lpb.planner.mpc.bounds import Bounds
from pytest_lpb.planner.mpc.composed import composed_for
from pytest_lpb.planner.mpc.converged import ConvergedSolver, guess_of
from pytest_lpb.planner.mpc.horizon import Horizon
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.program import Program
from pytest_lpb.planner.mpc.solver import PiqpSolver, Solution
from pytest_lpb.planner.task import SUPPORTED, check_control
from pytest_lpb.problem.preview import Preview

ROUNDING = 1e-6  # relative


class Mpc(Planner):
    """Plans over a horizon at each call, by one or more quadratic programs, and carries out the beginning."""

    name: ClassVar[str] = "mpc"
    supports: ClassVar[Mapping[str, tuple[str, ...]]] = SUPPORTED
    Parameters = MpcParameters

    parameters: MpcParameters

    @classmethod
    def preview_for(cls, parameters: Any) -> Preview:
        """Where obstacles and goals will be after each step of the horizon."""
        return Preview(parameters.horizon, parameters.step)

    def setup(self, problem: PlannerProblem) -> None:
        """Compose the horizon, or take the composed one of an equal structure."""
        check_control(self.name, problem)
        check_shapes(self.name, problem)
        _check_period(problem, self.parameters)
        _check_solver(self.parameters)
        parameters = self.parameters
        composed = composed_for(problem, parameters)
        self._horizon = Horizon(problem, composed, parameters)
        self._bounds = Bounds(composed.guard, composed.limits, parameters.step)
        self._program = Program(composed.sizes)
        self._solver = PiqpSolver(self._program, parameters.tolerance)
        self._converged = None
        if composed.nonlinear is not None:
            self._converged = ConvergedSolver(composed.nonlinear, composed.sizes)
        self._acceleration = composed.limits.acceleration
        self._share = problem.period / parameters.step
        self._period = problem.period if problem.control == "velocity" else None
        self._plan: FloatArray = np.zeros((composed.sizes.steps, composed.sizes.inputs))
        self._last = np.zeros(composed.sizes.inputs)
        self._first = True
        self._failed = inf  # so many calls ago there was a plan: before the first there is none

    def compute_action(self, observation: Observation) -> FloatArray:
        """The first inputs of a new plan, (n,), or u after one period of them under velocity control."""
        state = np.concatenate([observation["q"], observation["u"]])
        self._horizon.observe(observation)
        if not self._first:
            self._plan = _shifted(self._plan, self._share)
        self._failed += 1.0
        self._bounds.fill(self._program, state)
        solution = self._iterate_all(state) if self._converged is None else self._converge(state, self._converged)
        self._first = False
        if self._failed * self._share > len(self._plan):
            # Nothing is left of the last plan that was one: to rest, as fast as the limits allow.
            self._plan = _braking(observation["u"], self._acceleration, len(self._plan), self.parameters.step)
        self.diagnostics = {
            "solved": float(solution.solved),
            "iterations": float(solution.iterations),
            "residual": solution.residual,
        }
        self._last = self._bounds.clipped(self._plan[0])
        if self._period is None:
            return self._last.copy()
        return np.asarray(observation["u"] + self._period * self._last)

    def _iterate_all(self, state: FloatArray) -> Solution:
        """So many iterations as there are in a call, or up to one that fails."""
        solution = self._iterate(state)
        for _ in range((self.parameters.first_iterations if self._first else self.parameters.iterations) - 1):
            if not solution.solved:
                break
            solution = self._iterate(state)
        return solution

    def _iterate(self, state: FloatArray) -> Solution:
        """One quadratic program around the plan, which becomes its solution if there is one."""
        self._horizon.linearise(self._program, state, self._plan, self._last)
        return self._taken(self._solver.solve())

    def _converge(self, state: FloatArray, solver: ConvergedSolver) -> Solution:
        """The nonlinear program itself, started from the plan."""
        horizon, program = self._horizon, self._program
        path = horizon.path(state, self._plan)
        horizon.place_meshes(path[:, : horizon.sizes.dof])
        guess = guess_of(horizon.sizes, self._plan, path)
        return self._taken(solver.solve(state, self._last, horizon.arguments, program.lower, program.upper, guess))

    def _taken(self, solution: Solution) -> Solution:
        """A solution, whose inputs are the plan from now on if it is one."""
        if solution.solved:
            self._plan = solution.z[self._program.sizes.input_places]
            self._failed = 0.0
        return solution


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


def _shifted(plan: FloatArray, share: float) -> FloatArray:
    """A plan (N, n) a share of a step later."""
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
