"""Every built-in KPI on a trial whose value is known by hand."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.trajectory import Trajectory

from .trials import ARM, REACH, make_problem, make_trial


@cache
def straight() -> Trajectory:
    """2 s along x at 1 m/s, dt = 0.1 s, to a goal at x = 2 with tolerance 0.15; an obstacle is at x = 5."""
    problem = make_problem(
        obstacles=[{"name": "pillar", "shape": "circle", "radius": 0.5, "position": [5.0, 0.0]}],
        safety_margin=2.85,
        limits=[[-1.0, 3.0], [-0.4, math.inf]],
    )
    problem.certified_path_length_m = 1.52
    rows = 21
    q = np.column_stack([np.arange(rows) * 0.1, np.zeros(rows)])
    qd = np.column_stack([np.ones(rows), np.zeros(rows)])
    action = np.column_stack([np.ones(rows), np.where(np.arange(rows) < 10, 0.0, 2.0)])
    applied = np.where(np.isin(np.arange(rows), [3, 12, 13]), 0.5, action[:, 0])
    applied[-1] = np.nan
    wall = np.append(np.insert(np.arange(1.0, 20.0), 0, 100.0), np.nan)
    columns = {"applied0": applied, "solver_wall_ms": wall, "solver_cpu_ms": wall / 2.0}
    columns["self_clearance_m"] = np.linspace(0.3, -0.1, rows)
    columns["planner_solved"] = np.append(np.where(np.arange(20) % 5, 1.0, 0.0), np.nan)
    return make_trial(problem, q, qd=qd, action=action, columns=columns, period_s=0.0175)


@cache
def bell() -> Trajectory:
    """4 s along x at the speed exp(−5 (t − 2)²), dt = 0.02 s."""
    t = np.arange(201) * 0.02
    scale = math.sqrt(math.pi / 20.0)
    x = [scale * math.erf(math.sqrt(5.0) * (s - 2.0)) for s in t.tolist()]
    return make_trial(make_problem(dt=0.02), np.column_stack([x, np.zeros(201)]))


@cache
def circle() -> Trajectory:
    """A quarter of a circle of radius 2 m."""
    angle = np.linspace(0.0, np.pi / 2.0, 50)
    return make_trial(make_problem(), 2.0 * np.column_stack([np.cos(angle), np.sin(angle)]))


@cache
def arm() -> Trajectory:
    """Both joints from 0, at 0.3 and 0.4 rad/s for 1 s; the second should come to 0.5 rad."""
    goal = {"name": "elbow", "type": "joint", "joints": ["joint2"], "target": [0.5], "tolerance": 0.2}
    problem = make_problem(ARM, goal=[goal], limits=[[-0.25, 1.0], [-2.0, 0.6]])
    return make_trial(problem, np.linspace(0.0, 1.0, 11)[:, None] * [0.3, 0.4])


@cache
def follower() -> Trajectory:
    """A goal at (t, 0) and a point at (t, 1 − t/2): within 0.501 m from t = 1 s to the end at 2 s."""
    goal = {**REACH, "target": None, "trajectory": ["t", "0"], "tolerance": 0.501}
    t = np.arange(201) * 0.01
    problem = make_problem(dt=0.01, goal=[goal], hold_time="end", duration=2.0)
    return make_trial(problem, np.column_stack([t, 1.0 - 0.5 * t]))


# ∫ v̈² dt of the bell, with v̈ = (100 τ² − 10) exp(−5 τ²): Gaussian moments give 75 sqrt(π/10).
BELL_JERK = 75.0 * math.sqrt(math.pi / 10.0)

KNOWN: list[tuple[str, Callable[[], Trajectory], float, float]] = [
    ("time_to_goal_s", straight, 1.9, 1e-9),  # 0.2 m away at 1.8 s, 0.1 m at 1.9 s
    ("time_to_goal_s", follower, 1.0, 1e-9),
    ("final_goal_distance_m", straight, 0.0, 1e-9),
    ("min_goal_distance_m", circle, 0.0, 1e-9),  # starts at the goal
    ("final_goal_distance_m", circle, 2.0 * math.sqrt(2.0), 1e-9),
    ("final_goal_error_rad", arm, 0.1, 1e-9),
    ("min_goal_error_rad", arm, 0.1, 1e-9),
    ("tracking_error_mean_m", follower, 0.25, 1e-9),
    ("tracking_error_rms_m", follower, math.sqrt(1.0 / 12.0), 1e-4),
    ("spl", straight, 1.52 / 1.9, 1e-9),
    ("path_length_m", straight, 2.0, 1e-9),
    ("path_length_m", circle, math.pi, 1e-3),
    ("path_length_to_goal_m", straight, 1.9, 1e-9),
    ("joint_path_length_rad", arm, 0.5, 1e-9),
    ("joint_path_length_m", straight, 2.0, 1e-9),
    ("path_length_ratio", straight, 1.0, 1e-9),
    ("clearance_min_m", straight, 2.3, 1e-9),  # 5 − x − 0.5 − 0.2 at x = 2
    ("clearance_mean_m", straight, 3.3, 1e-9),
    ("self_clearance_min_m", straight, -0.1, 1e-9),
    ("joint_limit_margin_min_rad", arm, 0.2, 1e-9),  # 0.6 − 0.4; the first joint: 0.25
    ("joint_limit_margin_min_m", straight, 0.4, 1e-9),  # y stays 0.4 above its lower limit
    ("near_miss_time_s", straight, 0.5, 1e-9),  # x = 1.5 .. 1.9
    ("time_to_collision_min_s", straight, 2.3, 1e-9),
    ("jerk_rms_m_per_s3", bell, math.sqrt(BELL_JERK / 4.0), 0.02),
    ("ldj", bell, -math.log(4.0**3 * BELL_JERK), 0.02),
    ("sparc", bell, -1.414, 2e-3),
    ("curvature_max_per_m", circle, 0.5, 1e-9),
    ("action_total_variation", straight, 2.0, 1e-9),
    ("action_squared_integral", straight, 10 * 1.0 * 0.1 + 10 * 5.0 * 0.1, 1e-9),
    ("saturated_steps", straight, 3.0, 0.0),
    ("solver_time_mean_ms", straight, 10.0, 1e-9),  # 1 .. 19 ms: the first call, 100 ms, is left out
    ("solver_time_p50_ms", straight, 10.0, 1e-9),
    ("solver_time_p95_ms", straight, 1.0 + 0.95 * 18.0, 1e-9),
    ("solver_time_p99_ms", straight, 1.0 + 0.99 * 18.0, 1e-9),
    ("solver_time_max_ms", straight, 19.0, 1e-9),
    ("solver_cpu_p50_ms", straight, 5.0, 1e-9),
    ("solver_cpu_p95_ms", straight, 0.5 * (1.0 + 0.95 * 18.0), 1e-9),
    ("solver_cpu_p99_ms", straight, 0.5 * (1.0 + 0.99 * 18.0), 1e-9),
    ("first_call_ms", straight, 100.0, 1e-9),
    ("setup_ms", straight, 7.0, 1e-9),
    ("deadline_miss_rate", straight, 3.0 / 20.0, 1e-9),  # 100, 18 and 19 ms against 17.5 ms
    ("longest_miss_burst", straight, 2.0, 0.0),
    ("infeasible_rate", straight, 4.0 / 20.0, 1e-9),
    ("real_time_factor", straight, 4.0, 1e-9),
]


@pytest.mark.parametrize(
    ("name", "trial", "value", "tolerance"), KNOWN, ids=[f"{row[0]}-{row[1].__name__}" for row in KNOWN]
)
def test_value_is_the_one_computed_by_hand(
    name: str, trial: Callable[[], Trajectory], value: float, tolerance: float
) -> None:
    (entry,) = load_builtin().select([name])
    assert float(entry(trial())) == pytest.approx(value, abs=tolerance)


def test_every_builtin_kpi_has_a_known_value() -> None:
    assert {row[0] for row in KNOWN} == {entry.name for entry in load_builtin() if entry.group != "user"}
