"""Owns the planner instance that runs all trials of a scenario."""

from __future__ import annotations

import sys

from pytest_lpb.errors import PlannerError, in_one_line
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.trial.debugger import is_quit
from pytest_lpb.trial.guard import MODULE_SEARCH_PATH, UserInterruptError, guarded


class PlannerHolder:
    """Builds a planner when it is first asked for, and closes it.

    Args:
        configuration: which planner.

    Attributes:
        error: what the planner raised in the last trial, with its frames; None if nothing.
    """

    def __init__(self, configuration: PlannerConfiguration) -> None:
        self.error: BaseException | None = None
        self._configuration = configuration
        self._planner: Planner | None = None
        self._search_path: list[str] = []

    def get(self) -> Planner:
        """The planner; whatever its constructor raises passes through, UserInterruptError for Ctrl-C."""
        if self._planner is None:
            self._search_path = list(sys.path)
            # What a constructor adds to the search path holds until the planner is closed: it may import later.
            try:
                with guarded(0, keep=(MODULE_SEARCH_PATH,)):
                    self._planner = self._configuration.build()
            except BaseException:
                sys.path[:] = self._search_path
                raise
        return self._planner

    def close(self) -> None:
        """Close the planner, if it was built. Raises PlannerError when the planner does."""
        planner, self._planner, self.error = self._planner, None, None
        if planner is None:
            return
        try:
            with guarded(0):
                planner.close()
        except UserInterruptError:
            raise
        except BaseException as error:
            if is_quit(error):
                raise
            # Its trials are done: whatever it raises is told, and ends nothing.
            raise PlannerError(f"close of planner {self._configuration.name!r} raised: {in_one_line(error)}") from error
        finally:
            sys.path[:] = self._search_path
