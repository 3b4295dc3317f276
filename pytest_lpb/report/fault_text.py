"""Faults of trials for the terminal and the report: equal ones as one, the cause first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.view import PlannerStyle
from pytest_lpb.run.faults import FaultGroup, fault_groups

MAX_GROUPS = 20  # that are named


def fault_lines(trials: Iterable[Mapping[Any, Any]]) -> Iterator[str]:
    """Two lines per fault: how many trials, of which planner, ended by what; and what repeats the first of them.

    Args:
        trials: with planner, outcome, message, node_id and command each.
    """
    groups = fault_groups(trials)
    for group in groups[:MAX_GROUPS]:
        yield group.line
        yield f"  repeat{' the first' if len(group.node_ids) > 1 else ''}: {group.command}"
    if groups[MAX_GROUPS:]:
        yield f"... and {len(groups) - MAX_GROUPS} more faults; the report lists them"


@dataclass(frozen=True)
class FaultSection:
    """Faults as the report's overview shows them."""

    groups: list[tuple[PlannerStyle, FaultGroup]]


def fault_section(data: ReportData, styles: Mapping[str, PlannerStyle]) -> FaultSection | None:
    """Faults of the run; None without any."""
    columns = ["planner", "outcome", "message", "node_id", "command"]
    groups = fault_groups(data.trials[columns].to_dict("records")) if len(data.trials) else []
    return FaultSection([(styles[group.planner], group) for group in groups]) if groups else None
