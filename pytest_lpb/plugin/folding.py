"""pytest's section FAILURES: of trials that ended by the same fault one is shown in full, the others are named."""

from __future__ import annotations

import json
from collections.abc import Generator
from typing import Any

import pytest

from pytest_lpb.plugin.worker import REPORT_ATTRIBUTE
from pytest_lpb.run.faults import FAULTS, fault_key

MAX_NAMED = 10  # other trials that a failure names
SHOW_ALL = 2  # -vv


class FoldingPlugin:
    """Folds equal failures just before pytest prints them; what other plugins have written of them stays."""

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_terminal_summary(
        self, terminalreporter: pytest.TerminalReporter, config: pytest.Config
    ) -> Generator[None, object, object]:
        """Fold the failures, unless `-vv` asks for all."""
        if config.option.verbose < SHOW_ALL:
            fold(terminalreporter.stats.get("failed", []))
        return (yield)


def fold(reports: list[Any]) -> None:
    """Have the first of equal failures name the others, which are not shown by themselves."""
    groups: dict[tuple[str, str, str], list[Any]] = {}
    for report in reports:
        result = json.loads(getattr(report, REPORT_ATTRIBUTE, None) or "{}")
        if result.get("outcome") in FAULTS and isinstance(report.longrepr, str):
            key = fault_key(result["planner"], result["outcome"], result["message"])
            groups.setdefault(key, []).append(report)
    for first, *others in groups.values():
        if others:
            first.longrepr = f"{first.longrepr}\n\n{_named([report.nodeid for report in others])}"
        for report in others:
            report._pdbshown = True  # pytest's mark of a failure that has been shown


def _named(node_ids: list[str]) -> str:
    lines = [f"  {node_id}" for node_id in node_ids[:MAX_NAMED]]
    if node_ids[MAX_NAMED:]:
        lines.append(f"  and {len(node_ids) - MAX_NAMED} more")
    what = "1 other trial" if len(node_ids) == 1 else f"{len(node_ids)} other trials"
    return "\n".join([f"{what} ended by the same fault (-vv shows each):", *lines])
