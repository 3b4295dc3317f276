"""Distances between segments and points, and their derivatives in closed form; lengths in m.

The nearest points slide along the segments as these move. Their first derivatives do not feel it, since the distance is
least there; the second ones do: with E = |r|^2/2, r between the nearest points, and y the shares of the segments that
are free to slide, E'' = E_tt - E_ty E_yy^-1 E_yt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi

from pytest_lpb.planner.scene.maps import Mapped
from pytest_lpb.planner.scene.shapes import TINY, length

SLANTED = 1e-3  # squared sine of the least angle at which both nearest points slide
PARALLEL = 1e-9  # relative: segments nearer to parallel than this have any of their nearest points

Ends = Sequence[Any]  # both ends of a segment, or a point alone, each (d, 1)


def segment_distance(ends: Ends, others: Ends) -> Any:
    """Distance [m] between two segments, each given by its ends, or points, given alone."""
    return length(_nearest(ends, others).offset)


def segment_derivatives(ends: Ends, others: Ends, rates: Ends, other_rates: Ends) -> Mapped:
    """The distance [m] of two segments or points, differentiated by all their points, one below the other.

    Args:
        ends, others: the points.
        rates, other_rates: their velocities.
    """
    near = _nearest(ends, others)
    distance = length(near.offset)
    normal = near.offset / distance
    shares, other_shares = _shares(ends, near.s), _shares(others, near.t)
    gradient = [share * normal for share in shares] + [-share * normal for share in other_shares]
    rate = _mean(rates, shares) - _mean(other_rates, other_shares)  # of one nearest point from the other
    speed = casadi.dot(normal, rate)
    first, second = _along(ends), _along(others)
    slides = (
        casadi.dot(rate, first) + casadi.dot(near.offset, _along(rates)),
        -casadi.dot(rate, second) - casadi.dot(near.offset, _along(other_rates)),
    )
    bend = casadi.sumsqr(rate) - _slid(first, second, near, slides)
    return Mapped(
        distance,
        speed,
        casadi.vertcat(*gradient).T,
        (bend - speed * speed) / distance,
        casadi.SX.zeros(1, 1),
    )


@dataclass(frozen=True)
class _Near:
    """The nearest points: shares s and t of the segments, and the offset of the first one from the second."""

    s: Any
    t: Any
    offset: Any


def _nearest(ends: Ends, others: Ends) -> _Near:
    """Nearest points of two segments (Ericson, Real-Time Collision Detection, 2005, section 5.1.9)."""
    first, second, offset = _along(ends), _along(others), ends[0] - others[0]
    aa, bb, ab = casadi.sumsqr(first) + TINY, casadi.sumsqr(second) + TINY, casadi.dot(first, second)
    ac, bc = casadi.dot(first, offset), casadi.dot(second, offset)
    s = _clipped((ab * bc - ac * bb) / (aa * bb - ab * ab + PARALLEL * aa * bb))
    t = (ab * s + bc) / bb
    # Where the nearest point of the second line lies beyond its segment, the first one follows its end.
    s = casadi.if_else(t < 0.0, _clipped(-ac / aa), casadi.if_else(t > 1.0, _clipped((ab - ac) / aa), s))
    t = _clipped(t)
    return _Near(s, t, offset + s * first - t * second)


def _slid(first: Any, second: Any, near: _Near, slides: tuple[Any, Any]) -> Any:
    """E_ty E_yy^-1 E_yt, of the shares that are free: `slides` are E_ts and E_tt."""
    free, other_free = _free(near.s), _free(near.t)
    a = free * casadi.sumsqr(first) + (1.0 - free)
    b = -free * other_free * casadi.dot(first, second)
    c = other_free * casadi.sumsqr(second) + (1.0 - other_free)
    u, v = free * slides[0], other_free * slides[1]
    determinant = a * c - b * b
    both = (c * u * u - 2.0 * b * u * v + a * v * v) / (determinant + PARALLEL * a * c)
    # Nearly parallel segments have no one pair of nearest points that could slide: the second one's stays.
    return casadi.if_else(determinant > SLANTED * a * c, both, u * u / a)


def _along(ends: Ends) -> Any:
    """From the first end to the second; of a point alone nothing."""
    return ends[1] - ends[0] if len(ends) > 1 else casadi.SX(ends[0].numel(), 1)


def _shares(ends: Ends, share: Any) -> list[Any]:
    """How much of a nearest point each end is."""
    return [1.0 - share, share] if len(ends) > 1 else [1.0]


def _mean(points: Ends, shares: Sequence[Any]) -> Any:
    return sum(share * point for share, point in zip(shares, points, strict=True))


def _free(share: Any) -> Any:
    """1 where a nearest point lies between the ends, else 0."""
    return casadi.logic_and(share > 0.0, share < 1.0)


def _clipped(share: Any) -> Any:
    return casadi.fmin(casadi.fmax(share, 0.0), 1.0)
