"""Expressions in t: what is refused, and derivatives held to finite differences."""

import math
import pickle
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion import parse_expression
from pytest_lpb.motion.jets import FloatArray

ALLOWED = "numbers, t, pi, + - * / **, and the functions sin cos tan exp sqrt abs"


@pytest.mark.parametrize(
    ("text", "function"),
    [
        ("0.5*sin(2*pi*t)", lambda t: 0.5 * np.sin(2 * np.pi * t)),
        ("-t**2", lambda t: -(t**2)),
        ("2**-t", lambda t: 2.0**-t),
        ("2**3**0.5", lambda t: np.full_like(t, 2 ** (3**0.5))),
        ("1e-3*t/4 - +3", lambda t: 1e-3 * t / 4 - 3),
        (
            "abs(cos(t)) + sqrt(t + 1) + tan(t/10) + exp(-t)",
            lambda t: np.abs(np.cos(t)) + np.sqrt(t + 1) + np.tan(t / 10) + np.exp(-t),
        ),
        ("(t + 1)**t", lambda t: (t + 1) ** t),
        ("(t - 5)**3", lambda t: (t - 5) ** 3),
        ("7", lambda t: np.full_like(t, 7.0)),
    ],
)
def test_values(text: str, function: Callable[[FloatArray], FloatArray]) -> None:
    t = np.linspace(0.0, 9.0, 50)
    assert_allclose(parse_expression(text).evaluate(t)[0], function(t), rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize(
    ("text", "at_zero"),
    [
        ("t**2", (0.0, 0.0, 2.0)),
        ("t**1", (0.0, 1.0, 0.0)),
        ("t**0", (1.0, 0.0, 0.0)),
        ("t**3", (0.0, 0.0, 0.0)),
        ("(-t)**2", (0.0, 0.0, 2.0)),
        ("t*t", (0.0, 0.0, 2.0)),
        ("abs(t)", (0.0, 0.0, 0.0)),
        ("abs(t**2)", (0.0, 0.0, 2.0)),
        ("abs(-t**2)", (0.0, 0.0, 2.0)),
        ("abs(t - 2)", (2.0, -1.0, 0.0)),
        ("sqrt(0)", (0.0, 0.0, 0.0)),
        ("sqrt(0*t)", (0.0, 0.0, 0.0)),
        ("sqrt(t)", (0.0, math.inf, -math.inf)),
        ("t**2.5", (0.0, 0.0, 0.0)),
        ("(1 + t)**(2*t)", (1.0, 0.0, 4.0)),
        ("0**2", (0.0, 0.0, 0.0)),
        ("exp(sin(t))", (1.0, 1.0, 1.0)),
    ],
)
def test_derivatives_at_zero(text: str, at_zero: tuple[float, float, float]) -> None:
    found = np.array(parse_expression(text).evaluate(np.zeros(1)))[:, 0]
    assert_allclose(found, at_zero, atol=1e-15)


def smooth(children: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Expressions that are smooth and of moderate size, of smaller ones."""
    return st.one_of(
        st.tuples(children, st.sampled_from(["+", "-", "*"]), children).map(lambda p: f"({p[0]} {p[1]} {p[2]})"),
        children.map(lambda a: f"sin({a})"),
        children.map(lambda a: f"cos({a})"),
        children.map(lambda a: f"exp(-({a})**2)"),
        children.map(lambda a: f"sqrt(1 + ({a})**2)"),
        children.map(lambda a: f"1/(2 + cos({a}))"),
        children.map(lambda a: f"tan(sin({a})/2)"),
        st.tuples(children, children).map(lambda p: f"(2 + sin({p[0]}))**cos({p[1]})"),
        st.tuples(children, st.integers(0, 3)).map(lambda p: f"sin({p[0]})**{p[1]}"),
    )


leaves = st.just("t") | st.floats(-2.0, 2.0).map(lambda number: f"{number:.2f}")
expressions = st.recursive(leaves, smooth, max_leaves=4).filter(lambda text: len(text) < 400)


@settings(deadline=None)
@given(expressions, st.floats(0.1, 3.0))
def test_derivatives_match_finite_differences(text: str, t: float) -> None:
    # Fourth-order central differences: truncation about h^4 times the fifth derivative.
    step = 1e-3  # [s]
    expression = parse_expression(text)
    around: FloatArray = t + step * np.arange(-2.0, 3.0)
    value, first, second = expression.evaluate(around)
    weights = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12.0 * step)
    scale = 1e-4 * (1.0 + np.max(np.abs([value, first, second])) ** 4)
    assert abs(weights @ value - first[2]) < scale
    assert abs(weights @ first - second[2]) < scale


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("2t", f"'2t' is no expression in t (invalid decimal literal); allowed: {ALLOWED}"),
        ("", f"'' is no expression in t (invalid syntax); allowed: {ALLOWED}"),
        ("sin(t", f"'sin(t' is no expression in t ('(' was never closed); allowed: {ALLOWED}"),
        ("t^2", f"'t^2' uses 't^2', which is not allowed (a power is written **); allowed: {ALLOWED}"),
        ("sinn(t)", f"'sinn(t)' uses the unknown function 'sinn'; did you mean 'sin'?; allowed: {ALLOWED}"),
        ("x + 1", f"'x + 1' uses the unknown name 'x'; allowed: {ALLOWED}"),
        ("sin", "'sin' uses sin without an argument; write sin(...)"),
        ("sin(t, 1)", "'sin(t, 1)' calls sin with 2 arguments; it takes one"),
        ("sin()", "'sin()' calls sin with 0 arguments; it takes one"),
        ("t.real", f"'t.real' uses 't.real', which is not allowed; allowed: {ALLOWED}"),
        ("t if t else 1", f"'t if t else 1' uses 't if t else 1', which is not allowed; allowed: {ALLOWED}"),
        ("t % 2", f"'t % 2' uses 't % 2', which is not allowed; allowed: {ALLOWED}"),
        ("[t]", f"'[t]' uses '[t]', which is not allowed; allowed: {ALLOWED}"),
        ("True", f"'True' contains True; allowed: {ALLOWED}"),
        ("2j", f"'2j' contains 2j; allowed: {ALLOWED}"),
        ("1e999", "'1e999' contains a number that is too large for a float (1.8e308)"),
        (
            "__import__('os')",
            f"\"__import__('os')\" uses the unknown function '__import__'; allowed: {ALLOWED}",
        ),
        ("t" * 501, "an expression of 501 characters; allowed are at most 500"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        parse_expression(text)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    "text",
    [
        "-" * 499 + "t",
        "(" * 249 + "t" + ")" * 249,
        "+".join("t" * 200),
        "sin(" * 99 + "t" + ")" * 99,
        "2**" * 150 + "2",
    ],
)
def test_too_deep(text: str) -> None:
    with pytest.raises(ScenarioError, match=r"nested too deeply; allowed are 60 levels|too many nested"):
        parse_expression(text)


def test_too_many_terms() -> None:
    group = "(" + "+".join("t" * 55) + ")"
    assert parse_expression(f"{group}+{group}").moving
    with pytest.raises(ScenarioError, match="has too many terms; allowed are 250"):
        parse_expression("+".join([group] * 4))


def test_towers_of_powers_overflow_at_once() -> None:
    """With exact integers it would never end."""
    value, _, _ = parse_expression("9**9**9**9").evaluate(np.zeros(1))
    assert_array_equal(value, [np.inf])


def test_whether_it_moves() -> None:
    assert parse_expression("0*t").moving
    assert not parse_expression("sin(pi/2)**2").moving


def test_survives_pickling() -> None:
    expression = parse_expression("sin(t)**2")
    assert pickle.loads(pickle.dumps(expression)) == expression


@pytest.mark.parametrize(
    ("variables", "kind"),
    [
        (("x",), "expression in x"),
        (("x", "xdot"), "expression in x and xdot"),
        (("x", "y", "z"), "expression in x, y and z"),
        ((), "expression in numbers"),
    ],
)
def test_messages_name_the_variables(variables: tuple[str, ...], kind: str) -> None:
    allowed = ", ".join(("numbers", *variables, "pi", "+ - * / **", "and the functions sin log"))
    with pytest.raises(ScenarioError) as caught:
        parse_expression("2x", variables, ("sin", "log"))
    assert str(caught.value) == f"'2x' is no {kind} (invalid decimal literal); allowed: {allowed}"


def test_programs_in_other_variables() -> None:
    expression = parse_expression("-x**2 / log(xdot)", ("x", "xdot"), ("log",))
    assert expression.program == ("x", 2.0, "power_constant", "negative", "xdot", "log", "divide")
    assert expression.moving
    assert not parse_expression("log(2)", ("x",), ("log",)).moving
    assert parse_expression("2**xdot", ("x", "xdot")).program == (2.0, "xdot", "power")


@pytest.mark.parametrize("name", ["add", "power_constant", "negative", "sin", "pi", "lambda", "True", "", "x y", "2"])
def test_variables_that_programs_would_confuse(name: str) -> None:
    with pytest.raises(ValueError, match="cannot name a variable"):
        parse_expression("1", ("x", name))


def test_functions_that_programs_would_confuse() -> None:
    with pytest.raises(ValueError, match="'add' cannot name a function"):
        parse_expression("1", ("x",), ("sin", "add"))
