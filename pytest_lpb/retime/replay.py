"""The observations of a recorded trial, made again from its raw data, and the planner asked again."""

from __future__ import annotations

from collections.abc import Iterator
from math import isnan
from typing import Any

import numpy as np

from pytest_lpb.environment.observation import Observation
from pytest_lpb.planner.base import Planner, PlannerProblem
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.loop import checked_action
from pytest_lpb.trial.outcome import DEADLINE, INFEASIBLE, PLANNER_ERROR

RAISED = (INFEASIBLE, PLANNER_ERROR, DEADLINE)  # the last call of such a trial raised, or gave no action


class Replay:
    """The calls of one recorded trial.

    The environment's own `Observation` is filled with the recorded states, so a planner sees what it saw: goals,
    obstacles and previews included.

    Args:
        trajectory: the trial's raw data.
        configuration: the planner that made them.
    """

    def __init__(self, trajectory: Trajectory, configuration: PlannerConfiguration) -> None:
        problem = trajectory.problem
        every, self._delay = configuration.steps_per_call(problem.dt), configuration.steps_of_delay(problem.dt)
        self.seed: int = trajectory.metadata["seed"]
        self.period_ms = 1000.0 * every * problem.dt
        called = np.flatnonzero(~np.isnan(trajectory.solver_wall_ms)).tolist()
        # What raised is no computation of an action.
        self.rows: list[int] = called[:-1] if trajectory.outcome in RAISED else called
        self._parameters = configuration.parameters_for(problem.robot.name, problem.control)
        self._problem, self._period = problem, every * problem.dt
        self._states = [trajectory.q.tolist(), trajectory.qd.tolist(), trajectory.u.tolist()]
        self._actions = trajectory.action
        preview = configuration.preview_for(self._parameters)
        self._observation = Observation(problem, preview, len(problem.obstacles))

    def set_up(self, planner: Planner) -> None:
        """Have a planner forget everything, as before the trial."""
        planner.parameters = self._parameters
        planner.diagnostics = {}
        planner.setup(PlannerProblem.of(self._problem, self._period))

    def observation(self, row: int) -> dict[str, Any]:
        """What the planner saw at a row; the arrays are read-only, and filled again by the next call."""
        q, qd, u = (states[row] for states in self._states)
        self._observation.update(row, q, qd, u)
        return dict(self._observation.views)

    def observations(self) -> Iterator[dict[str, Any]]:
        """What the planner saw, call by call."""
        return map(self.observation, self.rows)

    def recorded_action(self, row: int) -> list[float] | None:
        """The action of the call at a row, (n_actions,); None where the trial ended before it acted."""
        acted = row + self._delay
        if acted >= len(self._actions):
            return None
        action: list[float] = self._actions[acted].tolist()
        return None if any(map(isnan, action)) else action

    def is_recorded(self, row: int, result: Any) -> bool:
        """Whether a call's result equals the recorded action to the last bit; true where none was recorded.

        Raises PlannerError for a result that is no action.
        """
        expected = self.recorded_action(row)
        action = checked_action(result, self._problem.robot.n_actions)
        return expected is None or np.array(action).tobytes() == np.array(expected).tobytes()
