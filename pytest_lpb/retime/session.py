"""State of the process that times recorded calls again. Knows nothing of pytest."""

from __future__ import annotations

from contextlib import ExitStack

from threadpoolctl import threadpool_limits

from pytest_lpb.retime.job import Job, Key
from pytest_lpb.retime.timed import Timed
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.recorded_planners import recorded_planners


class RetimingSession:
    """Planners of one scenario at a time, as in a run with one thread for linear algebra.

    Args:
        job: what to time.

    Raises LpbError when a planner cannot be loaded, or a trial cannot be read.
    """

    def __init__(self, job: Job) -> None:
        self.job = job
        names = dict.fromkeys(planner for _, planner in job.keys)
        self._planners, self.warnings = recorded_planners(RunFolder.open(job.run), names, trusted=job.trusted)
        self._stack = ExitStack()
        self._stack.enter_context(threadpool_limits(limits=1))
        self._open: dict[Key, Timed] = {}
        self.finished: list[tuple[Key, Timed]] = []

    def timed(self, key: Key) -> Timed:
        """A planner in a scenario, ready for its next pass; planners of other scenarios are closed."""
        if any(scenario != key[0] for scenario, _ in self._open):
            self._close_all()
        if key not in self._open:
            timed = Timed(self.job, key, self._planners[key[1]])
            self.warnings += timed.warnings
            self._open[key] = timed
            self.finished.append((key, timed))
        return self._open[key]

    def _close_all(self) -> None:
        for timed in self._open.values():
            timed.close()
        self._open.clear()

    def close(self) -> None:
        """Close all planners."""
        self._close_all()
        self._stack.close()
