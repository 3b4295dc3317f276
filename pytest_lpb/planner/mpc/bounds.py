"""Bounds of a program's variables: the robot's limits, and what braking cannot keep of them.

Bounds at the steps alone keep no position limit: calls come between steps too, plans may swing past a limit between two
of them, and one that ends at a limit at full speed leaves no way to stop. So the first input is bounded besides, such
that after it q + s(u) <= limit, with h a step, b the largest braking, and

    s(u) = h u             up to u = b h: that much way is left to coast for one step,
    s(u) = u^2/2b + b h^2/2  above: to brake down to there as hard as can be.

Braking keeps this for ever, however often it is planned anew, and nothing passes the limit in between (a control
barrier function: Ames, Xu, Grizzle and Tabuada, "Control Barrier Function Based Quadratic Programs for Safety Critical
Systems", IEEE Trans. Automatic Control 62, 2017).
"""

from __future__ import annotations

import dataclasses
from typing import Any

import casadi
import numpy as np

from pytest_lpb.planner.base import FloatArray
from pytest_lpb.planner.mpc.model import Model
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.program import Program
from pytest_lpb.problem.robot import Limits
from pytest_lpb.symbolic.buffered import BufferedFunction

# [rad or m] by which plans stay within position limits. Of what an input moves directly: none is needed where the robot
# moves exactly as planned; this is for simulated motors. Of x, y and headings that follow from others: bounds at the
# steps are all there is, and between them a base may pass by so much.
INSET = 1e-3
INSET_OF_BASES = 2e-2
LARGEST_SHARE = 0.25  # of the range between two limits, that is left out at each
GIVE = 1e-6  # [rad, m, ..] by which bounds give way beyond what braking needs


def planned_limits(limits: Limits, model: Model, parameters: MpcParameters) -> Limits:
    """The robot's limits, with the parameters' own, and position limits with their inset."""
    lower, upper = limits.position.T
    inset = np.full(model.dof, INSET_OF_BASES)
    inset[[place for place, _ in model.follows]] = INSET
    inset = np.minimum(inset, LARGEST_SHARE * (upper - lower))
    return dataclasses.replace(
        limits,
        position=np.column_stack([lower + inset, upper - inset]),
        velocity=_within(limits.velocity, parameters.velocity_limit),
        acceleration=_within(limits.acceleration, parameters.input_limit),
    )


def guard_of(model: Model, limits: Limits, steps: int, period: float) -> Any:
    """What keeps position limits where they can be kept, composed.

    Args:
        model: of the motion.
        limits: as planned with.
        steps: N.
        period: [s] for which the first input is held.

    Returns:
        Function of the state `x` (m,) to a motion within the limits of the inputs that brakes, and keeps or comes back
        to the position limits, as the states after each step, `path` (m, N); and to bounds of the first input, `low`
        and `high` (n,), that leave it possible.
    """
    state = casadi.SX.sym("x", model.states)
    slowest, fastest = (casadi.DM(limits.acceleration[:, side]) for side in (0, 1))
    low, high = _keeping(model, limits, state, model.step)
    braking = casadi.fmin(casadi.fmax(-state[model.dof :] / model.step, low), high)
    braking = casadi.fmin(casadi.fmax(braking, slowest), fastest)
    keep = casadi.Function("keep", [state], [model.move(state, braking)], {"cse": True})
    low, high = _keeping(model, limits, state, period)
    low = casadi.fmax(slowest, casadi.fmin(low, braking))
    high = casadi.fmin(fastest, casadi.fmax(high, braking))
    bounds = casadi.Function("bounds", [state], [casadi.densify(bound) for bound in (low, high)], {"cse": True})
    start = casadi.MX.sym("x", model.states)
    path = keep.mapaccum("kept", steps)(start)
    return casadi.Function("guard", [start], [path, *bounds(start)], ["x"], ["path", "low", "high"])


def _keeping(model: Model, limits: Limits, state: Any, held: float) -> tuple[Any, Any]:
    """Inputs (n, 1) from the least to the largest that, held so long [s], leave room to stop within position limits."""
    low, high = casadi.SX(casadi.DM.ones(model.inputs) * -np.inf), casadi.SX(casadi.DM.ones(model.inputs) * np.inf)
    for place, entry in model.follows:
        q, u = state[place], state[model.dof + entry]
        lower, upper = limits.position[place]
        slowest, fastest = limits.acceleration[entry]
        mean = 0.5 * held + model.lead[entry]
        if np.isfinite(upper):
            high[entry] = (_fastest(upper - q - held * u + mean * u, mean, model.step, -slowest) - u) / held
        if np.isfinite(lower):
            low[entry] = (-_fastest(q - lower + held * u - mean * u, mean, model.step, fastest) - u) / held
    return low, high


def _fastest(left: Any, mean: float, step: float, brake: float) -> Any:
    """The velocity v towards a limit from which it is kept: mean v + s(v) is the way that is left.

    Args:
        left: [rad or m].
        mean: [s] for which the new velocity counts of the time until it is reached.
        step: [s], h.
        brake: [rad/s^2 or m/s^2], b; may be infinite.
    """
    gentle = left / (mean + step)
    if not np.isfinite(brake):
        return gentle
    square = mean * mean + 2.0 * left / brake - step * step
    return casadi.if_else(gentle <= brake * step, gentle, brake * (casadi.sqrt(casadi.fmax(square, 0.0)) - mean))


class Bounds:
    """Fills in the bounds of a program.

    Args:
        guard: as composed by `guard_of`.
        limits: as planned with.
        step: [s].
    """

    def __init__(self, guard: Any, limits: Limits, step: float) -> None:
        self._guard = BufferedFunction(guard)
        self._inputs = limits.acceleration
        self._states = np.concatenate([limits.position, limits.velocity])
        self._low, self._high = self._guard.results["low"], self._guard.results["high"]
        self._step = step

    def fill(self, program: Program, state: FloatArray) -> None:
        """Fill in the bounds of a plan from a state (m,); those of states give way where braking cannot keep them."""
        guard, sizes = self._guard, program.sizes
        guard.arguments["x"][:] = state
        guard.evaluate()
        program.lower[sizes.slack_places] = 0.0
        program.lower[sizes.input_places], program.upper[sizes.input_places] = self._inputs.T
        kept = guard.results["path"].reshape(sizes.steps, sizes.states)
        program.lower[sizes.state_places] = np.minimum(self._states[:, 0], kept) - GIVE
        program.upper[sizes.state_places] = np.maximum(self._states[:, 1], kept) + GIVE
        # The first input's as the velocity's after it, which has bounds: new ones cost the solver iterations.
        first, u = sizes.state_places[0, sizes.dof :], state[sizes.dof :]
        program.lower[first] = np.maximum(program.lower[first], u + self._step * self._low - GIVE)
        program.upper[first] = np.minimum(program.upper[first], u + self._step * self._high + GIVE)

    def clipped(self, inputs: FloatArray) -> FloatArray:
        """The first inputs (n,) of a plan within the bounds that were filled in last: solutions have a tolerance."""
        clipped: FloatArray = np.clip(inputs, self._low, self._high)
        return clipped


def _within(limits: FloatArray, bound: float | None) -> FloatArray:
    """Limits (n, 2), no farther from 0 than a bound."""
    return limits if bound is None else np.clip(limits, -bound, bound)
