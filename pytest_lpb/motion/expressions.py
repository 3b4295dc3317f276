"""Expressions in t, such as `0.5*sin(2*pi*t)`: parsed with a whitelist, never evaluated as code.

An expression becomes a short postfix program over Taylor jets: velocity and acceleration are exact.
Expressions in other variables are parsed in the same way; who asks for them evaluates their programs.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pytest_lpb.motion.grammar import Grammar, Program, compile_expression
from pytest_lpb.motion.intervals import speed_bounds
from pytest_lpb.motion.jets import BINARY, UNARY, FloatArray, Jet, constant, variable

FUNCTIONS = ("sin", "cos", "tan", "exp", "sqrt", "abs")


@dataclass(frozen=True)
class Expression:
    """A parsed expression.

    Attributes:
        text: the expression as written.
        program: postfix: a number, a variable, or the name of an operation on what comes before it.
        moving: whether the expression depends on a variable.
    """

    text: str
    program: Program
    moving: bool

    def evaluate(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Value, d/dt and d2/dt2 at the times t (N,) [s], each (N,); not finite where undefined.

        For expressions in t with `FUNCTIONS`.
        """
        stack: list[Jet] = []
        with np.errstate(all="ignore"):
            for step in self.program:
                stack.append(_apply(step, stack, t))
        value, first, second = (np.broadcast_to(part, t.shape).astype(np.float64) for part in stack.pop())
        return value, first, second

    def speed_bound(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Bounds of |d/dt| over the spans [start, end] of time, each (N,) [s]: (N,); inf where there is none."""
        return speed_bounds(self.program, start, end)


def _apply(step: float | str, stack: list[Jet], t: FloatArray) -> Jet:
    if isinstance(step, float):
        return constant(step)
    if step == "t":
        return variable(t)
    if step in UNARY:
        return UNARY[step](stack.pop())
    right = stack.pop()
    return BINARY[step](stack.pop(), right)


@lru_cache(maxsize=4096)
def parse_expression(
    text: str, variables: tuple[str, ...] = ("t",), functions: tuple[str, ...] = FUNCTIONS
) -> Expression:
    """Parse an expression in the given variables.

    Raises:
        ScenarioError: the text is no expression, too long or too deep, or uses something that is not allowed.
        ValueError: a variable bears the name of a function, a constant or an operation of programs.
    """
    program, moving = compile_expression(text, Grammar(variables, functions))
    return Expression(text, program, moving)
