"""Where the numbers come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pytest_lpb.report.view.common import Fact, PlannerStyle


@dataclass(frozen=True)
class PlannerSetup:
    """A planner's configuration as it ran."""

    style: PlannerStyle
    planner: str
    parameters: str
    facts: Sequence[Fact]


@dataclass(frozen=True)
class Provenance:
    """Where the numbers come from."""

    facts: Sequence[Fact]
    planners: Sequence[PlannerSetup]
    packages: Sequence[Fact]
    scenarios: Sequence[Fact]
