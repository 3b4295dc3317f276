"""What the solver calls solved is the minimum: PIQP reads the upper triangle only, and of a program that is not convex
it may call a maximum solved (piqp 0.7.0).
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.planner import Mpc
from pytest_lpb.planner.mpc.program import Program
from tests.planner import problems
from tests.planner.scene.making import Array, Entry, goal, observed, obstacle, planar, problem_of

STEPS = 6
ACTIVE = 1e-4  # from here on a row or bound does not hold the solution


def whole(program: Program) -> Array:
    """The symmetric matrix of the cost."""
    upper = program.P.toarray()
    symmetric: Array = upper + np.triu(upper, 1).T
    return symmetric


def away_from_optimal(program: Program, z: Array) -> float:
    """How far the conditions of Karush, Kuhn and Tucker are missed: of a convex program they are sufficient."""
    distances, motion = program.G.toarray(), program.A.toarray()
    eye = np.eye(len(z))
    pushes = [
        motion.T,
        -motion.T,
        distances[distances @ z - program.low < ACTIVE].T,
        eye[:, z - program.lower < ACTIVE],
        -eye[:, program.upper - z < ACTIVE],
    ]
    gradient = whole(program) @ z + program.c
    stationary = nnls(np.hstack(pushes), gradient)[1]
    missed = [np.abs(motion @ z - program.b), program.low - distances @ z, program.lower - z, z - program.upper]
    return float(max(stationary / (1.0 + np.linalg.norm(gradient)), *(part.max(initial=0.0) for part in missed)))


POINT = planar(problems.POINT, limits={"acceleration": [[-1.0, 1.0]] * 2})
ARM = planar(problems.arm(1.0, 0.8), limits={"position": [[-0.35, 0.35]] * 2})
DISC = obstacle("circle", [1.0, 0.05], radius=0.3)
CASES: dict[str, tuple[Entry, list[Entry]]] = {
    "point": (POINT, [goal("position", [2.0, 0.0], link="body")]),
    "arm": (ARM, [goal("joint", [0.9, -0.9], joints=["joint1", "joint2"])]),
}


@pytest.mark.parametrize("name", CASES)
def test_what_is_solved_is_the_minimum_of_a_convex_program(name: str) -> None:
    entry, goals = CASES[name]
    planner = Mpc(MpcParameters(horizon=STEPS, tolerance=1e-8))
    planner.setup(problem_of(entry, goals, [DISC], period=0.1))
    seen = observed([0.1, 0.1], [0.05, 0.05], goals, [DISC])
    planner.compute_action(seen | {"obstacle_position_preview": np.array([[DISC["position"]]] * STEPS)})
    program = planner._program
    assert np.array_equal(program.P.toarray(), np.triu(program.P.toarray()))
    assert np.linalg.eigvalsh(whole(program))[0] > 0.0
    solution = planner._solver.solve()
    assert solution.solved
    assert away_from_optimal(program, solution.z) < 1e-5
    assert away_from_optimal(program, solution.z + 1e-2) > 1e-3


@pytest.mark.parametrize("name", ["goal", "goal_end", "velocity", "velocity_end", "input", "input_change", "proximal"])
def test_weights_of_a_program_that_is_not_convex_are_refused(name: str) -> None:
    with pytest.raises(ConfigurationError, match=name):
        PlannerConfiguration("mpc", "mpc", {name: -1.0}).check()
