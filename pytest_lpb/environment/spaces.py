"""Gymnasium spaces of a problem's actions and observations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from gymnasium import spaces

from pytest_lpb.errors import LpbError
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray

ACTION_BOUND = 10.0  # of actions that the robot does not limit: [m/s, rad/s; m/s^2, rad/s^2; N, N m]


def action_limits(problem: Problem) -> FloatArray:
    """Lower and upper limits (n_actions, 2) of velocity, acceleration or effort, as the robot is controlled."""
    limits = problem.robot.limits
    return {"velocity": limits.velocity, "acceleration": limits.acceleration, "torque": limits.effort}[
        problem.robot.control
    ]


def bounds_of(bound: float | Sequence[float], count: int) -> FloatArray:
    """An `action_bound` as one number per action (count,). Raises LpbError."""
    try:
        bounds: FloatArray = np.broadcast_to(np.asarray(bound, dtype=float), (count,))
    except (TypeError, ValueError):
        bounds = np.zeros(1)
    if not (np.isfinite(bounds).all() and (bounds > 0.0).all()):
        raise LpbError(
            f"action_bound: found {bound!r}; allowed: a positive number, or a list of {count}: one per action"
        )
    return bounds


def action_space(problem: Problem, bounds: FloatArray) -> spaces.Box:
    """Finite Box of the actions within the robot's limits; where there is none, within ±bounds (n_actions,)."""
    limits = action_limits(problem)
    # A limit on one side only may lie beyond the bound: the Box keeps a width.
    lower = np.where(np.isfinite(limits[:, 0]), limits[:, 0], np.minimum(-bounds, limits[:, 1] - bounds))
    upper = np.where(np.isfinite(limits[:, 1]), limits[:, 1], np.maximum(bounds, limits[:, 0] + bounds))
    return spaces.Box(lower, upper, dtype=np.float64)


def observation_space(views: Mapping[str, FloatArray]) -> spaces.Dict:
    """Dict of unbounded boxes, one per array: states may leave the limits, which is a violation, not an error.

    Its order is that of the observation. From a dict gymnasium 1.4 would sort the keys, from pairs it does not: the
    spaces are equal, but flatten to different vectors.
    """
    return spaces.Dict([(name, spaces.Box(-np.inf, np.inf, view.shape, np.float64)) for name, view in views.items()])
