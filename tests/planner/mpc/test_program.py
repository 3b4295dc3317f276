"""The quadratic program: matrices by hand, and a linear-quadratic problem against Riccati's equation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.planner import Mpc
from pytest_lpb.planner.mpc.program import Entries, Program, Sizes, Weights, dense_blocks
from pytest_lpb.planner.mpc.solver import PiqpSolver
from tests.planner import problems
from tests.planner.scene.making import Array, goal, observed, planar, problem_of

# Two steps of a robot of one joint, with one distance: z = (a0, s0, q1, u1, a1, s1, q2, u2).
SIZES = Sizes(steps=2, inputs=1, states=2, dof=1, rows=1)
WEIGHTS = Weights(velocity=0.1, velocity_end=1.0, input=0.5, input_change=0.25, slack=100.0, slack_squared=2.0)


def filled() -> Program:
    program = Program(SIZES)
    program.cost(np.array([[[3.0]], [[4.0]]]), np.array([[5.0], [6.0]]), WEIGHTS, np.array([0.8]))
    by_state = np.array([[[1.0, 0.1], [0.2, 0.9]]])
    by_input = np.array([[[0.01], [0.11]], [[0.02], [0.12]]])
    program.motion(by_state, by_input, np.array([[7.0, 8.0], [9.0, 10.0]]))
    program.distances(np.array([[[0.3]], [[0.4]]]), np.array([[-0.5], [0.6]]))
    return program


# Entries


def test_entries_are_filled_in_the_order_of_their_places() -> None:
    entries = Entries(np.array([2, 0, 1, 0]), np.array([0, 1, 1, 0]), (3, 2))
    entries.fill(np.array([1.0, 2.0, 3.0, 4.0]))
    assert np.array_equal(entries.matrix.toarray(), [[4.0, 2.0], [0.0, 3.0], [1.0, 0.0]])


def test_entries_of_value_zero_keep_their_place() -> None:
    entries = Entries(np.array([1, 0]), np.array([0, 0]), (2, 1))
    for values in ([0.0, 0.0], [1.0, 2.0]):
        entries.fill(np.array(values))
        assert entries.matrix.nnz == 2
        assert np.array_equal(entries.matrix.toarray()[::-1, 0], values)


def test_dense_blocks_are_given_row_by_row() -> None:
    rows, columns = dense_blocks(np.array([[0, 1]]), np.array([[4, 5, 6]]))
    assert rows.tolist() == [[[0, 0, 0], [1, 1, 1]]]
    assert columns.tolist() == [[[4, 5, 6], [4, 5, 6]]]


# Matrices


def test_variables_lie_stage_by_stage() -> None:
    assert SIZES.variables == 8
    assert SIZES.input_places.tolist() == [[0], [4]]
    assert SIZES.slack_places.tolist() == [[1], [5]]
    assert SIZES.state_places.tolist() == [[2, 3], [6, 7]]


def test_the_cost_is_as_computed_by_hand() -> None:
    program = filled()
    # Inputs: 0.5 a0^2 + 0.5 a1^2 + 0.25 (a0 - 0.8)^2 + 0.25 (a1 - a0)^2, all halved.
    expected = np.diag([1.0, 2.0, 3.0, 0.1, 0.75, 2.0, 4.0, 1.1])
    expected[0, 4] = -0.25
    np.testing.assert_allclose(program.P.toarray(), expected, atol=1e-15)
    np.testing.assert_allclose(program.c, [-0.2, 100.0, 5.0, 0.0, 0.0, 100.0, 6.0, 0.0], atol=1e-15)


def test_the_motion_is_as_computed_by_hand() -> None:
    program = filled()
    expected = [
        [-0.01, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [-0.11, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, -1.0, -0.1, -0.02, 0.0, 1.0, 0.0],
        [0.0, 0.0, -0.2, -0.9, -0.12, 0.0, 0.0, 1.0],
    ]
    assert np.array_equal(program.A.toarray(), expected)
    assert np.array_equal(program.b, [7.0, 8.0, 9.0, 10.0])


def test_distances_are_as_computed_by_hand() -> None:
    program = filled()
    expected = [[0.0, 1.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.4, 0.0]]
    assert np.array_equal(program.G.toarray(), expected)
    assert np.array_equal(program.low, [-0.5, 0.6])


def test_the_cost_s_matrix_is_the_upper_triangle_of_whole_hessians() -> None:
    program = Program(Sizes(steps=2, inputs=1, states=3, dof=2, rows=0))
    hessians = np.array([[[1.0, 2.0], [2.0, 5.0]], [[3.0, 4.0], [4.0, 6.0]]])
    program.cost(hessians, np.zeros((2, 2)), WEIGHTS, np.zeros(1))
    found = program.P.toarray()
    assert np.array_equal(found, np.triu(found))
    for block, start in zip(hessians, (2, 7), strict=True):
        assert np.array_equal(found[start : start + 2, start : start + 2], np.triu(block))


def test_the_program_is_solved_as_its_conditions_say() -> None:
    # Karush, Kuhn and Tucker: without bounds, and the rows far from active, a linear system.
    program = filled()
    program.low[:] = -1e3
    program.c[SIZES.slack_places] = 0.0
    upper = program.P.toarray()
    whole, equal = upper + np.triu(upper, 1).T, program.A.toarray()
    system = np.block([[whole, equal.T], [equal, np.zeros((4, 4))]])
    expected = np.linalg.solve(system, np.concatenate([-program.c, program.b]))[:8]
    solution = PiqpSolver(program, 1e-9).solve()
    assert solution.solved
    assert solution.z == pytest.approx(expected, abs=1e-6)


def test_programs_are_solved_anew_after_they_were_filled_in_anew() -> None:
    program = filled()
    solver = PiqpSolver(program, 1e-9)
    first = solver.solve()
    program.b[:] *= 2.0
    solver.solve()
    program.b[:] /= 2.0
    assert solver.solve().z == pytest.approx(first.z, abs=1e-7)


def test_programs_without_a_solution_are_not_solved() -> None:
    program = filled()
    program.lower[:], program.upper[:] = -0.1, 0.1
    assert not PiqpSolver(program, 1e-6).solve().solved


# Riccati

STEP = 0.1
A = np.array([[1.0, STEP], [0.0, 1.0]])
B = np.array([[0.5 * STEP * STEP], [STEP]])
Q, END, R = np.diag([1.5, 0.2]), np.diag([9.0, 0.9]), np.array([[0.05]])


def gain(after: Array) -> Array:
    found: Array = np.linalg.solve(R + B.T @ after @ B, B.T @ after @ A)
    return found


def first_gain(steps: int) -> Array:
    """Gain at the first of several steps, by recursion from the end."""
    value = END
    for _ in range(steps - 1):
        value = Q + A.T @ value @ (A - B @ gain(value))
    return gain(value)


def first_action(steps: int, q: list[float], u: list[float]) -> Array:
    goals = [goal("position", [2.0, -1.0], link="body")]
    weights = MpcParameters(
        horizon=steps,
        step=STEP,
        goal=1.5,
        goal_end=9.0,
        velocity=0.2,
        velocity_end=0.7,
        input=0.05,
        proximal=0.0,
        tolerance=1e-9,
    )
    planner = Mpc(weights)
    planner.setup(problem_of(planar(problems.POINT), goals, period=STEP))
    return planner.compute_action(observed(q, u, goals))


def by_gain(gains: Array, q: list[float], u: list[float]) -> Array:
    errors: Array = np.array([[q[0] - 2.0, q[1] + 1.0], u])
    action: Array = -(gains @ errors)[0]
    return action


@pytest.mark.parametrize("steps", [2, 5, 20])
def test_the_plan_is_the_linear_quadratic_regulator_s(steps: int) -> None:
    state = [0.3, 0.4], [0.5, -0.6]
    assert first_action(steps, *state) == pytest.approx(by_gain(first_gain(steps), *state), abs=1e-6)


def test_a_long_plan_begins_as_one_without_end() -> None:
    state = [0.3, 0.4], [0.5, -0.6]
    endless = gain(linalg.solve_discrete_are(A, B, Q, R))
    assert first_action(150, *state) == pytest.approx(by_gain(endless, *state), abs=1e-6)
