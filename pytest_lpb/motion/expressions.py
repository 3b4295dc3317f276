"""Expressions in t, such as `0.5*sin(2*pi*t)`: parsed with a whitelist, never evaluated as code.

An expression becomes a short postfix program over Taylor jets: velocity and acceleration are exact.
"""

import ast
import math
import warnings
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion.jets import BINARY, UNARY, FloatArray, Jet, constant, variable
from pytest_lpb.names import suggestion

MAX_LENGTH = 500  # characters
MAX_NODES = 250
MAX_DEPTH = 60

FUNCTIONS = ("sin", "cos", "tan", "exp", "sqrt", "abs")
CONSTANTS = {"pi": math.pi}
ALLOWED = "numbers, t, pi, + - * / **, and the functions " + " ".join(FUNCTIONS)

_BINARY_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "add",
    ast.Sub: "subtract",
    ast.Mult: "multiply",
    ast.Div: "divide",
    ast.Pow: "power",
}
_UNARY_OPERATORS: dict[type[ast.unaryop], str] = {ast.USub: "negative", ast.UAdd: "positive"}


@dataclass(frozen=True)
class Expression:
    """A parsed expression.

    Attributes:
        text: the expression as written.
        program: postfix: a number, `t`, or the name of an operation on the jets before it.
        moving: whether the expression depends on t.
    """

    text: str
    program: tuple[float | str, ...]
    moving: bool

    def evaluate(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Value, d/dt and d2/dt2 at the times t (N,) [s], each (N,); not finite where undefined."""
        stack: list[Jet] = []
        with np.errstate(all="ignore"):
            for step in self.program:
                stack.append(_apply(step, stack, t))
        value, first, second = (np.broadcast_to(part, t.shape).astype(np.float64) for part in stack.pop())
        return value, first, second


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
def parse_expression(text: str) -> Expression:
    """Parse an expression in t.

    Raises:
        ScenarioError: the text is no expression, too long or too deep, or uses something that is not allowed.
    """
    if len(text) > MAX_LENGTH:
        raise ScenarioError(f"an expression of {len(text)} characters; allowed are at most {MAX_LENGTH}")
    compiler = _Compiler(text)
    moving = compiler.compile(_parse(text), depth=1)
    return Expression(text, tuple(compiler.program), moving)


def _parse(text: str) -> ast.expr:
    try:
        with warnings.catch_warnings():
            # Python warns of literals such as `1if`; the whitelist refuses them with a better message.
            warnings.simplefilter("ignore")
            return ast.parse(text.strip(), mode="eval").body
    except (RecursionError, MemoryError):
        raise ScenarioError(f"{_shown(text)} is nested too deeply; allowed are {MAX_DEPTH} levels") from None
    except (SyntaxError, ValueError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else str(error)
        raise ScenarioError(f"{_shown(text)} is no expression in t ({reason}); allowed: {ALLOWED}") from None


def _shown(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + "...")


class _Compiler:
    def __init__(self, text: str) -> None:
        self.text = text
        self.program: list[float | str] = []

    def compile(self, node: ast.expr, depth: int) -> bool:
        """Append the program of `node`; return whether it depends on t."""
        if depth > MAX_DEPTH:
            raise self._error(f"is nested too deeply; allowed are {MAX_DEPTH} levels")
        if len(self.program) >= MAX_NODES:
            raise self._error(f"has too many terms; allowed are {MAX_NODES} numbers, names and operations")
        match node:
            case ast.Constant():
                return self._number(node.value)
            case ast.Name():
                return self._name(node.id)
            case ast.UnaryOp() if type(node.op) in _UNARY_OPERATORS:
                moving = self.compile(node.operand, depth + 1)
                self.program.append(_UNARY_OPERATORS[type(node.op)])
                return moving
            case ast.BinOp() if type(node.op) in _BINARY_OPERATORS:
                return self._binary(node, depth)
            case ast.Call():
                return self._call(node, depth)
        raise self._error(f"uses {self._source(node)}, which is not allowed{_hint(node)}; allowed: {ALLOWED}")

    def _number(self, value: object) -> bool:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._error(f"contains {value!r}; allowed: {ALLOWED}")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self._error("contains a number that is too large for a float (1.8e308)")
        self.program.append(number)
        return False

    def _name(self, name: str) -> bool:
        if name == "t":
            self.program.append("t")
            return True
        if name in FUNCTIONS:
            raise self._error(f"uses {name} without an argument; write {name}(...)")
        if name not in CONSTANTS:
            raise self._unknown("name", name, ("t", *CONSTANTS, *FUNCTIONS))
        self.program.append(CONSTANTS[name])
        return False

    def _binary(self, node: ast.BinOp, depth: int) -> bool:
        left = self.compile(node.left, depth + 1)
        right = self.compile(node.right, depth + 1)
        operation = _BINARY_OPERATORS[type(node.op)]
        # A power with a fixed exponent is defined for negative bases and at zero; the general one is not.
        self.program.append("power_constant" if operation == "power" and not right else operation)
        return left or right

    def _call(self, node: ast.Call, depth: int) -> bool:
        if not isinstance(node.func, ast.Name):
            raise self._error(f"calls {self._source(node.func)}; allowed: {ALLOWED}")
        name = node.func.id
        if name not in FUNCTIONS:
            raise self._unknown("function", name, FUNCTIONS)
        if len(node.args) != 1 or node.keywords or isinstance(node.args[0], ast.Starred):
            raise self._error(f"calls {name} with {len(node.args) + len(node.keywords)} arguments; it takes one")
        moving = self.compile(node.args[0], depth + 1)
        self.program.append(name)
        return moving

    def _source(self, node: ast.expr) -> str:
        source = ast.get_source_segment(self.text.strip(), node)
        return _shown(source) if source else "something"

    def _unknown(self, kind: str, name: str, allowed: tuple[str, ...]) -> ScenarioError:
        return self._error(f"uses the unknown {kind} {name!r}{suggestion(name, allowed)}; allowed: {ALLOWED}")

    def _error(self, message: str) -> ScenarioError:
        return ScenarioError(f"{_shown(self.text)} {message}")


def _hint(node: ast.expr) -> str:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitXor):
        return " (a power is written **)"
    return ""
