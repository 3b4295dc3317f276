"""Configurations in which a goal is reached: damped least squares from many starts, always the same ones."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import inf

import numpy as np

from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.robot import FloatArray, Robot

Frames = Sequence[tuple[float, ...]]
Targets = Sequence[Sequence[float]]  # of the sub-goals

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
    targets = [sub_goal.motion.evaluate(np.zeros(1))[0][0].tolist() for sub_goal in goal]
    if any(sub_goal.beyond_reach(target) for sub_goal, target in zip(goal, targets, strict=True)):
        return []
    found: list[FloatArray] = []
    for guess in _guesses(robot, start_q):
        q = _solve(robot, goal, targets, guess)
        if q is not None and not any(_same(q.tolist(), other.tolist()) for other in found):
            found.append(q)
            if len(found) >= ENOUGH:
                break
    return found


def _same(q: Sequence[float], other: Sequence[float]) -> bool:
    return all(abs(one - two) <= _SAME for one, two in zip(q, other, strict=True))


def _guesses(robot: Robot, start_q: FloatArray) -> list[FloatArray]:
    """The start, then a fixed sequence, within limits; those of the same robot and start are made once."""
    key = (robot.joint_types, robot.limits.position.tobytes(), np.array(start_q, dtype=float).tobytes())
    return list(_guesses_within(*key))


@lru_cache(maxsize=8)
def _guesses_within(kinds: tuple[str, ...], limits: bytes, start: bytes) -> tuple[FloatArray, ...]:
    lower, upper = np.frombuffer(limits).reshape(-1, 2).T
    first = np.frombuffer(start)
    guesses = [first, *(_spread(kinds, lower, upper, first) if "revolute" in kinds else ())]
    clipped = tuple(np.clip(guess, lower, upper) for guess in guesses)
    for guess in clipped:
        guess.flags.writeable = False
    return clipped


def _spread(kinds: tuple[str, ...], lower: FloatArray, upper: FloatArray, start: FloatArray) -> list[FloatArray]:
    """Revolute joints anywhere within limits and ±pi, the others as at the start."""
    generator = np.random.Generator(np.random.PCG64(0))
    lower, upper = np.maximum(lower, -np.pi), np.minimum(upper, np.pi)
    spread = [lower + generator.random(len(kinds)) * (upper - lower) for _ in range(STARTS - 1)]
    fixed = [kind == "prismatic" for kind in kinds]
    for guess in spread:
        guess[fixed] = start[fixed]
    return spread


@lru_cache(maxsize=8)
def _steps(dof: int) -> tuple[FloatArray, FloatArray]:
    """Where a configuration (dof,) is looked at for its Jacobian (dof + 1, dof), and the damping (dof, dof)."""
    return np.vstack([np.zeros(dof), _FINITE_DIFFERENCE * np.eye(dof)]), _DAMPING * np.eye(dof)


def _solve(robot: Robot, goal: Sequence[SubGoal], targets: Targets, q: FloatArray) -> FloatArray | None:
    """Levenberg-Marquardt on the sub-goals' values, clipped to the limits (Nakamura and Hanafusa, 1986)."""
    lower, upper = robot.limits.position.T
    steps, damping = _steps(robot.dof)
    bounded = robot.joint_types[0] != "prismatic"
    for _ in range(ITERATIONS):
        around = q + steps
        frames = robot.frames_of(around)
        if _worst(goal, targets, q.tolist(), frames[0]) <= 0.0:
            return q
        rows = np.array([_residual(goal, targets, *near) for near in zip(around.tolist(), frames, strict=True)])
        residual = rows[0]
        jacobian = ((rows[1:] - residual) / _FINITE_DIFFERENCE).T
        square = jacobian.T @ jacobian + damping
        step = np.linalg.solve(square, -jacobian.T @ residual)
        if bounded:
            largest = float(np.abs(step).max())
            if largest > _MAX_STEP:
                step *= _MAX_STEP / largest
        q = np.minimum(np.maximum(q + step, lower), upper)
    # What is at the edge of the workspace may be within tolerance without being well within it.
    return q if _worst(goal, targets, q.tolist(), robot.frames_of(q[None])[0], share=1.0) <= 0.0 else None


def _residual(goal: Sequence[SubGoal], targets: Targets, q: Sequence[float], frames: Frames) -> list[float]:
    return [
        float(number)
        for sub_goal, target in zip(goal, targets, strict=True)
        for number in sub_goal.residual(sub_goal.value(q, frames), target)
    ]


def _worst(
    goal: Sequence[SubGoal],
    targets: Targets,
    q: Sequence[float],
    frames: Frames,
    share: float = 0.5,
) -> float:
    """Largest excess of a sub-goal's error over its share of the tolerance; not positive: reached."""
    worst = -inf
    for sub_goal, target in zip(goal, targets, strict=True):
        worst = max(worst, sub_goal.excess(sub_goal.value(q, frames), target, share))
    return worst
