"""What built-in planners can work with: the shapes and types of sub-goals that are built in, not those of users."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.names import listed
from pytest_lpb.planner.base import PlannerProblem
from pytest_lpb.problem.registries import GOALS, SHAPES


def check_goals(planner: str, problem: PlannerProblem) -> None:
    """Raise ConfigurationError for a type of sub-goal that a user has registered."""
    _check(f"{planner} has no law for sub-goals of type", (goal.type for goal in problem.goal), GOALS)


def check_shapes(planner: str, problem: PlannerProblem) -> None:
    """Raise ConfigurationError for a shape that a user has registered."""
    found = (obstacle.shape for obstacle in problem.obstacles)
    _check(f"{planner} knows no distance to obstacles of shape", found, SHAPES[problem.dimension])


def _check(what: str, found: Iterable[str], known: Sequence[str]) -> None:
    for name in found:
        if name not in known:
            raise ConfigurationError(f"{what} {name!r}; it has {listed(known)}")
