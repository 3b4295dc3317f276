"""Owns the planner instance that runs all trials of a scenario."""

from __future__ import annotations

from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.configuration import PlannerConfiguration


class PlannerHolder:
    """Builds a planner when it is first asked for, and closes it.

    Args:
        configuration: which planner.
    """

    def __init__(self, configuration: PlannerConfiguration) -> None:
        self._configuration = configuration
        self._planner: Planner | None = None

    def get(self) -> Planner:
        """The planner; whatever its constructor raises passes through."""
        if self._planner is None:
            self._planner = self._configuration.build()
        return self._planner

    def close(self) -> None:
        """Close the planner, if it was built."""
        planner, self._planner = self._planner, None
        if planner is not None:
            planner.close()
