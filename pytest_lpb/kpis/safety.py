"""KPIs about safety: distances to obstacles, to itself and to joint limits, and time to collision."""

from __future__ import annotations

import math

import numpy as np

from pytest_lpb.kpis.derived import measured, norms, of_joint_type, once, smallest, time_average
from pytest_lpb.kpis.registry import kpi
from pytest_lpb.trajectory import FloatArray, Trajectory

ROUND_SHAPES = ("circle", "sphere")
AT_REST = 1e-9  # [m/s] closing speeds up to this are rounding errors, not an approach


@once
def _clearance(trajectory: Trajectory) -> FloatArray:
    return measured(trajectory.clearance)


@kpi("clearance_min_m", "m", "higher", "all", group="safety")
def clearance_min(trajectory: Trajectory) -> float:
    """Smallest signed distance of any body to any obstacle in any row [m]; negative: penetration."""
    return smallest(_clearance(trajectory))


@kpi("clearance_mean_m", "m", "higher", "all", group="safety")
def clearance_mean(trajectory: Trajectory) -> float:
    """Time average of the signed distance to the nearest obstacle [m]."""
    return time_average(_clearance(trajectory))


@kpi("self_clearance_min_m", "m", "higher", "all", group="safety")
def self_clearance_min(trajectory: Trajectory) -> float:
    """Smallest signed distance between two bodies of the robot [m]; NaN without pairs to check."""
    return smallest(measured(trajectory.self_clearance))


def _joint_limit_margin(trajectory: Trajectory, joint_type: str) -> float:
    joints = of_joint_type(trajectory, joint_type)
    low, high = trajectory.problem.robot.limits.position[joints].T
    q = measured(trajectory.q[:, joints])
    return smallest(np.minimum(q - low, high - q))


@kpi("joint_limit_margin_min_rad", "rad", "higher", "all", group="safety")
def joint_limit_margin_rad(trajectory: Trajectory) -> float:
    """Smallest distance of a revolute joint to its limits [rad]; negative: beyond; NaN without limits."""
    return _joint_limit_margin(trajectory, "revolute")


@kpi("joint_limit_margin_min_m", "m", "higher", "all", group="safety")
def joint_limit_margin_m(trajectory: Trajectory) -> float:
    """Smallest distance of a prismatic joint, point or base to its limits [m]; NaN without limits."""
    return _joint_limit_margin(trajectory, "prismatic")


@kpi("near_miss_time_s", "s", "lower", "all", group="safety")
def near_miss_time(trajectory: Trajectory) -> float:
    """Time with a clearance below the scenario's safety margin [s]; each such row but the last counts dt."""
    clearance = _clearance(trajectory)
    if not np.isfinite(clearance).any():
        return math.nan
    problem = trajectory.problem
    return float(np.count_nonzero(clearance[:-1] < problem.safety_margin) * problem.dt)


@kpi("time_to_collision_min_s", "s", "higher", "all", group="safety")
def time_to_collision_min(trajectory: Trajectory) -> float:
    """Smallest time to contact with a round obstacle at the velocities of any row [s]; 0 in contact.

    The disc of a point or base and the obstacle keep their velocities (van der Horst & Hogema 1993,
    "Time-to-Collision and Collision Avoidance Systems", here in the plane). Other shapes are left out.
    NaN for other robots, and when nothing round is ever approached.
    """
    problem = trajectory.problem
    robot = problem.robot
    if problem.dimension != 2 or (robot.model != "point" and robot.base == "fixed"):
        return math.nan
    own_position, own_velocity = trajectory.q[:, :2], trajectory.qd[:, :2]
    times = [math.nan]
    for obstacle in problem.obstacles:
        if obstacle.shape in ROUND_SHAPES and obstacle.radius is not None:
            offset = trajectory.obstacle(obstacle.name)[:, :2] - own_position
            velocity = obstacle.motion.evaluate(trajectory.t)[1] - own_velocity
            radius = robot.body_radius + obstacle.radius
            times.append(smallest(time_to_contact(measured(offset), measured(velocity), radius)))
    return smallest(np.array(times))


def time_to_contact(offset: FloatArray, velocity: FloatArray, radius: float) -> FloatArray:
    """Smallest t >= 0 with |offset + velocity t| <= radius, for each row; NaN where there is none.

    Args:
        offset: centre of one disc seen from the other's, (N, m) [m].
        velocity: of the one relative to the other, (N, m) [m/s].
        radius: sum of both radii [m].

    Returns:
        Times, (N,) [s]; 0 where the discs touch or overlap.
    """
    gap = np.einsum("ij,ij->i", offset, offset) - radius * radius
    closing = -np.einsum("ij,ij->i", offset, velocity)
    discriminant = closing * closing - np.einsum("ij,ij->i", velocity, velocity) * gap
    times = np.full(len(offset), np.nan)
    meets = (gap > 0.0) & (closing > AT_REST * norms(offset)) & (discriminant >= 0.0)
    # The smaller root as gap / (closing + root): no cancellation when the discs are slow or far apart.
    times[meets] = gap[meets] / (closing[meets] + np.sqrt(discriminant[meets]))
    times[gap <= 0.0] = 0.0
    return times
