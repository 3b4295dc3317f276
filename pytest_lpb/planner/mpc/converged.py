"""The problem of `program.py` solved to convergence, as a nonlinear program: a reference for real-time iterations.

By ipopt (Wächter and Biegler, "On the implementation of an interior-point filter line-search algorithm for large-scale
nonlinear programming", Math. Program. 106, 2006) or fatrop (Vanroye, Sathya, De Schutter and Decré, "FATROP: A Fast
Constrained Optimal Control Problem Solver for Robot Trajectory Optimization and Control", IROS 2023).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import casadi
import numpy as np

from pytest_lpb.planner.base import FloatArray
from pytest_lpb.planner.mpc.model import Model
from pytest_lpb.planner.mpc.program import Index, Sizes, Weights
from pytest_lpb.planner.mpc.solver import RESIDUAL, Solution

Plugin = Literal["ipopt", "fatrop"]

MOST_ITERATIONS = 200
FIRST_BARRIER = 1e-2  # barrier parameter at first
PUSH = 1e-6  # how far warm starts are moved off bounds
IPOPT = {
    "print_level": 0,
    "sb": "yes",
    "max_iter": MOST_ITERATIONS,
    "mu_init": FIRST_BARRIER,
    "bound_relax_factor": 0.0,
    "warm_start_init_point": "yes",
    "warm_start_bound_push": PUSH,
    "warm_start_bound_frac": PUSH,
    "warm_start_slack_bound_push": PUSH,
    "warm_start_slack_bound_frac": PUSH,
    "warm_start_mult_bound_push": PUSH,
}
FATROP = {"print_level": 0, "max_iter": MOST_ITERATIONS, "mu_init": 1e-4}


@dataclass(frozen=True, eq=False)
class NonlinearProgram:
    """A composed nonlinear program, the same for all problems of equal structure.

    Attributes:
        function: the solver.
        names: of the stage's arguments but q, in the order of the program's parameters.
        places: of its variables among those of `program.Program`.
        bounded: which of its variables have bounds.
        equal: which of its constraints are equalities; all others are to be at least zero.
    """

    function: Any
    names: Sequence[str]
    places: Index
    bounded: Any
    equal: Any


@dataclass
class _Parts:
    """Variables, constraints and cost as they are collected, stage by stage."""

    variables: list[Any] = field(default_factory=list)
    places: list[Index] = field(default_factory=list)
    bounded: list[bool] = field(default_factory=list)
    constraints: list[Any] = field(default_factory=list)
    equal: list[bool] = field(default_factory=list)
    cost: Any = 0.0

    def variable(self, name: str, places: Index, *, bounded: bool = True) -> Any:
        """A new vector of variables."""
        symbol = casadi.MX.sym(name, places.size)
        self.variables.append(symbol)
        self.places.append(places)
        self.bounded += [bounded] * places.size
        return symbol

    def constrain(self, value: Any, *, equal: bool) -> None:
        """That a vector be zero, or at least zero."""
        self.constraints.append(value)
        self.equal += [equal] * value.numel()


def compose(
    plugin: Plugin,
    stage: Any,
    errors: Any,
    model: Model,
    sizes: Sizes,
    weights: Weights,
    goal_weights: FloatArray,
    tolerance: float,
) -> NonlinearProgram:
    """Compose the nonlinear program.

    Distances must be differentiable twice nearly everywhere: stages that pick the nearest rows are not (rows jump where
    two are as near), so that `nearest` has to be 0, and `own_nearest` 0 or at least the number of pairs.

    Args:
        plugin: the solver, `ipopt` or `fatrop`.
        stage: `Stage.function()`, of one step and not compiled.
        errors: function of `q` and `goals` to the weighted errors, see `Stage.errors`.
        model: of the motion.
        sizes: of the program.
        weights: of all but the errors.
        goal_weights: of the squared errors after each step, (N,).
        tolerance: of the optimality conditions.
    """
    names = stage.name_in()[1:]
    start, last = casadi.MX.sym("start", sizes.states), casadi.MX.sym("last", sizes.inputs)
    given = [casadi.MX.sym(name, stage.nnz_in(place), sizes.steps) for place, name in enumerate(names, 1)]
    # fatrop knows costs within a stage only: the input before is a state there.
    carried = plugin == "fatrop" and weights.input_change > 0.0
    cost = _StageCost(errors, goal_weights, weights, weights.velocities(sizes))
    parts = _transcribed(start, last, _arguments(stage, given, sizes.steps), stage, model, sizes, cost, carried=carried)
    program = {
        "x": casadi.vertcat(*parts.variables),
        "p": casadi.vertcat(start, last, *(casadi.vec(symbol) for symbol in given)),
        "f": parts.cost,
        "g": casadi.vertcat(*parts.constraints),
    }
    options = _options(plugin, tolerance, sizes, parts.equal, carried=carried)
    function = casadi.nlpsol("converged", plugin, program, options)
    return NonlinearProgram(
        function, names, np.concatenate(parts.places), np.array(parts.bounded), np.array(parts.equal)
    )


def _transcribed(
    start: Any,
    last: Any,
    arguments: Sequence[Sequence[Any]],
    stage: Any,
    model: Model,
    sizes: Sizes,
    cost: _StageCost,
    *,
    carried: bool,
) -> _Parts:
    """Variables, constraints and cost of all steps; both orders and the sign of the motion's gaps are fatrop's.

    Args:
        start, last: symbols of the state at the start and of the input before the first.
        arguments: of the stage but q, step by step.
        stage, model, sizes: as `compose` has them.
        cost: of a step.
        carried: whether the input before is a state.
    """
    distances, move = _distances(stage), model.move
    parts = _Parts()
    state, before, rows = start, last, casadi.MX(0, 1)
    for k, here in enumerate(arguments):
        rates = parts.variable(f"a{k}", sizes.input_places[k])
        after = parts.variable(f"x{k + 1}", sizes.state_places[k])
        parts.constrain(after - move(state, rates), equal=True)
        change = rates - before
        before = rates
        if carried:
            before = parts.variable(f"last{k + 1}", sizes.input_places[k], bounded=False)
            parts.constrain(before - rates, equal=True)
        parts.constrain(rows, equal=False)
        # Before the rates of the next step, among whose stage's inputs the slack is.
        slack = parts.variable(f"s{k}", sizes.slack_places[k])
        q, u = after[: sizes.dof], after[sizes.dof :]
        rows = distances(q, *here) + slack
        parts.cost += cost.of(rates, change) + cost.after(k, q, u, here[0]) + cost.missed(slack)
        state = after
    parts.constrain(rows, equal=False)
    return parts


@dataclass(frozen=True, eq=False)
class _StageCost:
    """The cost of one step.

    Attributes:
        errors: function of q and the targets to the weighted errors.
        goal_weights: of the squared errors after each step, (N,).
        weights: of all else.
        velocity_weights: of the velocities after each step, (N, n).
    """

    errors: Any
    goal_weights: FloatArray
    weights: Weights
    velocity_weights: FloatArray

    def of(self, rates: Any, change: Any) -> Any:
        """Of inputs and their change."""
        return 0.5 * self.weights.input * casadi.sumsqr(rates) + 0.5 * self.weights.input_change * casadi.sumsqr(change)

    def after(self, k: int, q: Any, u: Any, targets: Any) -> Any:
        """Of the state after step k."""
        errors = 0.5 * float(self.goal_weights[k]) * casadi.sumsqr(self.errors(q, targets))
        return errors + 0.5 * casadi.dot(casadi.DM(self.velocity_weights[k]), u**2)

    def missed(self, slack: Any) -> Any:
        """Of a slack."""
        return self.weights.slack * slack + 0.5 * self.weights.slack_squared * slack**2


def _arguments(stage: Any, given: Sequence[Any], steps: int) -> list[list[Any]]:
    """A stage's arguments but q, step by step, out of symbols with a column per step."""
    return [
        [casadi.reshape(symbol[:, k], stage.size_in(place)) for place, symbol in enumerate(given, 1)]
        for k in range(steps)
    ]


