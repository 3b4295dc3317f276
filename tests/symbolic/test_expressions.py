"""CasADi expressions from text: values as NumPy's, derivatives as those of finite differences and of jets."""

import subprocess
import sys
from collections.abc import Callable, Mapping
from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion import parse_expression
from pytest_lpb.motion.jets import FloatArray
from pytest_lpb.symbolic.expressions import FUNCTIONS, casadi_expression, check_expression

LEAF = ("x", "xdot")
ALLOWED = "numbers, x, xdot, pi, + - * / **, and the functions sin cos tan exp sqrt abs log tanh sign"
NUMPY: Mapping[str, Any] = {name: getattr(np, name) for name in FUNCTIONS}


def symbols(*names: str) -> dict[str, Any]:
    return {name: casadi.SX.sym(name) for name in names}


def with_derivatives(text: str, *names: str) -> Callable[..., tuple[float, FloatArray, FloatArray]]:
    """The function of the variables that gives value (), gradient (n,) and Hessian (n, n)."""
    variables = symbols(*names)
    expression = casadi_expression(text, variables)
    assert expression.shape == (1, 1)
    hessian, gradient = casadi.hessian(expression, casadi.vertcat(*variables.values()))
    function = casadi.Function("f", list(variables.values()), [expression, gradient, hessian])

    def evaluate(*point: float) -> tuple[float, FloatArray, FloatArray]:
        value, first, second = (np.array(part) for part in function(*point))
        return float(value[0, 0]), first[:, 0], second

    return evaluate


def by_numpy(text: str, **variables: float) -> float:
    """The value that NumPy gives; the text is one of this file's, so that evaluating it as code is safe here."""
    variables = {name: np.float64(value) for name, value in variables.items()}
    return float(eval(text, {"__builtins__": {}, "pi": np.pi, **NUMPY}, variables))


