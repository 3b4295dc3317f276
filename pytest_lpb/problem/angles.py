"""Differences of angles, wrapped."""

from __future__ import annotations

from math import pi, remainder


def angle_error(value: float, target: float) -> float:
    """Absolute difference of two angles [rad], wrapped to [0, pi]."""
    return abs(remainder(value - target, 2.0 * pi))


def wrapped(angle: float) -> float:
    """An angle [rad] in [-pi, pi)."""
    return (angle + pi) % (2.0 * pi) - pi