def _options(plugin: Plugin, tolerance: float, sizes: Sizes, equal: Sequence[bool], *, carried: bool) -> dict[str, Any]:
    options: dict[str, Any] = {"print_time": False, "error_on_fail": False, "show_eval_warnings": False, "expand": True}
    if plugin == "ipopt":
        return options | {"ipopt": {**IPOPT, "tol": tolerance}}
    options |= {"fatrop": {**FATROP, "tol": tolerance}, "equality": list(equal), "structure_detection": "manual"}
    return options | _structure(sizes, carried=carried)


def guess_of(sizes: Sizes, plan: FloatArray, path: FloatArray) -> FloatArray:
    """The variables of a plan (N, n) and its path (N, m), without slack."""
    z = np.zeros(sizes.variables)
    z[sizes.input_places] = plan
    z[sizes.state_places] = path
    return z


def _structure(sizes: Sizes, *, carried: bool) -> dict[str, Any]:
    """Sizes of fatrop's stages: the start, which has inputs only, and the states after each step."""
    steps, states = sizes.steps, sizes.states + (sizes.inputs if carried else 0)
    return {
        "N": steps,
        "nx": [0] + [states] * steps,
        "nu": [sizes.inputs] + [1 + sizes.inputs] * (steps - 1) + [1],
        "ng": [0] + [sizes.rows] * steps,
    }


