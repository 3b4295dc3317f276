"""No KPI beats its own optimum: ratios, shares and lengths against the best value that any motion can have."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.trajectory import Trajectory

from .scenes import SCENES, Scene, timing
from .spatial_scenes import SPATIAL
from .test_properties import STEP, value_of
from .trials import REACH, Array, make_problem, make_trial

Optimum = Callable[[Trajectory, dict[str, float]], float]
ROUNDING = 1e-9


def at_best(number: float) -> Optimum:
    return lambda trajectory, values: number


def other(name: str) -> Optimum:
    return lambda trajectory, values: values[name]


def between_ends(path: Callable[[Trajectory], Array]) -> Optimum:
    def straight(trajectory: Trajectory, values: dict[str, float]) -> float:
        rows = path(trajectory)
        return float(np.linalg.norm(rows[-1] - rows[0]))

    return straight


def link(trajectory: Trajectory) -> Array:
    return trajectory.link(trajectory.problem.primary.link or trajectory.problem.robot.link_names[-1])


def link_to_goal(trajectory: Trajectory) -> Array:
    return link(trajectory)[: (trajectory.goal_row or 0) + 1]


def joints(joint_type: str) -> Callable[[Trajectory], Array]:
    def path(trajectory: Trajectory) -> Array:
        return trajectory.q[:, [found == joint_type for found in trajectory.problem.robot.joint_types]]

    return path


def half_range(trajectory: Trajectory, values: dict[str, float]) -> float:
    lower, upper = trajectory.problem.robot.limits.position.T
    return float(np.max(upper - lower)) / 2.0


# The optimum of each KPI, of one trial; "better" is the KPI's own direction.
OPTIMA: dict[str, Optimum] = {
    **dict.fromkeys(("time_to_goal_s", "min_goal_distance_m", "min_goal_error_rad", "near_miss_time_s"), at_best(0.0)),
    "final_goal_distance_m": other("min_goal_distance_m"),
    "final_goal_error_rad": other("min_goal_error_rad"),
    "tracking_error_mean_m": other("min_goal_distance_m"),
    "tracking_error_rms_m": other("tracking_error_mean_m"),
    "spl": at_best(1.0),
    "path_length_ratio": at_best(1.0),
    "path_length_m": between_ends(link),
    "path_length_to_goal_m": between_ends(link_to_goal),
    "joint_path_length_rad": between_ends(joints("revolute")),
    "joint_path_length_m": between_ends(joints("prismatic")),
    "clearance_min_m": other("clearance_mean_m"),
    "clearance_mean_m": lambda trajectory, values: float(np.max(trajectory.clearance)),
    "self_clearance_min_m": lambda trajectory, values: float(np.max(trajectory.self_clearance)),
    "joint_limit_margin_min_rad": half_range,
    "joint_limit_margin_min_m": half_range,
    **dict.fromkeys(("jerk_rms_m_per_s3", "curvature_max_per_m"), at_best(0.0)),
    "sparc": at_best(-1.0),  # the arc over the unit interval of frequencies is no shorter than the interval
    "action_total_variation": between_ends(lambda trajectory: trajectory.action[:-1]),
    **dict.fromkeys(("action_squared_integral", "saturated_steps"), at_best(0.0)),
    **dict.fromkeys(("infeasible_rate", "deadline_miss_rate", "longest_miss_burst"), at_best(0.0)),
    "solver_time_mean_ms": lambda trajectory, values: float(np.nanmin(trajectory.solver_wall_ms)),
    "solver_time_p50_ms": lambda trajectory, values: float(np.nanmin(trajectory.solver_wall_ms)),
    "solver_time_p95_ms": other("solver_time_p50_ms"),
    "solver_time_p99_ms": other("solver_time_p95_ms"),
    "solver_time_max_ms": other("solver_time_p99_ms"),
    "solver_cpu_p50_ms": lambda trajectory, values: float(np.nanmin(trajectory.solver_cpu_ms)),
    "solver_cpu_p95_ms": other("solver_cpu_p50_ms"),
    "solver_cpu_p99_ms": other("solver_cpu_p95_ms"),
    **dict.fromkeys(("first_call_ms", "setup_ms"), at_best(0.0)),
}
WITHOUT = {
    "ldj": "a motion at constant speed has none",
    "time_to_collision_min_s": "the later the better, without end",
    "real_time_factor": "no machine is the fastest",
}


def check(trajectory: Trajectory) -> None:
    kpis = list(load_builtin())
    values = {entry.name: value_of(entry, trajectory) for entry in kpis}
    for entry in kpis:
        if entry.name in OPTIMA and math.isfinite(value := values[entry.name]):
            optimum = OPTIMA[entry.name](trajectory, values)
            better = value - optimum if entry.direction == "higher" else optimum - value
            assert better <= ROUNDING * max(1.0, abs(optimum)), f"{entry.name}: {value} beats {optimum}"


def test_every_kpi_has_an_optimum_or_a_reason() -> None:
    assert set(OPTIMA) | set(WITHOUT) == {entry.name for entry in load_builtin() if entry.group != "user"}
    assert not set(OPTIMA) & set(WITHOUT)


@pytest.mark.parametrize("scene", [*SCENES, *SPATIAL])
def test_no_kpi_of_a_motion_beats_its_optimum(scene: Scene) -> None:
    check(scene(STEP))


COORDINATE = st.floats(-3.0, 3.0)
PLACE = st.tuples(COORDINATE, COORDINATE)


@given(
    way=st.lists(PLACE, min_size=1, max_size=6),
    end=st.tuples(st.floats(-0.7, 0.7), st.floats(-0.7, 0.7)),
    tolerance=st.floats(0.01, 1.0),
    steps=st.integers(1, 6),
)
# Straight towards the target: the path ends where the tolerance begins, 0.2 m before the target.
@example(way=[(0.0, 0.0)], end=(0.0, 0.0), tolerance=0.2, steps=6)
def test_no_kpi_of_a_way_to_the_goal_beats_its_optimum(
    way: list[tuple[float, float]], end: tuple[float, float], tolerance: float, steps: int
) -> None:
    target = np.array([2.0, 0.0])
    corners = np.array([*way, target + np.array(end) * tolerance])
    shares = np.arange(1, steps + 1) / steps
    legs = [a + shares[:, None] * (b - a) for a, b in pairwise(corners)]
    q = np.vstack([corners[:1], *legs, np.repeat(corners[-1:], 3, axis=0)])
    pillar = {"name": "pillar", "shape": "circle", "radius": 0.5, "position": [1.0, 1.0]}
    problem = make_problem(
        goal=[{**REACH, "tolerance": tolerance}], obstacles=[pillar], limits=[[-4.0, 4.0], [-4.0, 4.0]]
    )
    problem.certified_path_length_m = float(np.linalg.norm(target - q[0]))
    action = np.vstack([np.diff(q, axis=0), [[math.nan, math.nan]]])
    check(make_trial(problem, q, qd=action, action=action, columns=timing(len(q))))
