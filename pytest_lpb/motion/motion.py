"""How a target or an obstacle moves: position, velocity and acceleration at given times."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion.expressions import parse_expression
from pytest_lpb.motion.jets import FloatArray

MAX_CHECKED_TIMES = 10_000
MAX_COORDINATE = 1e6  # [m or rad]
MAX_RATE = 1e12  # [m/s, m/s^2, rad/s or rad/s^2]


class Motion(ABC):
    """A point in m dimensions that may move with time.

    Attributes:
        size: m.
        moving: whether the position changes with time.
    """

    size: int
    moving: bool

    @abstractmethod
    def evaluate(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Position, velocity and acceleration at the times t (N,) [s], each a new array (N, m)."""

    @abstractmethod
    def speed_bound(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Bounds of |dp/dt| over the spans [start, end] of time, each (N,) [s]: (N,); inf where there is none."""

    def check_finite(self, times: FloatArray) -> None:
        """Check that the motion stays finite and in bounds at `times` (N,) [s].

        Raises:
            ScenarioError: a position, velocity or acceleration is undefined, infinite or beyond all measure.
        """
        for values, what, bound in zip(
            self.evaluate(times),
            ("value", "velocity", "acceleration"),
            (MAX_COORDINATE, MAX_RATE, MAX_RATE),
            strict=True,
        ):
            wrong = np.argwhere(~(np.abs(values) <= bound))
            if wrong.size:
                row, column = wrong[0]
                raise ScenarioError(
                    f"{self.component_name(int(column))} has the {what} {values[row, column]:.6g} "
                    f"at t = {times[row]:.6g} s; allowed are finite numbers within ±{bound:g}"
                )

    def component_name(self, index: int) -> str:
        """How messages call one of the m components."""
        return f"component {index}"


class FixedMotion(Motion):
    """A point that stays where it is: position (m,)."""

    moving = False

    def __init__(self, position: Sequence[float] | FloatArray) -> None:
        self.position: FloatArray = np.array(position, dtype=np.float64)
        self.size = len(self.position)

    def evaluate(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The fixed position and zeros, see `Motion.evaluate`."""
        shape = (len(t), self.size)
        position = np.empty(shape)
        position[:] = self.position
        return position, np.zeros(shape), np.zeros(shape)

    def speed_bound(self, start: FloatArray, end: FloatArray) -> FloatArray:  # noqa: ARG002 - it stands
        """Zeros, see `Motion.speed_bound`."""
        return np.zeros(len(start))


class ExpressionMotion(Motion):
    """A motion whose m components are expressions in t.

    Raises:
        ScenarioError: an expression cannot be parsed.
    """

    def __init__(self, texts: Sequence[str]) -> None:
        self.expressions = tuple(parse_expression(text) for text in texts)
        self.size = len(self.expressions)
        self.moving = any(expression.moving for expression in self.expressions)

    def evaluate(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Exact derivatives of the expressions, see `Motion.evaluate`."""
        t = np.asarray(t, dtype=np.float64)
        result = np.empty((3, len(t), self.size))
        for column, expression in enumerate(self.expressions):
            result[:, :, column] = expression.evaluate(t)
        return result[0], result[1], result[2]

    def speed_bound(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """By interval arithmetic, see `Motion.speed_bound`."""
        rates = np.zeros((self.size, len(start)))
        for row, expression in enumerate(self.expressions):
            if expression.moving:
                rates[row] = expression.speed_bound(start, end)
        speed: FloatArray = np.sqrt((rates * rates).sum(axis=0))
        return speed

    def component_name(self, index: int) -> str:
        """The expression itself."""
        return repr(self.expressions[index].text)


def motion_from(entry: Mapping[str, Any], key: str) -> Motion:
    """The motion of a goal or obstacle as a scenario file writes it.

    Args:
        entry: holds exactly one of `key` (a list of numbers), `trajectory` (a list of expressions) and
            `spline` (rows of time and coordinates), with `periodic` beside a spline.
        key: name of the fixed form: `target` for goals, `position` for obstacles.

    Raises:
        ScenarioError: none or several of the forms are given, or the one given is wrong.
    """
    forms = (key, "trajectory", "spline")
    given = [form for form in forms if entry.get(form) is not None]
    if len(given) != 1:
        raise ScenarioError(f"found {' and '.join(given) or 'none'} of {', '.join(forms)}; exactly one is required")
    if given[0] == "trajectory":
        return ExpressionMotion(entry["trajectory"])
    if given[0] == "spline":
        # Imported late: splines need SciPy, which most scenarios do without.
        from pytest_lpb.motion.spline import SplineMotion

        return SplineMotion(entry["spline"], periodic=bool(entry.get("periodic")))
    return FixedMotion(entry[key])


def sampled_times(dt: float, steps: int) -> FloatArray:
    """Times k dt of the rows k = 0..steps, the last included, thinned to `MAX_CHECKED_TIMES` of them, [s]."""
    rows: FloatArray = np.linspace(0, steps, min(steps + 1, MAX_CHECKED_TIMES)).round()
    return rows * dt
