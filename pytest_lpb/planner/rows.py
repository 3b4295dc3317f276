"""What the rows of a task are made from, in the plane and in space alike."""

from __future__ import annotations

from collections.abc import Callable
from math import pi, remainder

import numpy as np

from pytest_lpb.planner.base import FloatArray, GoalInfo
from pytest_lpb.problem.robot import Robot

# (target, robot, sub-goal, q) -> error (m,), Jacobian (m, dof) of the value whose error it is
Row = Callable[[FloatArray, Robot, GoalInfo, FloatArray], tuple[FloatArray, FloatArray]]


def joint_row(target: FloatArray, robot: Robot, goal: GoalInfo, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Of a sub-goal in joint space; headings of bases are wrapped."""
    indices = [robot.joint_names.index(name) for name in goal.entry["joints"]]
    error = target - q[indices]
    for place, index in enumerate(indices):
        if index in robot.headings:
            error[place] = remainder(error[place], 2.0 * pi)
    return error, np.eye(robot.dof)[indices]
