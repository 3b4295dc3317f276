"""The horizon of one trial: its composed functions with the arrays they read and fill, and how they fill a program."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pytest_lpb.planner.base import FloatArray, Observation, PlannerProblem
from pytest_lpb.planner.mpc.composed import Composed, goal_weights_of, weights_of
from pytest_lpb.planner.mpc.observed import goal_fills, obstacle_fills
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.program import Program
from pytest_lpb.planner.scene.fills import Fill
from pytest_lpb.planner.scene.meshes import MeshFill
from pytest_lpb.planner.scene.shapes import MESH
from pytest_lpb.symbolic.buffered import BufferedFunction


class Horizon:
    """What is seen from one call, and programs around a plan for it.

    Args:
        problem: what the planner was told.
        composed: the horizon of its structure.
        parameters: of the planner.
    """

    def __init__(self, problem: PlannerProblem, composed: Composed, parameters: MpcParameters) -> None:
        self.sizes = composed.sizes
        self._model = composed.model
        self._stage = BufferedFunction(composed.stage)
        self._rollout = BufferedFunction(composed.rollout)
        self._slopes = None if composed.slopes is None else BufferedFunction(composed.slopes)
        self._weights, self._goal_weights = weights_of(parameters), goal_weights_of(parameters)
        self._proximal = parameters.proximal
        steps, arguments = self.sizes.steps, self._stage.arguments
        self._fills: list[Fill] = goal_fills(problem.goal, arguments["goals"].reshape(steps, -1))
        self._fills += obstacle_fills(problem.obstacles, arguments, steps, problem.dimension)
        self._meshes: MeshFill | None = None
        if composed.points is not None:
            self._meshes = MeshFill(problem.obstacles, composed.points, arguments[f"obstacles_{MESH}"], steps)

    @property
    def arguments(self) -> Mapping[str, FloatArray]:
        """Of the stage at all steps."""
        return self._stage.arguments

    def observe(self, observation: Observation) -> None:
        """Take in targets and obstacles."""
        self._seen = observation
        for fill in self._fills:
            fill(observation)

    def path(self, state: FloatArray, plan: FloatArray) -> FloatArray:
        """States after each step of a plan (N, n) from a state (m,): (N, m), until the next path is asked for."""
        rollout = self._rollout
        rollout.arguments["x"][:] = state
        rollout.arguments["a"][:] = plan.reshape(rollout.arguments["a"].shape)
        rollout.evaluate()
        return rollout.results["path"].reshape(self.sizes.steps, -1)

    def place_meshes(self, q: FloatArray) -> None:
        """Take in the points of meshes that are nearest to where the robot will be, q (N, dof)."""
        if self._meshes is not None:
            self._meshes.fill(self._seen, q)

    def linearise(self, program: Program, state: FloatArray, plan: FloatArray, last_input: FloatArray) -> None:
        """Fill in a program around a plan, all but its bounds.

        Args:
            program: to be filled in.
            state: at the start, (m,).
            plan: inputs (N, n).
            last_input: the one before the first, (n,).
        """
        path = self.path(state, plan)
        self._judge(program, path[:, : self.sizes.dof], last_input)
        self._move(program, np.vstack([state, path[:-1]]), plan, path)

    def _judge(self, program: Program, q: FloatArray, last_input: FloatArray) -> None:
        """Cost and distances, around q (N, dof)."""
        sizes, stage, weight = self.sizes, self._stage, self._goal_weights
        stage.arguments["q"][:] = q.reshape(stage.arguments["q"].shape)
        self.place_meshes(q)
        stage.evaluate()
        results = stage.results
        hessians = results["H"].reshape(sizes.steps, sizes.dof, sizes.dof) * weight[:, None, None]
        hessians[:, np.arange(sizes.dof), np.arange(sizes.dof)] += self._proximal
        gradients = results["g"].reshape(sizes.steps, sizes.dof) * weight[:, None] - self._proximal * q
        program.cost(hessians, gradients, self._weights, last_input)
        if sizes.rows:
            # CasADi stores columns first.
            slopes = results["J"].reshape(sizes.steps, sizes.dof, sizes.rows).transpose(0, 2, 1)
            distances = results["d"].reshape(sizes.steps, sizes.rows)
            program.distances(slopes, (slopes @ q[:, :, None])[:, :, 0] - distances)

    def _move(self, program: Program, before: FloatArray, plan: FloatArray, path: FloatArray) -> None:
        """The motion, linear around the states before (N, m) and after each step."""
        by_state, by_input = self._jacobians(before, plan)
        offsets = path - (by_input @ plan[:, :, None])[:, :, 0]
        offsets[1:] -= (by_state[1:] @ before[1:, :, None])[:, :, 0]
        program.motion(by_state[1:], by_input, offsets)

    def _jacobians(self, before: FloatArray, plan: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of the motion over each step, (N, m, m) and (N, m, n)."""
        sizes, model, slopes = self.sizes, self._model, self._slopes
        if slopes is None:
            return (
                np.broadcast_to(model.by_state, (sizes.steps, sizes.states, sizes.states)),
                np.broadcast_to(model.by_input, (sizes.steps, sizes.states, sizes.inputs)),
            )
        slopes.arguments["x"][:] = before.reshape(slopes.arguments["x"].shape)
        slopes.arguments["a"][:] = plan.reshape(slopes.arguments["a"].shape)
        slopes.evaluate()
        by_state = slopes.results["A"].reshape(sizes.steps, sizes.states, sizes.states)
        by_input = slopes.results["B"].reshape(sizes.steps, sizes.inputs, sizes.states)
        return by_state.transpose(0, 2, 1), by_input.transpose(0, 2, 1)
