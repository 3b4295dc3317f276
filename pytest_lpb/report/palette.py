"""One look per planner in every figure: a colour safe for colour-blind readers, a dash and a marker."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from pytest_lpb.report.view import PlannerStyle

if TYPE_CHECKING:
    from pytest_lpb.report.data import ReportData

# After Okabe and Ito (2008), darker where they are too pale for a white page; style.css holds both themes.
COLOURS = ("#0072b2", "#c44e00", "#008060", "#a8478a", "#8f6a00", "#3a3fb5", "#4a4a4a", "#b3123c")
DASHES = ("", "7 3", "2 3", "8 3 2 3", "12 4 2 4 2 4")
MARKERS = (
    "M-5 0a5 5 0 1 0 10 0a5 5 0 1 0-10 0Z",
    "M-4.5-4.5h9v9h-9Z",
    "M0-6L5.5 4.5h-11Z",
    "M0-6.5L6 0L0 6.5L-6 0Z",
    "M0 6L5.5-4.5h-11Z",
    "M-2-6h4v4h4v4h-4v4h-4v-4h-4v-4h4Z",
    "M0-6L5.7-1.9L3.5 4.9h-7L-5.7-1.9Z",
)


def styles_of(data: ReportData) -> dict[str, PlannerStyle]:
    """The styles of a run's planners: in the report and in the plots' files the same."""
    return planner_styles([*(data.run_info.get("planners") or {}), *data.trials["planner"]])


def planner_styles(names: Iterable[str]) -> dict[str, PlannerStyle]:
    """A style for each planner, in order of first mention; 40 planners differ in colour or dash."""
    return {
        name: PlannerStyle(name, i, i % len(COLOURS), DASHES[i % len(DASHES)], MARKERS[i % len(MARKERS)])
        for i, name in enumerate(dict.fromkeys(names))
    }
