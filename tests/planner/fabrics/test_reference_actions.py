"""The planner gives the actions that release 0.10.0 of the reference implementation printed."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.fabrics.planner import Fabrics
from tests.planner import problems
from tests.planner.fabrics.reference import KINDS, observation_of, problem_of_row, rows_of
from tests.planner.scene.making import Array, Entry, act, goal, obstacle, planar

CASES = [(kind, index) for kind in KINDS for index in range(12)]


def action(kind: str, row: Entry, sign: Literal["theory", "reference"]) -> Array:
    planner = Fabrics(FabricsParameters(curvature_term=sign))
    planner.setup(problem_of_row(kind, row))
    return planner.compute_action(observation_of(row))


@pytest.mark.parametrize("kind", KINDS)
def test_the_table_has_twelve_states_of_each_robot(kind: str) -> None:
    assert len(rows_of(kind)) == 12


@pytest.mark.parametrize(("kind", "index"), CASES)
def test_actions_are_those_of_the_reference_release(kind: str, index: int) -> None:
    row = rows_of(kind)[index]
    assert action(kind, row, "reference") == pytest.approx(row["action"], rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_with_the_sign_of_the_theory_actions_differ(kind: str) -> None:
    # Also those of a point: its place has no curvature, its distances from discs have.
    differences = [np.abs(action(kind, row, "theory") - row["action"]).max() for row in rows_of(kind)]
    assert max(differences) > 0.1


@pytest.mark.parametrize(("velocity", "agree"), [([0.6, 0.0], True), ([0.0, 0.6], False)])
def test_signs_agree_where_a_point_moves_straight_at_a_disc(velocity: list[float], agree: bool) -> None:
    robot, goals = planar(problems.POINT), [goal("position", [2, 1], link="body")]
    disc = obstacle("circle", [1.0, 0.0], radius=0.3)
    theory, reference = (
        act(robot, [0, 0], velocity, goals, [disc], curvature_term=sign) for sign in ("theory", "reference")
    )
    assert np.allclose(theory, reference, rtol=0.0, atol=1e-12) is agree
