"""Interval arithmetic: between which values an expression in t and its rate of change lie over spans of time.

An interval encloses every value that an expression takes for any t of its span; so does the one beside it for the
first derivative (Moore, Kearfott and Cloud, Introduction to Interval Analysis, 2009, chapters 5 and 6). Both may be
wider than they need to be, the more so the longer the span; where a function has a pole they are infinite.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.motion.grammar import Program
from pytest_lpb.motion.jets import FloatArray

Mask = NDArray[np.bool_]

WIDENED = 1e-12  # share by which ends of intervals are moved outwards once, at the end, for rounding


class Interval(NamedTuple):
    """Lower and upper ends, each (N,), or () where they do not depend on t."""

    low: FloatArray
    high: FloatArray


class Rated(NamedTuple):
    """Enclosures of a function of t and of its first derivative."""

    value: Interval
    rate: Interval


ZERO = Interval(np.zeros(()), np.zeros(()))
ONE = Interval(np.ones(()), np.ones(()))
EVERYTHING = Interval(np.full((), -np.inf), np.full((), np.inf))


def speed_bounds(program: Program, start: FloatArray, end: FloatArray) -> FloatArray:
    """Bounds of |d/dt| of an expression's program over spans [start, end], each (N,) [s]; inf where there is none."""
    stack: list[Rated] = []
    with np.errstate(all="ignore"):
        for step in program:
            stack.append(_apply(step, stack, start, end))
        low, high = stack.pop().rate
        bound = np.maximum(np.abs(low), np.abs(high)) * (1.0 + WIDENED)
    return np.broadcast_to(np.where(np.isnan(bound), np.inf, bound), start.shape).astype(np.float64)


def _apply(step: float | str, stack: list[Rated], start: FloatArray, end: FloatArray) -> Rated:
    if isinstance(step, float):
        number = np.asarray(step, dtype=np.float64)
        return Rated(Interval(number, number), ZERO)
    if step == "t":
        return Rated(Interval(start, end), ONE)
    if step in _UNARY:
        return _UNARY[step](stack.pop())
    right = stack.pop()
    return _BINARY[step](stack.pop(), right)


def _sum(a: Interval, b: Interval) -> Interval:
    return Interval(a.low + b.low, a.high + b.high)


def _minus(a: Interval) -> Interval:
    return Interval(-a.high, -a.low)


def _times(a: Interval, b: Interval) -> Interval:
    corners = [_zero_wins(x, y) for x in a for y in b]
    return Interval(np.minimum.reduce(corners), np.maximum.reduce(corners))


def _zero_wins(x: FloatArray, y: FloatArray) -> FloatArray:
    """x y, where 0 inf is 0: a factor that is zero throughout makes the product zero whatever bounds the other."""
    return np.where((x == 0.0) | (y == 0.0), 0.0, x * y)


def _inverse(a: Interval) -> Interval:
    """1 / a; everything where a holds zero."""
    holds_zero = (a.low <= 0.0) & (a.high >= 0.0)
    return _where(holds_zero, EVERYTHING, Interval(1.0 / a.high, 1.0 / a.low))


def _where(condition: Mask, a: Interval, b: Interval) -> Interval:
    return Interval(np.where(condition, a.low, b.low), np.where(condition, a.high, b.high))


def _square(a: Interval) -> Interval:
    least = np.where((a.low <= 0.0) & (a.high >= 0.0), 0.0, np.minimum(np.abs(a.low), np.abs(a.high)))
    return Interval(least * least, np.maximum(np.abs(a.low), np.abs(a.high)) ** 2)


def _increasing(function: Callable[[FloatArray], FloatArray], a: Interval) -> Interval:
    return Interval(function(a.low), function(a.high))


def _sine(a: Interval) -> Interval:
    """Range of the sine: 1 where a holds a crest pi/2 + 2 pi k, -1 where it holds a trough."""

    def holds(phase: float) -> Mask:
        held: Mask = np.floor((a.high - phase) / (2.0 * np.pi)) >= np.ceil((a.low - phase) / (2.0 * np.pi))
        return held

    ends = np.sin(a.low), np.sin(a.high)
    low = np.where(holds(-0.5 * np.pi), -1.0, np.minimum(*ends))
    high = np.where(holds(0.5 * np.pi), 1.0, np.maximum(*ends))
    return _where(np.isfinite(a.low) & np.isfinite(a.high), Interval(low, high), Interval(-ONE.low, ONE.low))