def smooth(children: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Expressions that are smooth and of moderate size, of smaller ones, with the functions of expressions in t."""
    return st.one_of(
        st.tuples(children, st.sampled_from(["+", "-", "*"]), children).map(lambda p: f"({p[0]} {p[1]} {p[2]})"),
        children.map(lambda a: f"-{a}**2"),
        children.map(lambda a: f"+sin({a})"),
        children.map(lambda a: f"cos({a})"),
        children.map(lambda a: f"exp(-({a})**2)"),
        children.map(lambda a: f"sqrt(1 + ({a})**2)"),
        children.map(lambda a: f"abs(-2 - sin({a}))"),
        children.map(lambda a: f"tan(sin({a})/2)"),
        st.tuples(children, children).map(lambda p: f"(2 + sin({p[0]}))**cos({p[1]})"),
        st.tuples(children, st.integers(0, 7)).map(lambda p: f"sin({p[0]})**{p[1]}"),
        st.tuples(children, st.integers(-5, -1)).map(lambda p: f"(cos({p[0]}) - pi)**{p[1]}"),
    )


def smooth_with_all_functions(children: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(
        smooth(children),
        children.map(lambda a: f"tanh({a})"),
        children.map(lambda a: f"log(2 + cos({a}))"),
    )


def rough(children: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(smooth_with_all_functions(children), children.map(lambda a: f"abs({a})"))


def expressions(
    leaves: st.SearchStrategy[str], extend: Callable[[st.SearchStrategy[str]], st.SearchStrategy[str]]
) -> st.SearchStrategy[str]:
    return st.recursive(leaves, extend, max_leaves=5).filter(lambda text: len(text) < 400)


numbers = st.floats(-2.0, 2.0).map(lambda number: f"({number:.2f})")
leaves = st.sampled_from(LEAF) | numbers
# Of leaves only: where its argument is 0 to rounding, the sign depends on the order of multiplication.
signs = st.tuples(leaves, leaves).map(lambda p: f"sign({p[0]} - {p[1]})")
coordinates = st.floats(-3.0, 3.0)


@settings(deadline=None)
@given(expressions(leaves | signs, rough), coordinates, coordinates)
def test_values(text: str, x: float, xdot: float) -> None:
    value, _, _ = with_derivatives(text, *LEAF)(x, xdot)
    assert_allclose(value, by_numpy(text, x=x, xdot=xdot), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    "text",
    [
        "-0.5 * (1 - sign(xdot))/2 * xdot**2 / x**5",
        "0.5/(x**1) * (-0.5 * (sign(xdot) - 1)) * xdot**2",
        "-1/(x**1) * xdot**2",
        "5 * (x + 1/10 * log(1 + exp(-2*10*x)))",
        "((2.0 - 0.3) * exp(-1*(0.75*x)**2) + 0.3) * xdot**2",
        "x**-xdot",
        "2**3**0.5 - -x",
        "x / xdot / 2",
        "x - xdot - 2",
        "pi",
    ],
)
@pytest.mark.parametrize("point", [(0.3, 0.7), (0.3, -0.7), (2.5, -1.5)])
def test_values_of_leaves(text: str, point: tuple[float, float]) -> None:
    value, _, _ = with_derivatives(text, *LEAF)(*point)
    assert_allclose(value, by_numpy(text, x=point[0], xdot=point[1]), rtol=1e-13)


@settings(deadline=None)
@given(expressions(st.just("t") | numbers, smooth), coordinates)
def test_derivatives_are_those_of_jets(text: str, t: float) -> None:
    value, first, second = with_derivatives(text, "t")(t)
    jet = [part[0] for part in parse_expression(text).evaluate(np.array([t]))]
    assert_allclose([value, first[0], second[0, 0]], jet, rtol=1e-8, atol=1e-8)


@settings(deadline=None)
@given(expressions(leaves, smooth_with_all_functions), coordinates, coordinates)
def test_derivatives_match_finite_differences(text: str, x: float, xdot: float) -> None:
    # Fourth-order central differences: truncation about h^4 times the fifth derivative.
    step = 1e-3
    evaluate = with_derivatives(text, *LEAF)
    _, gradient, hessian = evaluate(x, xdot)
    for axis, direction in enumerate(step * np.eye(2)):
        around = [evaluate(*((x, xdot) + k * direction)) for k in (-2.0, -1.0, 1.0, 2.0)]
        weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * step)
        values, gradients = np.array([at[0] for at in around]), np.array([at[1] for at in around])
        scale = 1e-4 * (1.0 + np.abs(values).max() + np.abs(gradients).max() + np.abs(hessian).max()) ** 4
        assert abs(weights @ values - gradient[axis]) < scale
        assert_allclose(weights @ gradients, hessian[axis], rtol=0.0, atol=scale)


@pytest.mark.parametrize("exponent", ["2", "3", "5", "(7 - 1)", "99", "101", "150.0"])
def test_whole_powers_of_zero_and_of_negative_numbers(exponent: str) -> None:
    evaluate, n = with_derivatives(f"x**{exponent}", "x"), eval(exponent)
    value, first, second = evaluate(0.0)
    assert (value, first[0], second[0, 0]) == (0.0, 0.0, 2.0 if n == 2 else 0.0)
    value, first, second = evaluate(-1.25)
    expected = [(-1.25) ** n, n * (-1.25) ** (n - 1), n * (n - 1) * (-1.25) ** (n - 2)]
    assert_allclose([value, first[0], second[0, 0]], expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("text", "at_zero"),
    [
        ("x**0", (1.0, 0.0, 0.0)),
        ("x**1", (0.0, 1.0, 0.0)),
        ("x**2.5", (0.0, 0.0, 0.0)),
        ("abs(x)", (0.0, 0.0, 0.0)),
        ("sign(x)", (0.0, 0.0, 0.0)),
        ("0", (0.0, 0.0, 0.0)),
    ],
)
def test_derivatives_at_zero(text: str, at_zero: tuple[float, float, float]) -> None:
    value, first, second = with_derivatives(text, "x")(0.0)
    assert (value, first[0], second[0, 0]) == at_zero


@pytest.mark.parametrize("xdot", [-2.0, 0.0, 3.0])
def test_the_derivative_of_sign_is_zero(xdot: float) -> None:
    value, gradient, hessian = with_derivatives("x * sign(xdot)", *LEAF)(5.0, xdot)
    sign = np.sign(xdot)
    assert value == 5.0 * sign
    assert gradient.tolist() == [sign, 0.0]
    assert not hessian.any()


@pytest.mark.parametrize("text", ["1/0", "(-8)**(1/3)", "9**9**9**9", "log(-1)", "0**-1"])
def test_undefined_numbers_are_not_finite(text: str) -> None:
    assert not np.isfinite(float(casadi_expression(text, {})))


def test_symbols_may_be_any_expressions() -> None:
    q = casadi.SX.sym("q", 2)
    function = casadi.Function("f", [q], [casadi_expression("x**2 + y", {"x": q[0] - 1, "y": 3 * q[1]})])
    assert function([4.0, 2.0]) == 15.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("xdott**2", f"'xdott**2' uses the unknown name 'xdott'; did you mean 'xdot'?; allowed: {ALLOWED}"),
        ("x + t", f"'x + t' uses the unknown name 't'; allowed: {ALLOWED}"),
        ("sgn(x)", f"'sgn(x)' uses the unknown function 'sgn'; did you mean 'sign' or 'sin'?; allowed: {ALLOWED}"),
        ("SX(x)", f"'SX(x)' uses the unknown function 'SX'; allowed: {ALLOWED}"),
        ("add(x)", f"'add(x)' uses the unknown function 'add'; allowed: {ALLOWED}"),
        ("x(xdot)", f"'x(xdot)' uses the unknown function 'x'; allowed: {ALLOWED}"),
        ("sign", "'sign' uses sign without an argument; write sign(...)"),
        ("x.shape", f"'x.shape' uses 'x.shape', which is not allowed; allowed: {ALLOWED}"),
        ("x.printme(x)", f"'x.printme(x)' calls 'x.printme'; allowed: {ALLOWED}"),
        ("x[0]", f"'x[0]' uses 'x[0]', which is not allowed; allowed: {ALLOWED}"),
        ("[x for x in x]", f"'[x for x in x]' uses '[x for x in x]', which is not allowed; allowed: {ALLOWED}"),
        ("lambda: x", f"'lambda: x' uses 'lambda: x', which is not allowed; allowed: {ALLOWED}"),
        ("(x := 2)", f"'(x := 2)' uses 'x := 2', which is not allowed; allowed: {ALLOWED}"),
        ("x if x else 1", f"'x if x else 1' uses 'x if x else 1', which is not allowed; allowed: {ALLOWED}"),
        ("x < 1", f"'x < 1' uses 'x < 1', which is not allowed; allowed: {ALLOWED}"),
        ("'x'", f"\"'x'\" contains 'x'; allowed: {ALLOWED}"),
        ("__import__('os')", f"\"__import__('os')\" uses the unknown function '__import__'; allowed: {ALLOWED}"),
        ("x +", f"'x +' is no expression in x and xdot (invalid syntax); allowed: {ALLOWED}"),
        ("x" * 501, "an expression of 501 characters; allowed are at most 500"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        casadi_expression(text, symbols(*LEAF))
    assert str(caught.value) == message
    with pytest.raises(ValueError) as refused:  # noqa: PT011 - the message is compared below
        check_expression(text, LEAF)
    assert str(refused.value) == message


@pytest.mark.parametrize("text", ["-" * 499 + "x", "sin(" * 99 + "x" + ")" * 99, "+".join("x" * 200)])
def test_too_deep(text: str) -> None:
    with pytest.raises(ScenarioError, match=r"nested too deeply; allowed are 60 levels|too many nested"):
        casadi_expression(text, symbols("x"))


def test_a_variable_that_is_not_among_the_symbols() -> None:
    with pytest.raises(ScenarioError, match="uses the unknown name 'xdot'; allowed: numbers, x, pi, "):
        casadi_expression("x * xdot", symbols("x"))


def test_check_gives_the_text() -> None:
    assert check_expression(" x*xdot ", LEAF) == " x*xdot "


def test_checking_needs_no_casadi() -> None:
    program = (
        "import sys; sys.modules['casadi'] = None;"
        "from pytest_lpb.symbolic.expressions import check_expression; check_expression('sign(x)', ('x',))"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
