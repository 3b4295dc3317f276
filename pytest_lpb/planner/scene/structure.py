"""What composed functions are kept by: equal structures share them."""

from __future__ import annotations

import dataclasses
from typing import Any

from pytest_lpb.planner.base import PlannerProblem
from pytest_lpb.planner.scene.layout import capacities
from pytest_lpb.problem.hashing import canonical_json


class Structure:
    """What a composed function depends on, equal for equal structures; carries what composing takes.

    Args:
        problem: what the planner was told.
        parameters: of the planner.
        further: what else it depends on, in JSON's own types.
    """

    def __init__(self, problem: PlannerProblem, parameters: Any, further: Any = None) -> None:
        self.problem = problem
        self.parameters = parameters
        self.capacities = capacities(problem.obstacles)
        goals = [
            [goal.type, goal.link, goal.size, goal.weight, goal.tolerance is None, *sorted(_asked(goal.entry).items())]
            for goal in problem.goal
        ]
        asked = dataclasses.asdict(parameters)
        self._text = canonical_json([problem.robot.hashed(), goals, self.capacities, asked, further])

    def __hash__(self) -> int:
        return hash(self._text)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Structure) and self._text == other._text


def _asked(entry: Any) -> dict[str, Any]:
    """What of a sub-goal's entry its error depends on."""
    return {key: value for key, value in entry.items() if key not in ("name", "tolerance", "weight", "primary")}
