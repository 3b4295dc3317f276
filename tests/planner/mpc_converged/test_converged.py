"""The converged solution: of two solvers the same, and what sequential quadratic programming converges to."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pytest_lpb.planner.base import Observation, PlannerProblem
from pytest_lpb.planner.mpc.composed import goal_weights_of, weights_of
from pytest_lpb.planner.mpc.converged import ConvergedSolver, compose, guess_of
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.planner import Mpc
from pytest_lpb.planner.mpc.stages import Stage
from pytest_lpb.planner.scene.layout import capacities
from tests.planner import problems

Array = NDArray[np.float64]
Entry = dict[str, Any]

AGREEMENT = 1e-4
TIGHT = 1e-11
PARAMETERS = MpcParameters(horizon=15, nearest=0, own_nearest=0, tolerance=TIGHT, proximal=0.0)
ITERATIONS = 60


class Case:
    """A problem, the planner's plan for it, and solvers of the same problem."""

    def __init__(self, problem: PlannerProblem, observation: Observation, parameters: MpcParameters) -> None:
        self.problem, self.parameters = problem, parameters
        self.planner = Mpc(parameters)
        self.planner.setup(problem)
        self.planner._horizon.observe(observation)
        self.state = np.concatenate([observation["q"], observation["u"]])
        self.sizes = self.planner._horizon.sizes
        self.program = self.planner._program
        self.planner._bounds.fill(self.program, self.state)
        plan = self.planner._plan
        self.still = guess_of(self.sizes, plan, self.planner._horizon.path(self.state, plan).copy())

    def sqp(self) -> Array:
        """The variables that quadratic programs, one after the other, lead to."""
        for _ in range(ITERATIONS):
            solution = self.planner._iterate(self.state)
            assert solution.solved
        return solution.z.copy()

    def solve(self, plugin: Any, guess: Array) -> Array:
        """The converged solution."""
        planner, parameters = self.planner, self.parameters
        stage = Stage(self.problem.robot, self.problem.goal, capacities(self.problem.obstacles), parameters)
        program = compose(
            plugin,
            stage.function(),
            stage.errors(),
            planner._horizon._model,
            self.sizes,
            weights_of(parameters),
            goal_weights_of(parameters),
            TIGHT,
        )
        solver = ConvergedSolver(program, self.sizes)
        lower, upper = self.program.lower, self.program.upper
        solution = solver.solve(self.state, planner._last, planner._horizon.arguments, lower, upper, guess)
        assert solution.solved
        assert solution.residual < 1e-7
        return solution.z


def point(seed: int, **changes: Any) -> Case:
    """A point that starts anywhere with two discs about and a goal across."""
    generator = np.random.default_rng(seed)
    angle = generator.uniform(0.0, 2.0 * np.pi)
    towards = np.array([np.cos(angle), np.sin(angle)])
    start, target = -generator.uniform(0.8, 1.5) * towards, generator.uniform(0.8, 1.5) * towards
    discs = [problems.circle(x, y, 0.25) for x, y in generator.uniform(-0.5, 0.5, (2, 2)).tolist()]
    return case(problems.POINT, "body", start, target, discs, generator.uniform(-0.5, 0.5, 2), **changes)


def case(
    robot: Entry, link: str, q: Array, target: Array, discs: Sequence[Entry], u: Array | None = None, **changes: Any
) -> Case:
    problem = problems.problem_of(robot, [problems.reach(link, *target)], discs)
    observation = problems.observed(problem, q, u, targets={"reach": target}, obstacles=discs)
    return Case(problem, observation, dataclasses.replace(PARAMETERS, **changes))


@pytest.mark.parametrize("seed", range(10))
def test_two_solvers_have_one_solution(seed: int) -> None:
    # From the same plan: from rest they may pass the discs on different sides.
    one = point(seed)
    plan = one.sqp()
    np.testing.assert_allclose(one.solve("fatrop", plan), one.solve("ipopt", plan), atol=AGREEMENT, rtol=0)


@pytest.mark.parametrize("seed", range(10))
def test_quadratic_programs_of_a_point_lead_to_the_converged_solution(seed: int) -> None:
    # The last inputs hardly change the cost, and are not told to the last digit: the motion is.
    one = point(seed)
    z = one.sqp()
    places = np.concatenate([one.sizes.state_places.ravel(), one.sizes.input_places[0]])
    np.testing.assert_allclose(one.solve("ipopt", z)[places], z[places], atol=AGREEMENT, rtol=0)


def test_quadratic_programs_of_an_arm_lead_to_the_converged_solution() -> None:
    q, target = np.array([0.3, 0.4, 0.3]), np.array([0.2, 1.1])
    one = case(problems.arm(0.6, 0.5, 0.4), "end", q, target, [problems.circle(1.2, 1.2, 0.2)])
    z = one.sqp()
    np.testing.assert_allclose(one.solve("ipopt", z), z, atol=AGREEMENT, rtol=0)
