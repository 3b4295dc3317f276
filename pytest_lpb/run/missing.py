"""The trials that a run was to have, and has not: what tables and reports say of them."""

from __future__ import annotations

import os
import shlex
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from pytest_lpb.run.plan import TrialKey, as_ranges, trials_of

MISSING_FILE = "missing.csv"
MAX_LINES = 10  # of scenarios and planners that are named


def missing_trials(info: Mapping[str, Any], trials: pd.DataFrame) -> list[TrialKey]:
    """Planned trials without a row, in order; none for a run whose run.json has no plan."""
    there = set(zip(trials["scenario"], trials["planner"], trials["seed"], strict=True))
    return sorted(trials_of(info.get("planned") or {}) - there)


def missing_table(missing: Collection[TrialKey]) -> pd.DataFrame:
    """missing.csv: a row per scenario and planner with how many trials are missing, and their seeds in short."""
    rows = [(*where, len(seeds), as_ranges(seeds)) for where, seeds in sorted(_seeds(missing).items())]
    return pd.DataFrame(rows, columns=["scenario", "planner", "missing", "seeds"])


def missing_notes(missing: Collection[TrialKey], present: int, resume: str) -> Iterator[str]:
    """In words: how many trials there are, how to run the others, and which those are; nothing when none is missing.

    Args:
        missing: the trials that are not there.
        present: how many are there.
        resume: the command that runs the others; empty: none does.
    """
    if not missing:
        return
    advice = f"; run the others with: {resume}" if resume else ""
    yield f"{present} of {present + len(missing)} trials were run{advice}"
    groups = sorted(_seeds(missing).items())
    for (scenario, planner), seeds in groups[:MAX_LINES]:
        yield f"missing: {scenario} :: {planner} :: seed {as_ranges(seeds)}"
    if len(groups) > MAX_LINES:
        yield f"... and {len(groups) - MAX_LINES} more scenarios and planners; {MISSING_FILE} lists them all"


def resume_command(run: Path, info: Mapping[str, Any]) -> str:
    """The command that finishes a run, for the folder that it was started in."""
    start = Path(info.get("invocation") or "")
    shown = Path(os.path.relpath(run, start)) if start.is_absolute() and run.is_relative_to(start) else run
    return shlex.join(["pytest", f"--lpb-resume={shown}"])


def _seeds(missing: Collection[TrialKey]) -> Mapping[tuple[str, str], list[int]]:
    found: dict[tuple[str, str], list[int]] = defaultdict(list)
    for trial in missing:
        found[trial.scenario, trial.planner].append(trial.seed)
    return found