def _cosine(a: Interval) -> Interval:
    quarter = np.asarray(0.5 * np.pi)
    return _sine(_sum(a, Interval(quarter, quarter)))


def _chain(value: Interval, slope: Interval, inner: Rated) -> Rated:
    return Rated(value, _times(slope, inner.rate))


def _negative(a: Rated) -> Rated:
    return Rated(_minus(a.value), _minus(a.rate))


def _positive(a: Rated) -> Rated:
    return a


def _sin(a: Rated) -> Rated:
    return _chain(_sine(a.value), _cosine(a.value), a)


def _cos(a: Rated) -> Rated:
    return _chain(_cosine(a.value), _minus(_sine(a.value)), a)


def _tan(a: Rated) -> Rated:
    """The tangent, whose slope is 1 / cos^2; everything where a pole lies within."""
    slope = _inverse(_square(_cosine(a.value)))
    pole = ~(np.isfinite(slope.low) & np.isfinite(slope.high))
    return _chain(_where(pole, EVERYTHING, _increasing(np.tan, a.value)), slope, a)


def _exp(a: Rated) -> Rated:
    value = _increasing(np.exp, a.value)
    return _chain(value, value, a)


def _sqrt(a: Rated) -> Rated:
    """The square root, whose slope has no bound where a can be zero."""
    root = _increasing(np.sqrt, Interval(np.maximum(a.value.low, 0.0), np.maximum(a.value.high, 0.0)))
    half = np.asarray(0.5)
    slope = _times(Interval(half, half), _inverse(root))
    return _chain(root, Interval(np.maximum(slope.low, 0.0), slope.high), a)


def _abs(a: Rated) -> Rated:
    value = _increasing(np.sqrt, _square(a.value))
    sign = Interval(np.where(a.value.low >= 0.0, 1.0, -1.0), np.where(a.value.high <= 0.0, -1.0, 1.0))
    return _chain(value, sign, a)


def _add(a: Rated, b: Rated) -> Rated:
    return Rated(_sum(a.value, b.value), _sum(a.rate, b.rate))


def _subtract(a: Rated, b: Rated) -> Rated:
    return _add(a, _negative(b))


def _multiply(a: Rated, b: Rated) -> Rated:
    return Rated(_times(a.value, b.value), _sum(_times(a.rate, b.value), _times(a.value, b.rate)))


def _divide(a: Rated, b: Rated) -> Rated:
    inverse = _inverse(b.value)
    slope = _minus(_square(inverse))
    return _multiply(a, Rated(inverse, _times(slope, b.rate)))


def _powers(a: Interval, n: FloatArray) -> Interval:
    """a ** n for a number n: whole powers of any a, others of a >= 0 (what lies below zero has no power)."""
    whole = n == np.round(n)
    even = whole & (np.mod(n, 2.0) == 0.0)
    base = _where(whole, a, Interval(np.maximum(a.low, 0.0), np.maximum(a.high, 0.0)))
    ends = np.power(base.low, n), np.power(base.high, n)
    holds_zero = (base.low <= 0.0) & (base.high >= 0.0)
    low = np.where(even & holds_zero & (n > 0.0), 0.0, np.minimum(*ends))
    return _where(holds_zero & (n < 0.0), EVERYTHING, Interval(low, np.maximum(*ends)))


def _power_constant(a: Rated, b: Rated) -> Rated:
    n = b.value.low
    slope = _times(Interval(n, n), _powers(a.value, n - 1.0))
    return _chain(_powers(a.value, n), slope, a)


def _power(a: Rated, b: Rated) -> Rated:
    """a ** b = exp(b log a); everything where a can be zero or less."""
    positive = a.value.low > 0.0
    logarithm = _where(positive, _increasing(np.log, a.value), EVERYTHING)
    return _exp(_multiply(b, _chain(logarithm, _where(positive, _inverse(a.value), EVERYTHING), a)))


_UNARY: dict[str, Callable[[Rated], Rated]] = {
    "negative": _negative,
    "positive": _positive,
    "sin": _sin,
    "cos": _cos,
    "tan": _tan,
    "exp": _exp,
    "sqrt": _sqrt,
    "abs": _abs,
}
_BINARY: dict[str, Callable[[Rated, Rated], Rated]] = {
    "add": _add,
    "subtract": _subtract,
    "multiply": _multiply,
    "divide": _divide,
    "power": _power,
    "power_constant": _power_constant,
}
