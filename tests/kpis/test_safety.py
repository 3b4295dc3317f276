import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.kpis.contact import time_to_contact
from pytest_lpb.kpis.safety import (
    clearance_mean,
    clearance_min,
    joint_limit_margin_m,
    near_miss_time,
    time_to_collision_min,
)

from .trials import ARM, Array, make_problem, make_trial


def contact(offset: tuple[float, float], velocity: tuple[float, float], radius: float = 1.0) -> float:
    return float(time_to_contact(np.array([offset]), np.array([velocity]), radius)[0])


@pytest.mark.parametrize(
    ("offset", "velocity", "time"),
    [
        ((5.0, 0.0), (-2.0, 0.0), 2.0),
        ((5.0, 0.0), (2.0, 0.0), math.nan),  # leaving
        ((5.0, 0.0), (0.0, 0.0), math.nan),
        ((5.0, 2.0), (-2.0, 0.0), math.nan),  # passing by
        ((5.0, 0.6), (-2.0, 0.0), (5.0 - 0.8) / 2.0),  # 0.6, 0.8, 1
        ((0.5, 0.0), (0.0, 0.0), 0.0),  # overlapping
        ((1.0, 0.0), (3.0, 0.0), 0.0),  # touching
    ],
)
def test_time_to_contact(offset: tuple[float, float], velocity: tuple[float, float], time: float) -> None:
    assert contact(offset, velocity) == pytest.approx(time, nan_ok=True)


@given(
    bearing=st.floats(-math.pi, math.pi),
    gap=st.floats(0.01, 100.0),
    radius=st.floats(0.1, 2.0),
    aim=st.floats(-0.99, 0.99),
    speed=st.floats(0.01, 10.0),
)
def test_discs_touch_at_the_time_to_contact(
    bearing: float, gap: float, radius: float, aim: float, speed: float
) -> None:
    towards = np.array([math.cos(bearing), math.sin(bearing)])
    offset = towards * (radius + gap)
    through = np.array([-towards[1], towards[0]]) * aim * radius - offset
    velocity = through / np.hypot(*through) * speed
    time = float(time_to_contact(offset[None], velocity[None], radius)[0])
    assert np.hypot(*(offset + velocity * time)) == pytest.approx(radius, rel=1e-6)
    assert np.hypot(*(offset + velocity * time * 0.999)) > radius


def moving_obstacle(**entry: object) -> dict[str, object]:
    return {"name": "cart", "shape": "circle", "radius": 0.3, "trajectory": ["4 - t", "0"], **entry}


def test_time_to_collision_uses_both_velocities() -> None:
    q = np.array([[0.0, 0.0], [0.1, 0.0]])
    trial = make_trial(make_problem(obstacles=[moving_obstacle()]), q, qd=np.array([[1.0, 0.0], [1.0, 0.0]]))
    assert time_to_collision_min(trial) == pytest.approx((3.9 - 0.1 - 0.5) / 2.0)


@pytest.mark.parametrize("shape", [{"shape": "rectangle", "size": [1.0, 1.0], "radius": None}])
def test_time_to_collision_leaves_out_other_shapes(shape: dict[str, object]) -> None:
    q, qd = np.zeros((2, 2)), np.array([[1.0, 0.0], [1.0, 0.0]])
    box = moving_obstacle(**shape)
    box["size"] = [1.0, 1.0]
    assert math.isnan(time_to_collision_min(make_trial(make_problem(obstacles=[box]), q, qd=qd)))
    both = make_problem(obstacles=[box, moving_obstacle(name="other")])
    assert time_to_collision_min(make_trial(both, q, qd=qd)) == pytest.approx((3.9 - 0.5) / 2.0)


def test_time_to_collision_does_not_apply_to_arms() -> None:
    problem = make_problem(ARM, goal=[arm_goal()], obstacles=[moving_obstacle()])
    assert math.isnan(time_to_collision_min(make_trial(problem, np.zeros((2, 2)))))


def arm_goal() -> dict[str, object]:
    return {"name": "elbow", "type": "joint", "joints": ["joint2"], "target": [0.5], "tolerance": 0.2}


def with_clearance(values: list[float], margin: float = 0.05) -> tuple[float, float, float]:
    columns: dict[str, Array] = {"clearance_m": np.array(values)}
    trial = make_trial(make_problem(safety_margin=margin), np.zeros((len(values), 2)), columns=columns)
    return clearance_min(trial), clearance_mean(trial), near_miss_time(trial)


def test_penetration_keeps_its_sign() -> None:
    assert with_clearance([0.2, -0.1, 0.2]) == pytest.approx((-0.1, 0.05, 0.1))


def test_the_last_row_is_no_time() -> None:
    assert with_clearance([0.2, 0.2, 0.0])[2] == 0.0


def test_mean_is_over_time() -> None:
    """Rows 0, 1, 0 over two steps: a triangle whose mean is a half, not a third."""
    assert with_clearance([0.0, 1.0, 0.0])[1] == pytest.approx(0.5)


def test_without_obstacles_nothing_applies() -> None:
    assert all(math.isnan(value) for value in with_clearance([math.nan] * 3))


def test_margin_counts_the_one_limit_there_is_and_goes_negative() -> None:
    problem = make_problem(limits=[None, [-math.inf, 0.3]])
    trial = make_trial(problem, np.array([[5.0, 0.0], [9.0, 0.4]]))
    assert joint_limit_margin_m(trial) == pytest.approx(-0.1)
