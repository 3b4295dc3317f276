"""Hooks of every process that runs trials: a trial's result travels on its report."""

from __future__ import annotations

import json
from collections.abc import Generator

import pytest

from pytest_lpb.plugin.items import TrialItem
from pytest_lpb.plugin.junit import add_properties
from pytest_lpb.trial.loop import shortened

REPORT_ATTRIBUTE = "lpb"  # one JSON string: it crosses xdist and leaves junit files as they are

SKIP_ATTRIBUTE = "lpb_skipped"  # as JSON: scenario, planner and seed of a trial that its planner does not support


class WorkerPlugin:
    """Attaches the result of a trial to its report."""

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Add outcome and message to the report of a trial's call."""
        report = yield
        if isinstance(item, TrialItem):
            # What a planner prints travels with the report, and is printed when its trial fails.
            report.sections = [(title, shortened(text)) for title, text in report.sections]
        if isinstance(item, TrialItem) and item.unsupported and report.skipped:
            # The scenario is where it is from, not the line that skips.
            report.longrepr = (str(item.path), 1, f"Skipped: {item.collector.name}: {item.unsupported}")
            setattr(report, SKIP_ATTRIBUTE, json.dumps(item.key))
        if isinstance(item, TrialItem) and call.when == "call" and item.trajectory is not None:
            metadata = item.trajectory.metadata
            result = {
                "scenario": metadata["scenario"],
                "planner": metadata["planner"],
                "seed": metadata["seed"],
                "outcome": metadata["outcome"],
                "success": metadata["success"],
                "message": metadata["message"],
                "node_id": metadata["node_id"],
                "command": metadata["command"],
            }
            setattr(report, REPORT_ATTRIBUTE, json.dumps(result))
            if getattr(item.config.option, "xmlpath", None):
                add_properties(item, item.trajectory)
            item.trajectory = None
        return report
