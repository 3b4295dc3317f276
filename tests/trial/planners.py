"""Planners that do one thing each, most of them wrong."""

import sys
from dataclasses import dataclass
from typing import Any

import numpy as np

from pytest_lpb.errors import Infeasible
from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.problem.preview import Preview

FAULT_AT = 0.3  # [s]


class Still(Planner):
    """Asks for nothing."""

    def compute_action(self, observation: Observation) -> FloatArray:
        return np.zeros(2)


class Constant(Planner):
    """Always the same action, as a list."""

    @dataclass(frozen=True)
    class Parameters:
        action: tuple[float, ...] = (1.0, 0.0)  # [m/s^2 or m/s]

    def compute_action(self, observation: Observation) -> Any:
        return list(self.parameters.action)


class Clock(Planner):
    """Its action says when it was asked; keeps what it saw."""

    def setup(self, problem: PlannerProblem) -> None:
        self.calls = 0
        self.period = problem.period

    def compute_action(self, observation: Observation) -> FloatArray:
        self.calls += 1
        self.diagnostics = {"calls": self.calls}
        if self.calls % 2:
            self.diagnostics["odd"] = float(np.float32(self.calls))
        return np.array([observation["t"] + 1.0, -1.0])


class Counting(Planner):
    """Never forgets a trial: its actions grow from one to the next."""

    def __init__(self, parameters: Any = None) -> None:
        super().__init__(parameters)
        self.trials = 0

    def setup(self, problem: PlannerProblem) -> None:
        self.trials += 1

    def compute_action(self, observation: Observation) -> FloatArray:
        return np.array([float(self.trials), 0.0])


class Faulty(Planner):
    """Moves, then goes wrong in the way its parameter names."""

    @dataclass(frozen=True)
    class Parameters:
        fault: str = "raise"

    def compute_action(self, observation: Observation) -> Any:
        if observation["t"] < FAULT_AT - 1e-9:
            return np.array([1.0, 0.0])
        return getattr(self, self.parameters.fault)(observation)

    def raises(self, observation: Observation) -> Any:
        raise KeyError("no\nsuch thing")

    def raises_nothing_said(self, observation: Observation) -> Any:
        raise RuntimeError

    def infeasible(self, observation: Observation) -> Any:
        raise Infeasible("no way around")

    def leaves(self, observation: Observation) -> Any:
        sys.exit(3)

    def forgets(self, observation: Observation) -> Any:
        return None

    def too_long(self, observation: Observation) -> Any:
        return np.zeros(3)

    def column(self, observation: Observation) -> Any:
        return np.zeros((2, 1))

    def number(self, observation: Observation) -> Any:
        return 1.0

    def not_finite(self, observation: Observation) -> Any:
        return np.array([np.nan, 0.0])

    def text(self, observation: Observation) -> Any:
        return "left"

    def texts(self, observation: Observation) -> Any:
        return ["1.0", "2.0"]

    def complex_numbers(self, observation: Observation) -> Any:
        return np.array([1j, 0.0])

    def booleans(self, observation: Observation) -> Any:
        return [True, False]

    def ragged(self, observation: Observation) -> Any:
        return [[1.0], [1.0, 2.0]]

    def writes(self, observation: Observation) -> Any:
        observation["q"][0] = 9.0
        return np.zeros(2)

    def diagnoses_text(self, observation: Observation) -> Any:
        self.diagnostics = {"state": "fine"}  # type: ignore[dict-item] # the fault
        return np.zeros(2)

    def diagnoses_a_list(self, observation: Observation) -> Any:
        self.diagnostics = [1.0]  # type: ignore[assignment] # the fault
        return np.zeros(2)

    def diagnoses_an_array(self, observation: Observation) -> Any:
        self.diagnostics = {"all": np.zeros(3)}  # type: ignore[dict-item] # the fault
        return np.zeros(2)


class WholeNumbers(Planner):
    """Returns an array of integers, which are real numbers."""

    def compute_action(self, observation: Observation) -> Any:
        return np.array([2, -1])


class Untidy(Planner):
    """Changes the dictionary it is given: that must not come back to it."""

    def compute_action(self, observation: Any) -> FloatArray:
        fresh = observation["q"]
        observation["q"] = np.full(2, 7.0)
        del observation["t"]
        observation["mine"] = 1.0
        return np.array([1.0 + fresh[0], 0.0])


class BadSetup(Planner):
    """Cannot set up."""

    def setup(self, problem: PlannerProblem) -> None:
        raise ValueError("no solver")


class InfeasibleSetup(Planner):
    """Finds in its setup that there is no way."""

    def setup(self, problem: PlannerProblem) -> None:
        raise Infeasible("boxed in")


class BadConstructor(Planner):
    """Cannot be built."""

    def __init__(self, parameters: Any = None) -> None:
        raise OSError("library missing")


class Leaving(Planner):
    """Leaves in its constructor."""

    def __init__(self, parameters: Any = None) -> None:
        sys.exit("bye")


class Abstract(Planner):
    """Defines nothing."""


class Foreseeing(Planner):
    """Wants to see the future."""

    preview = Preview(steps=2, step_s=0.5)

    def compute_action(self, observation: Observation) -> FloatArray:
        shape = observation["obstacle_position_preview"].shape
        return np.array([float(shape[1]), 0.0])