def _distances(stage: Any) -> Any:
    """A stage's distances as a function of its arguments."""
    symbols = stage.sx_in()
    results = dict(zip(stage.name_out(), stage.call(symbols), strict=True))
    return casadi.Function("distances", symbols, [results["d"]], {"cse": True})


class ConvergedSolver:
    """Solves a nonlinear program again and again, each time from the last multipliers.

    Args:
        program: composed.
        sizes: of the program.
    """

    def __init__(self, program: NonlinearProgram, sizes: Sizes) -> None:
        self._program = program
        self._sizes = sizes
        self._multipliers: dict[str, Any] = {}
        self._upper = np.where(program.equal, 0.0, np.inf)

    def solve(
        self,
        state: FloatArray,
        last_input: FloatArray,
        arguments: Mapping[str, FloatArray],
        lower: FloatArray,
        upper: FloatArray,
        guess: FloatArray,
    ) -> Solution:
        """Solve for the variables z of `program.Program`, in its order.

        Args:
            state: at the start.
            last_input: the one before the first.
            arguments: of the stage at all steps, as those of `BufferedFunction(stage.map(N))`; q is not looked at.
            lower, upper: bounds of z.
            guess: of z.
        """
        program, places = self._program, self._program.places
        given = [np.asarray(arguments[name]).ravel() for name in program.names]
        found = program.function(
            x0=guess[places],
            p=np.concatenate([state, last_input, *given]),
            lbx=np.where(program.bounded, lower[places], -np.inf),
            ubx=np.where(program.bounded, upper[places], np.inf),
            lbg=0.0,
            ubg=self._upper,
            **self._multipliers,
        )
        stats = program.function.stats()
        z = np.empty(self._sizes.variables)
        z[places] = np.asarray(found["x"]).ravel()
        finite = bool(np.isfinite(z).all())
        residual = self._residual(np.asarray(found["g"]).ravel(), z, lower, upper) if finite else np.inf
        solved = finite and (bool(stats["success"]) or residual < RESIDUAL)
        self._multipliers = {"lam_x0": found["lam_x"], "lam_g0": found["lam_g"]} if solved else {}
        return Solution(z, solved, int(stats.get("iter_count", 0)), residual)

    def _residual(self, constraints: FloatArray, z: FloatArray, lower: FloatArray, upper: FloatArray) -> float:
        """How far constraints and bounds are missed at most."""
        missed = np.where(self._program.equal, np.abs(constraints), -constraints)
        return float(max(0.0, missed.max(), (lower - z).max(), (z - upper).max()))
