"""How a robot moves over one step of the horizon, as CasADi expressions.

The state is (q, u), the inputs are the rates of u. Robots whose velocities are independent move exactly as in the
environment; non-holonomic bases by Runge and Kutta's fourth-order method.
"""

from __future__ import annotations

from typing import Any

import casadi
import numpy as np

from pytest_lpb.problem.robot import Robot
from pytest_lpb.symbolic.kinematics import velocity_map


class Model:
    """The motion of a robot over a step.

    Args:
        robot: any robot.
        step: [s].

    Attributes:
        states: size of the state (q, u).
        inputs: size of u.
        linear: whether Jacobians are the same everywhere.
    """

    def __init__(self, robot: Robot, step: float) -> None:
        self.dof = robot.dof
        self.inputs = robot.n_actions
        self.states = robot.dof + robot.n_actions
        self.linear = not robot.non_holonomic
        state, rates = casadi.SX.sym("x", self.states), casadi.SX.sym("a", self.inputs)
        after = self._after(robot, state, rates, step)
        jacobians = [casadi.densify(casadi.jacobian(after, by)) for by in (state, rates)]
        self._move = casadi.Function("move", [state, rates], [after], {"cse": True})
        self._slopes = casadi.Function("slopes", [state, rates], jacobians, {"cse": True})
        # Those of linear models, (states, states) and (states, inputs).
        here = self._slopes(casadi.DM.zeros(self.states), casadi.DM.zeros(self.inputs))
        self.by_state, self.by_input = (np.array(part) for part in here)

    def _after(self, robot: Robot, state: Any, rates: Any, step: float) -> Any:
        dof = robot.dof

        def change(there: Any) -> Any:
            return casadi.vertcat(velocity_map(robot, there[:dof]) @ there[dof:], rates)

        first = change(state)
        second = change(state + 0.5 * step * first)
        if self.linear:  # constant acceleration: exact
            return state + step * second
        third = change(state + 0.5 * step * second)
        return state + step / 6.0 * (first + 2.0 * second + 2.0 * third + change(state + step * third))

    def rollout(self, steps: int) -> Any:
        """Function of the state `x` and the inputs `a` (inputs, steps) to the states after each step, `path`."""
        state, rates = casadi.MX.sym("x", self.states), casadi.MX.sym("a", self.inputs, steps)
        path = self._move.mapaccum("path", steps)(state, rates)
        return casadi.Function("rollout", [state, rates], [path], ["x", "a"], ["path"])

    def slopes(self, steps: int) -> Any:
        """Function of the states before each step and the inputs to the Jacobians, step by step, side by side."""
        states, rates = casadi.MX.sym("x", self.states, steps), casadi.MX.sym("a", self.inputs, steps)
        by_state, by_input = self._slopes.map(steps)(states, rates)
        return casadi.Function("all_slopes", [states, rates], [by_state, by_input], ["x", "a"], ["A", "B"])
