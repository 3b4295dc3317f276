"""What several KPIs compute from a trial, once per trial: positions, lengths, averages."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import wraps
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.trajectory import FloatArray, Trajectory

T = TypeVar("T")

# Beyond this a simulation has diverged; such rows count as NaN, since their fourth powers would overflow.
DIVERGED = 1e60


def once(function: Callable[[Trajectory], T]) -> Callable[[Trajectory], T]:
    """Compute a function of a trajectory at its first call and share the result; treat it as read-only."""

    @wraps(function)
    def shared(trajectory: Trajectory) -> T:
        if function not in trajectory.derived:
            trajectory.derived[function] = function(trajectory)
        result: T = trajectory.derived[function]
        return result

    return shared


def measured(values: NDArray[np.float64]) -> FloatArray:
    """The values with NaN for inf and for diverged ones."""
    return np.where(np.abs(values) < DIVERGED, values, np.nan)


@once
def positions(trajectory: Trajectory) -> FloatArray:
    """Positions p of the primary goal's link; for a joint goal of the last link, (N + 1, 3) [m]."""
    problem = trajectory.problem
    return measured(trajectory.link(problem.primary.link or problem.robot.link_names[-1]))


@once
def segment_lengths(trajectory: Trajectory) -> FloatArray:
    """Lengths of the steps of p, (N,) [m]."""
    return norms(np.diff(positions(trajectory), axis=0))


@once
def actions(trajectory: Trajectory) -> FloatArray:
    """The planner's actions in rows that have a finite one, (rows, n_actions)."""
    given = measured(trajectory.action)
    return given[np.isfinite(given).all(axis=1)]


def norms(vectors: FloatArray) -> FloatArray:
    """Euclidean norm of each row, (N, m) to (N,)."""
    lengths: FloatArray = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return lengths


def of_joint_type(trajectory: Trajectory, joint_type: str) -> NDArray[np.bool_]:
    """Which entries of q are `revolute` (rad) or `prismatic` (m), (dof,)."""
    return np.array([found == joint_type for found in trajectory.problem.robot.joint_types])


def smallest(values: FloatArray) -> float:
    """Minimum of the finite values; NaN without any."""
    finite = values[np.isfinite(values)]
    return float(finite.min()) if finite.size else math.nan


def time_average(values: FloatArray) -> float:
    """Average over time of equally spaced samples (trapezoidal rule), over steps whose two ends are finite.

    The mean of the rows would count both end rows in full and so change with the step.
    """
    middles = 0.5 * (values[1:] + values[:-1])
    finite = middles[np.isfinite(middles)]
    if finite.size:
        return float(finite.mean())
    return float(values[0]) if len(values) == 1 and np.isfinite(values[0]) else math.nan
