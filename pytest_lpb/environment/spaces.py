"""Gymnasium spaces of a problem's actions and observations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from gymnasium import spaces

from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray


def action_limits(problem: Problem) -> FloatArray:
    """Lower and upper limits (n_actions, 2) of velocity, acceleration or effort, as the robot is controlled."""
    limits = problem.robot.limits
    return {"velocity": limits.velocity, "acceleration": limits.acceleration, "torque": limits.effort}[
        problem.robot.control
    ]


def action_space(problem: Problem) -> spaces.Box:
    """Box of the actions within the robot's limits."""
    limits = action_limits(problem)
    return spaces.Box(limits[:, 0], limits[:, 1], dtype=np.float64)


def observation_space(views: Mapping[str, FloatArray]) -> spaces.Dict:
    """Dict of unbounded boxes, one per array: states may leave the limits, which is a violation, not an error."""
    return spaces.Dict({name: spaces.Box(-np.inf, np.inf, view.shape, np.float64) for name, view in views.items()})
