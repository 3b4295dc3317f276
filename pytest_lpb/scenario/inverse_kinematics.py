"""Configurations in which a goal is reached: damped least squares from many starts, always the same ones."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np

from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.robot import FloatArray, Robot

Frames = Sequence[tuple[float, ...]]

STARTS = 24  # initial guesses: the problem's own start first
ITERATIONS = 60
ENOUGH = 8  # distinct configurations, after which the search ends
_FINITE_DIFFERENCE = 1e-6  # [rad or m]
_MAX_STEP = 0.5  # [rad or m] per iteration
_DAMPING = 1e-3
_SAME = 0.1  # configurations nearer than this count as one [rad or m]


def goal_configurations(robot: Robot, goal: Sequence[SubGoal], start_q: FloatArray) -> list[FloatArray]:
    """Joint positions within limits at which all sub-goals are within tolerance at t = 0; empty: none found.

    Points have one guess only, their goals being positions they can take directly.
    """
    limits = robot.limits.position
    targets = [sub_goal.motion.evaluate(np.zeros(1))[0][0] for sub_goal in goal]
    if any(sub_goal.beyond_reach(target) for sub_goal, target in zip(goal, targets, strict=True)):
        return []
    found: list[FloatArray] = []
    for guess in _guesses(robot, start_q):
        q = _solve(robot, goal, targets, np.clip(guess, limits[:, 0], limits[:, 1]))
        if q is not None and all(np.max(np.abs(q - other)) > _SAME for other in found):
            found.append(q)
            if len(found) >= ENOUGH:
                break
    return found


def _guesses(robot: Robot, start_q: FloatArray) -> list[FloatArray]:
    """The start, then a fixed sequence within limits (revolute joints within ±pi)."""
    if "revolute" not in robot.joint_types:
        return [np.array(start_q, dtype=float)]
    generator = np.random.Generator(np.random.PCG64(0))
    limits = robot.limits.position
    lower = np.maximum(limits[:, 0], -np.pi)
    upper = np.minimum(limits[:, 1], np.pi)
    spread = [lower + generator.random(robot.dof) * (upper - lower) for _ in range(STARTS - 1)]
    for guess in spread:
        guess[[kind == "prismatic" for kind in robot.joint_types]] = start_q[
            [kind == "prismatic" for kind in robot.joint_types]
        ]
    return [np.array(start_q, dtype=float), *spread]


def _solve(robot: Robot, goal: Sequence[SubGoal], targets: Sequence[FloatArray], q: FloatArray) -> FloatArray | None:
    """Levenberg-Marquardt on the sub-goals' values, clipped to the limits (Nakamura and Hanafusa, 1986)."""
    limits = robot.limits.position
    steps = np.vstack([np.zeros(robot.dof), _FINITE_DIFFERENCE * np.eye(robot.dof)])
    for _ in range(ITERATIONS):
        around = q + steps
        frames = robot.frames_of(around)
        if _worst(goal, targets, q, frames[0]) <= 0.0:
            return q
        rows = [_residual(goal, targets, near, at) for near, at in zip(around, frames, strict=True)]
        residual = rows[0]
        jacobian = np.array([(row - residual) / _FINITE_DIFFERENCE for row in rows[1:]]).T
        square = jacobian.T @ jacobian + _DAMPING * np.eye(robot.dof)
        step = np.linalg.solve(square, -jacobian.T @ residual)
        largest = float(np.max(np.abs(step)))
        unbounded = robot.joint_types[0] == "prismatic"
        if largest > _MAX_STEP and not unbounded:
            step *= _MAX_STEP / largest
        q = np.clip(q + step, limits[:, 0], limits[:, 1])
    # What is at the edge of the workspace may be within tolerance without being well within it.
    return q if _worst(goal, targets, q, robot.frames_of(q[None])[0], share=1.0) <= 0.0 else None


def _residual(goal: Sequence[SubGoal], targets: Sequence[FloatArray], q: FloatArray, frames: Frames) -> FloatArray:
    values = q.tolist()
    parts = [
        sub_goal.residual(sub_goal.value(values, frames), target.tolist())
        for sub_goal, target in zip(goal, targets, strict=True)
    ]
    return np.array([float(number) for part in parts for number in part])


def _worst(
    goal: Sequence[SubGoal],
    targets: Sequence[FloatArray],
    q: FloatArray,
    frames: Frames,
    share: float = 0.5,
) -> float:
    """Largest excess of a sub-goal's error over its share of the tolerance; not positive: reached."""
    worst = -inf
    for sub_goal, target in zip(goal, targets, strict=True):
        error = sub_goal.distance(sub_goal.value(q.tolist(), frames), target.tolist())
        worst = max(worst, error - share * (sub_goal.tolerance or 0.0))
    return worst
