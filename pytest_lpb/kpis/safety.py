"""KPIs about safety: distances to obstacles, to itself and to joint limits, and time to collision."""

from __future__ import annotations

import math

import numpy as np

from pytest_lpb.kpis.contact import round_body
from pytest_lpb.kpis.derived import measured, of_joint_type, once, smallest, time_average
from pytest_lpb.kpis.registry import kpi
from pytest_lpb.trajectory import FloatArray, Trajectory

ROUND_SHAPES = ("circle", "sphere")


@once
def _clearance(trajectory: Trajectory) -> FloatArray:
    return measured(trajectory.clearance)


@kpi("clearance_min_m", "m", "higher", "all", group="safety")
def clearance_min(trajectory: Trajectory) -> float:
    """Smallest signed distance of any body to any obstacle, at rows and between them [m]; negative: penetration."""
    return smallest(measured(trajectory.step_clearance))


@kpi("clearance_mean_m", "m", "higher", "all", group="safety")
def clearance_mean(trajectory: Trajectory) -> float:
    """Time average of the signed distance to the nearest obstacle [m]."""
    return time_average(_clearance(trajectory))


@kpi("self_clearance_min_m", "m", "higher", "all", group="safety")
def self_clearance_min(trajectory: Trajectory) -> float:
    """Smallest signed distance between two bodies of the robot, at rows and between [m]; NaN without pairs to check."""
    return smallest(measured(trajectory.self_step_clearance))


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
    """Time with a clearance below the scenario's safety margin [s].

    Each such row but the last counts dt. A dip between two rows that keep the margin counts for the time that straight
    lines from both rows down to its least clearance are below.
    """
    clearance = _clearance(trajectory)
    if not np.isfinite(clearance).any():
        return math.nan
    problem = trajectory.problem
    margin = problem.safety_margin
    least = measured(trajectory.step_clearance)[1:]
    first, last = clearance[:-1], clearance[1:]
    dips = (first >= margin) & (last >= margin) & (least < margin)
    shares = 2.0 * (margin - least[dips]) / (first + last - 2.0 * least)[dips]
    return float((np.count_nonzero(first < margin) + shares.sum()) * problem.dt)


@kpi("time_to_collision_min_s", "s", "higher", "all", group="safety")
def time_to_collision_min(trajectory: Trajectory) -> float:
    """Smallest time to contact with a round obstacle at the velocities of any row [s]; 0 in contact.

    The body of a point or base and the obstacle keep their velocities (van der Horst & Hogema 1993,
    "Time-to-Collision and Collision Avoidance Systems"): discs in the plane, balls in space, where a base may also be
    an upright cylinder, which meets balls at their heights of that row. Other shapes are left out.
    NaN for other robots, and when nothing round is ever approached.
    """
    body = round_body(trajectory)
    if body is None:
        return math.nan
    problem = trajectory.problem
    times = [math.nan]
    for obstacle in problem.obstacles:
        if obstacle.shape in ROUND_SHAPES and obstacle.radius is not None:
            position = trajectory.obstacle(obstacle.name)[:, : problem.dimension]
            velocity = obstacle.motion.evaluate(trajectory.t)[1]
            times.append(smallest(body.times_to(position, velocity, obstacle.radius)))
    return smallest(np.array(times))
