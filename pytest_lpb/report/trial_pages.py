"""The pages of single trials: the index that the page's script reads, and their replays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.known_failures import reasons
from pytest_lpb.report.numbers import count, show
from pytest_lpb.report.origins import origins
from pytest_lpb.report.overview import endings
from pytest_lpb.report.packing import packed
from pytest_lpb.report.replay.blocks import Replays, replays
from pytest_lpb.report.titles import value_title
from pytest_lpb.report.trial_section import listed_trials
from pytest_lpb.report.view import PlannerStyle, TrialPages


def trial_pages(data: ReportData, styles: Mapping[str, PlannerStyle]) -> TrialPages | None:
    """The pages of all trials of the table; None without trials."""
    trials, _ = listed_trials(data)
    if trials.empty:
        return None
    made = replays(data, trials)
    return TrialPages(
        index=packed(index(data, trials, styles)),
        replays=list(made.blocks.items()),
        note=_note(made, len(trials)),
        spatial=made.spatial,
    )


def index(data: ReportData, trials: pd.DataFrame, styles: Mapping[str, PlannerStyle]) -> dict[str, Any]:
    """Planners, scenarios, KPIs; and of each trial its id, their places, seed, outcome, problem, KPIs as text,
    why it was known to fail, and what it is in which run."""
    planners, scenarios = list(styles), [str(name) for name in dict.fromkeys(trials["scenario"])]
    kpis = [kpi for kpi in data.kpis if kpi.name in trials]
    problems = {str(text): place for place, text in enumerate(dict.fromkeys(trials["problem_hash"].fillna("")))}
    medians = {
        (str(row["planner"]), str(row["scenario"])): [show(row.get(f"{kpi.name}_median")) for kpi in kpis]
        for row in data.summary.to_dict("records")
    }
    rows = trials.assign(outcome=endings(trials), known_failure=reasons(trials)).to_dict("records")
    runs, places = origins(data, rows)
    return {
        "runs": runs,
        "planners": [
            {"name": style.name, "colour": style.colour, "dash": style.dash, "number": style.number}
            for style in styles.values()
        ],
        "scenarios": scenarios,
        "kpis": [[kpi.group, value_title(kpi)] for kpi in kpis],
        "medians": [[medians.get((planner, scenario)) for scenario in scenarios] for planner in planners],
        "trials": [
            [
                str(row["node_id"]),
                scenarios.index(str(row["scenario"])),
                planners.index(str(row["planner"])),
                int(row["seed"]),
                str(row["outcome"]),
                problems["" if pd.isna(row["problem_hash"]) else str(row["problem_hash"])],
                [show(row[kpi.name]) for kpi in kpis],
                row["known_failure"],
                *place,
            ]
            for row, place in zip(rows, places, strict=True)
        ],
    }


def _note(made: Replays, trials: int) -> str:
    told = f"{len(made.places)} of {count(trials, 'trial')} have time series and a replay here"
    which = "the first problem of every scenario, then failures, then the rest, as far as a small page allows"
    faults = f" Raw data that cannot be read: {'; '.join(made.faults)}." if made.faults else ""
    return f"{told}: {which}.{faults}" if len(made.places) < trials else faults.strip()
