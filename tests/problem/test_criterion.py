"""Bounds on KPIs."""

from math import nan

import pytest

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.criterion import parse_criterion


@pytest.mark.parametrize(
    ("text", "met", "missed"),
    [(">= 0.5", 0.5, 0.49), ("<= -1e-3", -0.001, 0.0), ("> 2", 2.1, 2.0), (" <3 ", 2.9, 3.0), (">= .5", 0.5, 0.4)],
)
def test_comparisons(text: str, met: float, missed: float) -> None:
    criterion = parse_criterion(text)
    assert criterion.met(met)
    assert not criterion.met(missed)
    assert not criterion.met(nan)
    assert parse_criterion(str(criterion)) == criterion


@pytest.mark.parametrize("text", ["0.5", "== 1", ">= x", ">= 1 m", ">= nan", ">= 1e999", "", ">= 1_0"])
def test_no_criterion(text: str) -> None:
    with pytest.raises(ScenarioError, match="a criterion is < <= > or >= and a number"):
        parse_criterion(text)
