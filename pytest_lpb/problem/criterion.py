"""Criteria of success: bounds on KPIs, such as `>= 0.02`."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from typing import NamedTuple

from pytest_lpb.errors import ScenarioError

_OPERATORS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
CRITERION = re.compile(r"(<=|>=|<|>)[ ]*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)")


class Criterion(NamedTuple):
    """A bound on a KPI: `value operator number` must hold."""

    operator: str  # one of < <= > >=
    number: float

    def __str__(self) -> str:
        return f"{self.operator} {self.number!r}"

    def met(self, value: float) -> bool:
        """Whether a value is within the bound; NaN never is."""
        return _OPERATORS[self.operator](value, self.number)


def parse_criterion(text: str) -> Criterion:
    """Parse a criterion such as `>= 0.02`.

    Raises:
        ScenarioError: the text is not an operator and a finite number.
    """
    match = CRITERION.fullmatch(text.strip())
    if not match or abs(number := float(match[2])) > 1e300:
        raise ScenarioError(
            f"found the text {text[:60]!r}; a criterion is < <= > or >= and a number, such as '>= 0.02'"
        )
    return Criterion(match[1], number)
