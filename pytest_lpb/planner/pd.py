"""Proportional-derivative law towards the goal, in task or joint space. It does not look at obstacles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.planner.task import SUPPORTED, Task, check_control, damped_inverse

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]


class PD(Planner):
    """action = p e + k de: e is the goal's error, brought from the sub-goals' spaces to the actuated velocities.

    A joint goal gives the law in joint space. Redundant joints, which the goal says nothing about, are damped by k.
    """

    name: ClassVar[str] = "pd"
    supports: ClassVar[Mapping[str, tuple[str, ...]]] = SUPPORTED

    @dataclass(frozen=True)
    class Parameters:
        """Gains of the law; `derivative: difference` is localPlannerBench's, with e_previous = 0 at the first call."""

        p: Finite = 1.0  # [1/s^2]; velocity control: [1/s]
        k: Finite = 2.0  # [1/s]; velocity control: [-], below 1 for the law to be stable
        derivative: Literal["velocity", "difference"] = "velocity"
        damping: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] = (
            0.1  # of the inverse Jacobian [m]; must be above 0 where an arm can be singular
        )
        lookahead: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] = (
            0.3  # a non-holonomic base is steered by the point this far ahead of it [m]
        )

    parameters: Parameters

    def setup(self, problem: PlannerProblem) -> None:
        """Compose the task of the problem's goal."""
        check_control(self.name, problem)
        self._task = Task(problem, self.parameters.lookahead)
        self._difference = self.parameters.derivative == "difference"
        self._previous: FloatArray | float = 0.0
        self._period = problem.period

    def compute_action(self, observation: Observation) -> FloatArray:
        """The law's action, (n_actions,)."""
        if self._task.direct:
            error = observation["goal_position"] - observation["q"]
            velocity = observation["qd"]
        else:
            error, jacobian = self._task.error(observation)
            inverse = damped_inverse(jacobian, self.parameters.damping)
            error, velocity = inverse @ error, self._task.actuation.inputs(observation)
        if self._difference:
            derivative = (error - self._previous) / self._period
            self._previous = error
        else:
            derivative = -velocity
        action: FloatArray = self.parameters.p * error + self.parameters.k * derivative
        return self._task.actuation.command(action, observation)
