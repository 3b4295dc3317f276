"""Whether a planner takes a problem: what its method `supports` says."""

from __future__ import annotations

from typing import Any

import numpy as np

NO_REASON = "its method `supports` says so"


def refusal(planner: Any, problem: Any) -> str:
    """Why a planner does not take a problem; empty when it does.

    Its `supports(problem)` returns True, False, or the reason as text; without such a method it takes any problem.
    Raises TypeError for other answers.
    """
    __tracebackhide__ = True  # a debugger stops where the planner was asked
    supports = getattr(planner, "supports", None)
    if not callable(supports):
        return ""
    answer = supports(problem)
    if isinstance(answer, (bool, np.bool_)):
        return "" if answer else NO_REASON
    if isinstance(answer, str) and answer.strip():
        return answer.strip()
    raise TypeError("supports(problem) returned " + repr(answer) + "; allowed: True, False, or the reason as text")


def declaration(cls: Any) -> Any:
    """What a class declares by its attribute `supports`; nothing where that is a method."""
    declared = getattr(cls, "supports", None)
    return (
        {} if declared is None or callable(declared) or isinstance(declared, (classmethod, staticmethod)) else declared
    )
