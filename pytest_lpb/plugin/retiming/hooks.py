"""Tests that time recorded calls with pytest-benchmark: each is one pass of one planner in one scenario.

The passes of a planner in a scenario become one benchmark in the JSON.
"""

from __future__ import annotations

from typing import Any, cast

import pytest
from pytest_benchmark.stats import Stats

from pytest_lpb.retime.figures import RetimedRow
from pytest_lpb.retime.job import Key
from pytest_lpb.retime.result import OWN_KEY, own_part
from pytest_lpb.retime.session import RetimingSession
from pytest_lpb.retime.timed import Timed


class RetimingPlugin:
    """Makes the tests, and joins what they measure."""

    def __init__(self, session: RetimingSession) -> None:
        self._session = session
        self._faults: list[str] = []

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """One test per pass, in the job's order."""
        order = self._session.job.order()
        ids = [f"{scenario}::{planner} pass {number + 1}" for (scenario, planner), number in order]
        metafunc.parametrize("key", [key for key, _ in order], ids=ids)

    @pytest.fixture
    def timed(self, key: Key) -> Timed:
        """A planner in a scenario."""
        return self._session.timed(key)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keep what a planner raised while it was timed."""
        if report.failed:
            name = report.nodeid.partition("[")[2].rstrip("]")
            crash = getattr(report.longrepr, "reprcrash", None)
            reason = str(report.longrepr) if crash is None else str(crash.message)
            self._faults.append(f"{name}: {reason.splitlines()[0]}")

    def pytest_benchmark_update_machine_info(self, machine_info: dict[str, Any]) -> None:
        """Leave the machine's name out: the file travels with the run folder."""
        machine_info["node"] = ""

    def pytest_benchmark_update_json(self, output_json: dict[str, Any]) -> None:
        """Join the passes of each planner in a scenario to one benchmark, with figures of our own."""
        entries = {tuple(entry["extra_info"]["key"]): entry for entry in output_json["benchmarks"]}
        rows = [(key, timed, row) for key, timed in self._session.finished if (row := timed.row()) is not None]
        output_json["benchmarks"] = [_joined(entries[key], timed, row) for key, timed, row in rows]
        warnings = [*self._session.warnings, *self._faults]
        output_json[OWN_KEY] = own_part([row for *_, row in rows], warnings)


def _joined(entry: dict[str, Any], timed: Timed, row: RetimedRow) -> dict[str, Any]:
    stats = cast(Any, Stats)()
    for time in timed.calls_s():
        stats.update(time)
    return {
        **entry,
        "group": row.scenario,
        "name": row.planner,
        "fullname": f"{row.scenario}::{row.planner}",
        "param": None,
        "params": None,
        "extra_info": row.to_dict(),
        "stats": {**stats.as_dict(), "iterations": 1},
    }
