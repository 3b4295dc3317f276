"""Where goals and obstacles of an experiment are, and how they move."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion import ExpressionMotion
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.scenario.import_lpb.fields import Fields

SPLINE_ROWS = (31, 61, 121, 241)  # a spline is given by so many points on it that the rest is within
CLOSE_M = 1e-4
MAX_POINTS = 1_000
_PREFIX = re.compile(r"\b(?:ca|casadi|np|numpy|math|sp|sympy)\.(?=[A-Za-z])")


class LostError(Exception):
    """Something that has no place in a scenario file: what and why, for the importer's list."""


def motion_of(fields: Fields, key: str, target: str, offset: FloatArray, size: int) -> tuple[dict[str, Any], list[str]]:
    """How a scenario file says where something is, and notes on what differs.

    Args:
        fields: has `trajectory`, or a place below `key`.
        key: of the place, which older files use for a motion, too.
        target: key in the scenario file for a place that stands still.
        offset: (size,) to add [m or rad].
        size: number of coordinates.

    Raises:
        LostError: there is no place, or a motion that cannot be written.
        LpbError: a place that is none.
    """
    where = "trajectory" if "trajectory" in fields else key
    given = fields.get(where)
    if isinstance(given, Mapping):
        inner = fields.below(where)
        expressions = inner.first("trajFun", "trajectory")
        if expressions not in inner:
            return _spline(inner, offset, size)
        where, given, fields = expressions, inner.get(expressions), inner
    if given is None:
        raise LostError(f"{fields.name}, which has neither a place nor a trajectory")
    if isinstance(given, list) and any(isinstance(part, str) for part in given):
        return _expressions(fields, where, given, offset, size)
    values = fields.numbers(where, size)
    return {target: (np.array(values) + offset).tolist()}, []


def _expressions(
    fields: Fields, key: str, given: list[Any], offset: FloatArray, size: int
) -> tuple[dict[str, Any], list[str]]:
    """Expressions in t, whose functions may be CasADi's, NumPy's or SymPy's."""
    if len(given) != size:
        raise fields.error(f"found {len(given)} expressions; {size} are required", key)
    texts = [_PREFIX.sub("", str(text)) for text in given]
    texts = [f"({text}) + {shift!r}" if shift else text for text, shift in zip(texts, offset.tolist(), strict=True)]
    try:
        ExpressionMotion(texts)
    except ScenarioError as error:
        raise LostError(f"{fields.name}, whose {key} cannot be read: {error}") from None
    return {"trajectory": texts}, []


def _spline(fields: Fields, offset: FloatArray, size: int) -> tuple[dict[str, Any], list[str]]:
    """A clamped B-spline C on [0, 1], run through at C((1 - cos(pi t / T)) / 2) for T seconds, by points on it."""
    degree, duration = fields.integer("degree"), fields.number("duration")
    key = fields.first("controlPoints", "ctrlpts")
    rows = fields.needed(key)
    if not isinstance(rows, list) or not 2 <= len(rows) <= MAX_POINTS:
        raise fields.error(f"2 to {MAX_POINTS} control points are required", key)
    points = np.array([fields.checked_numbers(row, (key, index), size) for index, row in enumerate(rows)])
    if not 1 <= degree < len(points):
        raise fields.error(f"found {degree}; allowed: 1 to {len(points) - 1} with {len(points)} points", "degree")
    if duration <= 0.0:
        raise fields.error(f"found {duration:g}; a duration above 0 s is required", "duration")
    curve = _curve(points, degree)
    for count in SPLINE_ROWS:
        shares = np.linspace(0.0, 1.0, count)
        table: list[list[float]] = np.round(np.column_stack([shares * duration, curve(shares) + offset]), 9).tolist()
        difference = _difference(table, curve, duration, offset)
        if difference <= CLOSE_M:
            break
    note = f"{fields.name}: the spline's own form; {count} points on it are given, within {difference:.1g} of it"
    return {"spline": table}, [note]


def _curve(points: FloatArray, degree: int) -> Any:
    """Positions of the spline at shares s (m,) of its duration: (m, size)."""
    from scipy.interpolate import BSpline  # late: only files with splines need it

    inner = np.linspace(0.0, 1.0, len(points) - degree + 1)
    curve = BSpline(np.concatenate([[0.0] * degree, inner, [1.0] * degree]), points, degree)
    return lambda s: curve(0.5 * (1.0 - np.cos(np.pi * s)))


def _difference(table: list[list[float]], curve: Any, duration: float, offset: FloatArray) -> float:
    """The largest distance between the spline of the scenario file and the original's."""
    from pytest_lpb.motion.spline import SplineMotion

    shares = np.linspace(0.0, 1.0, 20 * len(table))
    ours = SplineMotion(table).evaluate(shares * duration)[0]
    return float(np.linalg.norm(ours - curve(shares) - offset, axis=1).max())
