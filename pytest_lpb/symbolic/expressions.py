"""Expressions that researchers write as text, such as `-0.5 * xdot**2 / x**5`, as CasADi expressions.

They are read with the whitelist of expressions in t, never evaluated as code.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion.expressions import FUNCTIONS as MOTION_FUNCTIONS
from pytest_lpb.motion.expressions import Expression, parse_expression

if TYPE_CHECKING:
    import casadi

FUNCTIONS = (*MOTION_FUNCTIONS, "log", "tanh", "sign")

_CASADI_NAMES = {"abs": "fabs"}  # where they differ from ours
_UNARY: Mapping[str, Callable[[casadi.SX], casadi.SX]] = {"negative": operator.neg, "positive": lambda a: a}
_BINARY: Mapping[str, Callable[[casadi.SX, casadi.SX], casadi.SX]] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": operator.truediv,
    "power": operator.pow,
    # CasADi multiplies for whole exponents up to 100: right for negative bases, and smooth at a base of 0.
    "power_constant": operator.pow,
}


def casadi_expression(text: str, symbols: Mapping[str, casadi.SX]) -> casadi.SX:
    """The expression in the given symbols.

    Derivatives are CasADi's: that of sign is 0, that of abs is sign, so 0 at the kink. CasADi also simplifies where a
    value is undefined: `0/x` is 0 and `x/x` is 1, at x = 0 too.

    Raises:
        ScenarioError, ValueError: as `parse_expression`.
    """
    stack: list[casadi.SX] = []
    for step in _parsed(text, tuple(symbols)).program:
        stack.append(_apply(step, stack, symbols))
    return stack.pop()


def check_expression(text: str, variables: tuple[str, ...]) -> str:
    """The text itself, when it is an expression in these variables; needs no CasADi.

    Raises:
        ValueError: it is none, with the parser's message; for pydantic's AfterValidator.
    """
    try:
        _parsed(text, variables)
    except ScenarioError as error:
        raise ValueError(str(error)) from None
    return text


def _parsed(text: str, variables: tuple[str, ...]) -> Expression:
    return parse_expression(text, variables, FUNCTIONS)


def _apply(step: float | str, stack: list[casadi.SX], symbols: Mapping[str, casadi.SX]) -> casadi.SX:
    # Imported late, so that configurations can be checked where CasADi is not installed.
    import casadi

    if isinstance(step, float):
        # As SX, for constants: Python's floats raise where SX gives an infinity or NaN, or turn complex.
        return casadi.SX(step)
    if step in symbols:
        return symbols[step]
    if step in _BINARY:
        right = stack.pop()
        return _BINARY[step](stack.pop(), right)
    function: Callable[[casadi.SX], casadi.SX] = _UNARY.get(step) or getattr(casadi, _CASADI_NAMES.get(step, step))
    return function(stack.pop())
