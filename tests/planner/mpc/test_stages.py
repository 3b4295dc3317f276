"""One step of the horizon: derivatives against finite differences; which rows are kept; slots without an obstacle."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.planner.base import PlannerProblem
from pytest_lpb.planner.mpc.observed import obstacle_fills
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.stages import ABSENT_M, Stage, smallest
from pytest_lpb.planner.scene.goals import ERRORS
from pytest_lpb.planner.scene.layout import capacities
from pytest_lpb.planner.scene.self_collision import pairs_of
from tests.planner import problems
from tests.planner.scene.making import (
    Array,
    Entry,
    goal,
    observed,
    obstacle,
    planar,
    problem_of,
    random_states,
    spatial,
)
from tests.problem.spatial.robots import PANDA

SMALL = 1e-6
HALF = float(np.sqrt(0.5))

POINT = planar(problems.POINT)
ARM = planar(problems.arm(0.6, 0.5, 0.4), self_collision_pairs=[["base", "link3"]])
PANDA_ENTRY = spatial(PANDA, self_collision_pairs=[["panda_link0", "panda_link7"], ["panda_link2", "panda_hand"]])
PLANAR_THINGS = [
    obstacle("circle", [0.9, 0.7], radius=0.2),
    obstacle("circle", [-0.5, 0.9], radius=0.3, name="other"),
    obstacle("rectangle", [0.4, -1.1], size=[0.4, 0.3], orientation=0.3, name="box"),
]
SPATIAL_THINGS = [
    obstacle("sphere", [0.6, 0.1, 0.5], radius=0.1),
    obstacle("box", [0.3, 0.6, 0.4], size=[0.2, 0.3, 0.4], orientation=[HALF, 0.0, HALF, 0.0]),
    obstacle("cylinder", [-0.4, 0.5, 0.3], radius=0.1, length=0.6, orientation=[HALF, HALF, 0.0, 0.0]),
    obstacle("capsule", [0.2, -0.6, 0.6], radius=0.08, length=0.5, orientation=[HALF, 0.5, 0.5, 0.0]),
]
SCENES: dict[str, tuple[Entry, list[Entry], list[Entry]]] = {
    "arm": (
        ARM,
        [
            goal("position", [0.5, 0.8], link="end", weight=2.0),
            goal("orientation", [0.4], link="end", name="turn", weight=0.5),
        ],
        PLANAR_THINGS,
    ),
    "cart": (
        planar(problems.CART),
        [goal("position", [1.0, 0.4], link="base"), goal("joint", [0.7], joints=["theta"], name="heading")],
        PLANAR_THINGS,
    ),
    "panda": (
        PANDA_ENTRY,
        [
            goal("position", [0.5, 0.2, 0.4], link="panda_hand"),
            goal("orientation", [0.0, 1.0, 0.0, 0.0], link="panda_hand", name="turn", weight=0.3),
        ],
        SPATIAL_THINGS,
    ),
}


@cache
def problem(name: str) -> PlannerProblem:
    return problem_of(*SCENES[name])


def stage_of(told: PlannerProblem, **parameters: Any) -> Stage:
    return Stage(told.robot, told.goal, capacities(told.obstacles), MpcParameters(**parameters))


def judged(function: Any, told: PlannerProblem, goals: list[Entry], things: list[Entry]) -> Callable[[Array], Any]:
    """The stage as a function of q alone."""
    names = [name for name in function.name_in() if name.startswith("obstacles_")]
    arguments = {name: np.zeros(function.size_in(name)[::-1]) for name in names}
    seen = observed(np.zeros(told.robot.dof), np.zeros(told.robot.n_actions), goals, things)
    for fill in obstacle_fills(told.obstacles, arguments, 1, told.dimension):
        fill(seen)
    targets = np.concatenate([item["target"] for item in goals])

    def judge(q: Array) -> dict[str, Array]:
        results = function(q, targets, *(arguments[name].T for name in names))
        return dict(zip(function.name_out(), map(np.array, results), strict=True))

    return judge


def scene(name: str, **parameters: Any) -> Callable[[Array], Any]:
    told = problem(name)
    return judged(stage_of(told, **parameters).function(), told, *SCENES[name][1:])


def errors_of(name: str) -> Any:
    """Function of q to the errors of all sub-goals, times the roots of their weights."""
    told = problem(name)
    stage = stage_of(told)
    errors = [
        np.sqrt(info.weight) * ERRORS[told.dimension, info.type](stage.state, info, casadi.DM(item["target"]), 0.0)
        for info, item in zip(told.goal, SCENES[name][1], strict=True)
    ]
    return casadi.Function("errors", [stage.state.q], [casadi.densify(casadi.vertcat(*errors))])


def differences(value: Callable[[Array], Array], q: Array) -> Array:
    """Jacobian of a column by central differences."""
    columns = [value(q + SMALL * unit) - value(q - SMALL * unit) for unit in np.eye(len(q))]
    return np.hstack(columns) / (2.0 * SMALL)


# Derivatives


@pytest.mark.parametrize("name", SCENES)
def test_the_cost_is_that_of_gauss_and_newton(name: str) -> None:
    judge, errors = scene(name), errors_of(name)
    for q, _ in random_states(problem(name).robot, 2, 4):
        error = np.array(errors(q))
        slope = differences(lambda there: np.array(errors(there)), q)
        found = judge(q)
        np.testing.assert_allclose(found["H"], slope.T @ slope, atol=1e-7)
        np.testing.assert_allclose(found["g"], slope.T @ error - slope.T @ slope @ q[:, None], atol=1e-7)


@pytest.mark.parametrize("nearest", [0, 1, 2])
@pytest.mark.parametrize("name", SCENES)
def test_gradients_of_distances_are_those_of_finite_differences(name: str, nearest: int) -> None:
    judge = scene(name, nearest=nearest, own_nearest=2)
    for q, _ in random_states(problem(name).robot, 3, 4):
        slope = differences(lambda there: np.asarray(judge(there)["d"]), q)
        np.testing.assert_allclose(judge(q)["J"], slope, atol=1e-6)


def test_a_point_s_distance_to_a_disc_is_as_computed_by_hand() -> None:
    # The disc's centre is (3, 4) away: 5 m less both radii and the margin.
    goals = [goal("position", [1.0, 2.0], link="body", weight=4.0)]
    things = [obstacle("circle", [3.0, 4.0], radius=0.5)]
    told = problem_of(POINT, goals, things)
    found = judged(stage_of(told, margin=0.1).function(), told, goals, things)(np.zeros(2))
    assert found["d"] == pytest.approx(np.array([[5.0 - 0.5 - 0.2 - 0.1]]))
    assert found["J"] == pytest.approx(np.array([[-0.6, -0.8]]))
    assert found["H"] == pytest.approx(4.0 * np.eye(2))
    assert found["g"] == pytest.approx(np.array([[-4.0], [-8.0]]))


# Rows


@pytest.mark.parametrize(("nearest", "per_ball"), [(0, 3), (1, 1), (2, 2), (3, 3), (64, 3)])
def test_each_ball_minds_so_many_obstacles_and_zero_is_all(nearest: int, per_ball: int) -> None:
    told = problem_of(POINT, [goal("position", [0.0, 0.0], link="body")], PLANAR_THINGS)
    stage = stage_of(told, nearest=nearest)
    assert stage.function().size_out("d") == (per_ball * len(stage.balls), 1)


def test_the_nearest_are_the_smallest_of_all() -> None:
    every, two = (scene("cart", nearest=nearest) for nearest in (0, 2))
    for q, _ in random_states(problem("cart").robot, 5, 6):
        assert two(q)["d"][:, 0] == pytest.approx(np.sort(every(q)["d"][:, 0])[:2], abs=1e-12)


def test_pairs_of_the_robot_s_own_bodies_add_their_nearest_rows() -> None:
    told = problem("panda")
    none, one = (stage_of(told, own_nearest=count).function().size_out("d")[0] for count in (0, 1))
    assert one == none + 1
    assert pairs_of(told.robot, MpcParameters())


def test_slots_without_an_obstacle_are_far() -> None:
    goals = [goal("position", [0.0, 0.0], link="body")]
    things = [obstacle("circle", [3.0, 4.0], radius=0.5)]
    told = problem_of(POINT, goals, things)
    stage = Stage(told.robot, told.goal, {"circle": 4}, MpcParameters(nearest=0, margin=0.0))
    found = judged(stage.function(), told, goals, things)(np.zeros(2))
    assert found["d"][0, 0] == pytest.approx(4.3)
    assert np.all(found["d"][1:] > 0.99 * ABSENT_M)
    assert np.isfinite(found["J"]).all()


def test_slots_without_an_obstacle_are_far_from_everywhere() -> None:
    # Zeros, as before anything is filled in: the slot lies where the robot is.
    told = problem_of(POINT, [goal("position", [0.0, 0.0], link="body")])
    function = Stage(told.robot, told.goal, {"circle": 2, "rectangle": 1}, MpcParameters(nearest=0)).function()
    found = [np.array(part) for part in function(np.zeros(2), np.zeros(2), 0.0, 0.0)]
    assert np.all(found[2] > 0.99 * ABSENT_M)
    assert all(np.isfinite(part).all() for part in found)


@cache
def kept(length: int, count: int) -> Any:
    values, marks = casadi.SX.sym("values", length), casadi.SX.sym("marks", length)
    rows = smallest([(values[place], marks[place]) for place in range(length)], count)
    columns = [casadi.vertcat(*(row[part] for row in rows)) for part in (0, 1)]
    return casadi.Function("kept", [values, marks], columns)


@given(st.lists(st.integers(-5, 5).map(float) | st.floats(-1e3, 1e3), min_size=1, max_size=7), st.integers(0, 8))
def test_the_smallest_rows_are_kept_in_order_and_all_as_they_are_if_there_are_no_more(
    values: list[float], count: int
) -> None:
    # Of equally small ones any may be kept, but each with what belongs to it, and none twice.
    found, marks = (np.array(part)[:, 0] for part in kept(len(values), count)(values, list(range(len(values)))))
    expected = sorted(values)[:count] if 0 < count < len(values) else values
    assert found.tolist() == expected
    assert [values[int(mark)] for mark in marks] == expected
    assert len(set(marks)) == len(marks)


def test_no_rows_stay_none() -> None:
    assert smallest([], 0) == smallest([], 2) == []
