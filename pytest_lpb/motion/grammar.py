"""The whitelist for expressions: Python's syntax tree, translated node by node and never evaluated as code."""

import ast
import keyword
import math
import warnings
from dataclasses import dataclass

from pytest_lpb.errors import ScenarioError
from pytest_lpb.names import suggestion

MAX_LENGTH = 500  # characters
MAX_NODES = 250
MAX_DEPTH = 60

CONSTANTS = {"pi": math.pi}

_BINARY_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "add",
    ast.Sub: "subtract",
    ast.Mult: "multiply",
    ast.Div: "divide",
    ast.Pow: "power",
}
_UNARY_OPERATORS: dict[type[ast.unaryop], str] = {ast.USub: "negative", ast.UAdd: "positive"}
_OPERATIONS = (*_BINARY_OPERATORS.values(), "power_constant", *_UNARY_OPERATORS.values())

Program = tuple[float | str, ...]


@dataclass(frozen=True)
class Grammar:
    """What expressions may use besides numbers, constants and operators.

    Attributes:
        variables: names of the variables.
        functions: names of the functions, each of one argument.

    Raises:
        ValueError: a variable that no expression can name, or a name that would mean two things in a program.
    """

    variables: tuple[str, ...]
    functions: tuple[str, ...]

    def __post_init__(self) -> None:
        for name in self.variables:
            if (
                not name.isidentifier()
                or keyword.iskeyword(name)
                or name in (*_OPERATIONS, *CONSTANTS, *self.functions)
            ):
                raise ValueError(f"{name!r} cannot name a variable of an expression")
        for name in self.functions:
            if name in (*_OPERATIONS, *CONSTANTS):
                raise ValueError(f"{name!r} cannot name a function of an expression")

    @property
    def kind(self) -> str:
        """What messages call its expressions, such as `expression in x and xdot`."""
        *others, last = self.variables or ("numbers",)
        return f"expression in {', '.join(others)} and {last}" if others else f"expression in {last}"

    @property
    def allowed(self) -> str:
        """What messages list as allowed."""
        names = ", ".join(("numbers", *self.variables, *CONSTANTS))
        return f"{names}, + - * / **, and the functions {' '.join(self.functions)}"


def compile_expression(text: str, grammar: Grammar) -> tuple[Program, bool]:
    """The postfix program of an expression, and whether it depends on a variable.

    Raises:
        ScenarioError: the text is no expression, too long or too deep, or uses something that is not allowed.
    """
    if len(text) > MAX_LENGTH:
        raise ScenarioError(f"an expression of {len(text)} characters; allowed are at most {MAX_LENGTH}")
    compiler = _Compiler(text, grammar)
    moving = compiler.compile(_parse(text, grammar), depth=1)
    return tuple(compiler.program), moving


def _parse(text: str, grammar: Grammar) -> ast.expr:
    try:
        with warnings.catch_warnings():
            # Python warns of literals such as `1if`; the whitelist refuses them with a better message.
            warnings.simplefilter("ignore")
            return ast.parse(text.strip(), mode="eval").body
    except (RecursionError, MemoryError):
        raise ScenarioError(f"{_shown(text)} is nested too deeply; allowed are {MAX_DEPTH} levels") from None
    except (SyntaxError, ValueError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else str(error)
        raise ScenarioError(f"{_shown(text)} is no {grammar.kind} ({reason}); allowed: {grammar.allowed}") from None


def _shown(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + "...")


class _Compiler:
    def __init__(self, text: str, grammar: Grammar) -> None:
        self.text = text
        self.grammar = grammar
        self.program: list[float | str] = []

    def compile(self, node: ast.expr, depth: int) -> bool:
        """Append the program of `node`; return whether it depends on a variable."""
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
        raise self._refused(f"uses {self._source(node)}, which is not allowed{_hint(node)}")

    def _number(self, value: object) -> bool:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._refused(f"contains {value!r}")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self._error("contains a number that is too large for a float (1.8e308)")
        self.program.append(number)
        return False

    def _name(self, name: str) -> bool:
        variables, functions = self.grammar.variables, self.grammar.functions
        if name in variables:
            self.program.append(name)
            return True
        if name in functions:
            raise self._error(f"uses {name} without an argument; write {name}(...)")
        if name not in CONSTANTS:
            raise self._unknown("name", name, (*variables, *CONSTANTS, *functions))
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
            raise self._refused(f"calls {self._source(node.func)}")
        name = node.func.id
        if name not in self.grammar.functions:
            raise self._unknown("function", name, self.grammar.functions)
        if len(node.args) != 1 or node.keywords or isinstance(node.args[0], ast.Starred):
            raise self._error(f"calls {name} with {len(node.args) + len(node.keywords)} arguments; it takes one")
        moving = self.compile(node.args[0], depth + 1)
        self.program.append(name)
        return moving

    def _source(self, node: ast.expr) -> str:
        source = ast.get_source_segment(self.text.strip(), node)
        return _shown(source) if source else "something"

    def _unknown(self, kind: str, name: str, allowed: tuple[str, ...]) -> ScenarioError:
        return self._refused(f"uses the unknown {kind} {name!r}{suggestion(name, allowed)}")

    def _refused(self, message: str) -> ScenarioError:
        return self._error(f"{message}; allowed: {self.grammar.allowed}")

    def _error(self, message: str) -> ScenarioError:
        return ScenarioError(f"{_shown(self.text)} {message}")


def _hint(node: ast.expr) -> str:
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitXor):
        return " (a power is written **)"
    return ""
