"""How a robot moves over one step of the horizon, as CasADi expressions.

The state is (q, u), the inputs are the rates of u. Robots whose velocities are independent move exactly as in the
environment; non-holonomic bases by Runge and Kutta's fourth-order method.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import casadi
import numpy as np

from pytest_lpb.planner.base import FloatArray
from pytest_lpb.problem.robot import Robot
from pytest_lpb.symbolic.kinematics import velocity_map


class Model:
    """The motion of a robot over a step.

    Args:
        robot: any robot.
        step: [s].
        lead: [s] by which u is ahead of what constant rates would have made of it, (n,): under velocity control u is
            not on its way to what it will be after a period, but is that all through it. None: 0.

    Attributes:
        states: size of the state (q, u), m.
        inputs: size of u, n.
        linear: whether Jacobians are the same everywhere.
        by_state, by_input: these Jacobians, (m, m) and (m, n).
        follows: pairs of an entry of q and the entry of u that is its rate.
        move: function of a state (m,) and inputs (n,) to the state after a step.
    """

    def __init__(self, robot: Robot, step: float, lead: FloatArray | None = None) -> None:
        self.step = step
        self.lead = np.zeros(robot.n_actions) if lead is None else lead
        self.dof = robot.dof
        self.inputs = robot.n_actions
        self.states = robot.dof + robot.n_actions
        self.linear = not robot.non_holonomic
        self.follows = list(_follows(robot))
        state, rates = casadi.SX.sym("x", self.states), casadi.SX.sym("a", self.inputs)
        after = self._after(robot, state, rates)
        jacobians = [casadi.densify(casadi.jacobian(after, by)) for by in (state, rates)]
        self.move = casadi.Function("move", [state, rates], [after], {"cse": True})
        self._slopes = casadi.Function("slopes", [state, rates], jacobians, {"cse": True})
        here = self._slopes(casadi.DM.zeros(self.states), casadi.DM.zeros(self.inputs))
        self.by_state, self.by_input = (np.array(part) for part in here)

    def _after(self, robot: Robot, state: Any, rates: Any) -> Any:
        dof, step = self.dof, self.step
        ahead = casadi.DM(self.lead) * rates

        def change(there: Any) -> Any:
            return casadi.vertcat(velocity_map(robot, there[:dof]) @ (there[dof:] + ahead), rates)

        first = change(state)
        second = change(state + 0.5 * step * first)
        if self.linear:  # constant acceleration: exact
            return state + step * second
        third = change(state + 0.5 * step * second)
        return state + step / 6.0 * (first + 2.0 * second + 2.0 * third + change(state + step * third))

    def rollout(self, steps: int) -> Any:
        """Function of the state `x` and the inputs `a` (inputs, steps) to the states after each step, `path`."""
        state, rates = casadi.MX.sym("x", self.states), casadi.MX.sym("a", self.inputs, steps)
        path = self.move.mapaccum("path", steps)(state, rates)
        return casadi.Function("rollout", [state, rates], [path], ["x", "a"], ["path"])

    def slopes(self, steps: int) -> Any:
        """Function of the states before each step and the inputs to the Jacobians, step by step, side by side."""
        states, rates = casadi.MX.sym("x", self.states, steps), casadi.MX.sym("a", self.inputs, steps)
        by_state, by_input = self._slopes.map(steps)(states, rates)
        return casadi.Function("all_slopes", [states, rates], [by_state, by_input], ["x", "a"], ["A", "B"])


def _follows(robot: Robot) -> Iterator[tuple[int, int]]:
    """Pairs of an entry of q and the entry of u that is its rate, wherever the robot is."""
    q = casadi.SX.sym("q", robot.dof)
    columns = casadi.SX(velocity_map(robot, q))
    for place in range(robot.dof):
        row = columns[place, :]
        if casadi.depends_on(row, q):
            continue
        entries = np.array(casadi.evalf(row))[0]
        if np.count_nonzero(entries) == 1 and entries.max() == 1.0:
            yield place, int(entries.argmax())


def lead_of(robot: Robot, dt: float, period: float) -> FloatArray:
    """The lead of u [s] under velocity control, (n,): half of the time in which u is given its new value.

    Without limits of acceleration that is at the beginning of a period; else the environment lets it change step by
    step of dt, as far as they allow.
    """
    if robot.control != "velocity":
        return np.zeros(robot.n_actions)
    limited = np.isfinite(robot.limits.acceleration).all(axis=1)
    return 0.5 * np.where(limited, dt, period)
