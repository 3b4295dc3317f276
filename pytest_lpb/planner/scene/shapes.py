"""Signed distances between parts of a robot and obstacles, as CasADi expressions; one entry per shape and kind of part.

All lengths in m. Kinks (edges of boxes, ends of segments) have one-sided derivatives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import casadi

from pytest_lpb.planner.base import ObstacleInfo

MESH = "mesh"
TINY = 1e-12  # [m] lengths of zero have no direction: keeps their derivatives finite


def length(vector: Any) -> Any:
    """Euclidean length of a column, differentiable everywhere."""
    return casadi.sqrt(casadi.sumsqr(vector) + TINY * TINY)


def _to_ball(local: Any, size: Any) -> Any:
    return length(local) - size[0]


def _to_box(local: Any, size: Any) -> Any:
    return _beyond(casadi.fabs(local) - 0.5 * size)


def _beyond(gap: Any) -> Any:
    """Distance to a box from what a point exceeds its half lengths by."""
    return length(casadi.fmax(gap, 0.0)) + casadi.fmin(casadi.mmax(gap), 0.0)


def _to_capsule(local: Any, size: Any) -> Any:
    half = 0.5 * size[1]
    along = local[2] - casadi.fmin(casadi.fmax(local[2], -half), half)
    return length(casadi.vertcat(local[0], local[1], along)) - size[0]


def _to_cylinder(local: Any, size: Any) -> Any:
    return _beyond(casadi.vertcat(length(local[:2]) - size[0], casadi.fabs(local[2]) - 0.5 * size[1]))


@dataclass(frozen=True)
class Shape:
    """A shape of obstacles.

    Attributes:
        sizes: numbers that describe an obstacle's size [m].
        count: how many these are.
        distance: signed distance [m] of a point in the obstacle's frame, by these numbers.
        inscribed: radius [m] of the largest ball in it.
        turns: whether its orientation matters.
    """

    sizes: Callable[[ObstacleInfo], tuple[float, ...]]
    count: int
    distance: Callable[[Any, Any], Any]
    inscribed: Callable[[Any], Any]
    turns: bool = True


def _full(obstacle: ObstacleInfo) -> tuple[float, ...]:
    return obstacle.size or ()


def _round(obstacle: ObstacleInfo) -> tuple[float, ...]:
    return (obstacle.radius or 0.0,)


def _long(obstacle: ObstacleInfo) -> tuple[float, ...]:
    return (obstacle.radius or 0.0, obstacle.length or 0.0)


_BALL = Shape(_round, 1, _to_ball, lambda size: size[0], turns=False)
SHAPES: Mapping[str, Shape] = {
    "circle": _BALL,
    "sphere": _BALL,
    "rectangle": Shape(_full, 2, _to_box, lambda size: 0.5 * casadi.mmin(size)),
    "box": Shape(_full, 3, _to_box, lambda size: 0.5 * casadi.mmin(size)),
    "capsule": Shape(_long, 2, _to_capsule, lambda size: size[0]),
    # Of a mesh the nearest point is found before each call.
    MESH: Shape(lambda obstacle: (), 0, lambda local, size: length(local), lambda size: 0.0, turns=False),  # noqa: ARG005
    "cylinder": Shape(_long, 2, _to_cylinder, lambda size: casadi.fmin(size[0], 0.5 * size[1])),
}
