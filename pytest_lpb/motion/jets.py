"""Second-order Taylor arithmetic: functions of t carried with their exact first and second derivatives.

Forward-mode differentiation as in Griewank and Walther, Evaluating Derivatives, chapter 13.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Jet(NamedTuple):
    """Value, d/dt and d2/dt2 of a function of t, each (N,), or () where it does not depend on t."""

    value: FloatArray
    first: FloatArray
    second: FloatArray


ZERO = np.zeros(())
ONE = np.ones(())


def constant(value: float) -> Jet:
    """The jet of a number."""
    return Jet(np.asarray(value, dtype=np.float64), ZERO, ZERO)


def variable(t: FloatArray) -> Jet:
    """The jet of t itself, t (N,) [s]."""
    return Jet(t, ONE, ZERO)


def _product(derivative: FloatArray, rate: FloatArray) -> FloatArray:
    # A term without inner rate vanishes even where the outer derivative is infinite: sqrt(0) is a constant.
    return np.where(rate == 0.0, 0.0, derivative * rate)


def _chain(value: FloatArray, outer_first: FloatArray, outer_second: FloatArray, inner: Jet) -> Jet:
    return Jet(
        value,
        _product(outer_first, inner.first),
        _product(outer_second, inner.first**2) + _product(outer_first, inner.second),
    )


def negative(a: Jet) -> Jet:
    """-a."""
    return Jet(-a.value, -a.first, -a.second)


def positive(a: Jet) -> Jet:
    """+a."""
    return a


def add(a: Jet, b: Jet) -> Jet:
    """a + b."""
    return Jet(a.value + b.value, a.first + b.first, a.second + b.second)


def subtract(a: Jet, b: Jet) -> Jet:
    """a - b."""
    return add(a, negative(b))


def multiply(a: Jet, b: Jet) -> Jet:
    """a * b."""
    return Jet(
        a.value * b.value,
        a.first * b.value + a.value * b.first,
        a.second * b.value + 2.0 * a.first * b.first + a.value * b.second,
    )


def divide(a: Jet, b: Jet) -> Jet:
    """a / b; not finite where b is zero."""
    value = a.value / b.value
    first = (a.first - value * b.first) / b.value
    return Jet(value, first, (a.second - 2.0 * first * b.first - value * b.second) / b.value)


def _coefficient_times_power(coefficient: FloatArray, base: FloatArray, exponent: FloatArray) -> FloatArray:
    # d2/dx2 of x**1 is 0 everywhere, at x = 0 too, where x**-1 is infinite.
    return np.where(coefficient == 0.0, 0.0, coefficient * np.power(base, exponent))


def power_constant(a: Jet, b: Jet) -> Jet:
    """a ** b for a b that does not depend on t; any real a for whole b, a >= 0 otherwise."""
    n = b.value
    return _chain(
        np.power(a.value, n),
        _coefficient_times_power(n, a.value, n - 1.0),
        _coefficient_times_power(n * (n - 1.0), a.value, n - 2.0),
        a,
    )


def power(a: Jet, b: Jet) -> Jet:
    """a ** b = exp(b log(a)) for a b that depends on t; NaN where a <= 0."""
    logarithm = _chain(np.log(a.value), 1.0 / a.value, -1.0 / a.value**2, a)
    return exp(multiply(b, logarithm))


def sin(a: Jet) -> Jet:
    """The sine of a [rad]."""
    sine = np.sin(a.value)
    return _chain(sine, np.cos(a.value), -sine, a)


def cos(a: Jet) -> Jet:
    """The cosine of a [rad]."""
    cosine = np.cos(a.value)
    return _chain(cosine, -np.sin(a.value), -cosine, a)


def tan(a: Jet) -> Jet:
    """The tangent of a [rad]."""
    tangent = np.tan(a.value)
    slope = 1.0 + tangent**2
    return _chain(tangent, slope, 2.0 * tangent * slope, a)


def exp(a: Jet) -> Jet:
    """e ** a."""
    value = np.exp(a.value)
    return _chain(value, value, value, a)


def sqrt(a: Jet) -> Jet:
    """The square root of a; its derivatives are infinite where a is zero and moves."""
    root = np.sqrt(a.value)
    return _chain(root, 0.5 / root, -0.25 / root**3, a)


def absolute(a: Jet) -> Jet:
    """|a|; at a kink (a = 0 while a moves) both derivatives are the mean of the two sides, zero."""
    touching = (a.value == 0.0) & (a.first == 0.0)
    sign = np.where(touching, np.sign(a.second), np.sign(a.value))
    return Jet(np.abs(a.value), sign * a.first, sign * a.second)


UNARY: dict[str, Callable[[Jet], Jet]] = {
    "negative": negative,
    "positive": positive,
    "sin": sin,
    "cos": cos,
    "tan": tan,
    "exp": exp,
    "sqrt": sqrt,
    "abs": absolute,
}
BINARY: dict[str, Callable[[Jet, Jet], Jet]] = {
    "add": add,
    "subtract": subtract,
    "multiply": multiply,
    "divide": divide,
    "power": power,
    "power_constant": power_constant,
}
