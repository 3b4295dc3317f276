"""Says now and then how many trials are done, and how long the rest will take."""

from __future__ import annotations

from time import monotonic

import pytest

INTERVAL_S = 5.0  # between lines on a terminal
INTERVAL_LOG_S = 30.0  # between lines in a log file


class Progress:
    """Counts finished trials.

    Args:
        reporter: pytest's terminal reporter.
    """

    def __init__(self, reporter: pytest.TerminalReporter) -> None:
        self._reporter = reporter
        self._interval = INTERVAL_S if reporter.isatty else INTERVAL_LOG_S
        self._started = self._spoken = monotonic()
        self._total = 0
        self._done = 0
        self._failed = 0

    def start(self, total: int) -> None:
        """Begin to count towards `total` trials."""
        self._total = total
        self._started = self._spoken = monotonic()

    def count(self, *, success: bool) -> None:
        """One more trial is done."""
        self._done += 1
        self._failed += not success
        now = monotonic()
        if now - self._spoken >= self._interval and self._done < self._total:
            self._spoken = now
            self._reporter.ensure_newline()
            self._reporter.write_line(self.text(now - self._started))

    def text(self, elapsed_s: float) -> str:
        """The line for now, such as `lpb: 120 of 1000 trials, 8 unsolved, 2:31 left`."""
        left = elapsed_s / self._done * (self._total - self._done)
        return (
            f"lpb: {self._done} of {self._total} trials, {self._failed} unsolved, "
            f"{int(left) // 60}:{int(left) % 60:02d} left"
        )
