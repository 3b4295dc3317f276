"""Trials that planners do not support, neither failed nor missing. Each leaves a small file where its data would be."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path

import pandas as pd

from pytest_lpb.bounded import read_bounded
from pytest_lpb.documents.atomic import write_once
from pytest_lpb.errors import RecordingError
from pytest_lpb.names import count
from pytest_lpb.run.plan import TrialKey, as_ranges
from pytest_lpb.trial.files import trial_path

SKIPPED_FILE = "skipped.csv"
SUFFIX = ".skipped"
MAX_REASON_BYTES = 10_000
MAX_LINES = 10  # of planners and reasons that are named


def write_skip(run: Path, trial: TrialKey, reason: str) -> None:
    """Note why a trial is skipped. Raises RecordingError when that cannot be written."""
    text = reason.encode()[:MAX_REASON_BYTES].decode(errors="ignore")
    write_once(trial_path(run, *trial).with_suffix(SUFFIX), f"{text}\n".encode())


def skip_files(run: Path) -> list[Path]:
    """Files of trials that were skipped, in the order of their paths."""
    return sorted(path for path in (run / "trials").rglob(f"seed*{SUFFIX}") if path.is_file())


def skipped_trials(run: Path) -> dict[TrialKey, str]:
    """Trials that were skipped, with the reason. Files of other names are left alone."""
    found = {}
    for path in skip_files(run):
        seed = path.stem.removeprefix("seed")
        if seed.isdecimal() and not trial_path(run, *(key := _key(run, path, int(seed)))).exists():
            found[key] = _reason(path)
    return found


def _key(run: Path, path: Path, seed: int) -> TrialKey:
    place = path.relative_to(run / "trials")
    return TrialKey(place.parent.parent.as_posix(), place.parent.name, seed)


def _reason(path: Path) -> str:
    try:
        return read_bounded(path, MAX_REASON_BYTES + 1, RecordingError).decode(errors="replace").strip()
    except RecordingError as error:
        return f"the reason cannot be read: {error}"


def skipped_table(skipped: Mapping[TrialKey, str]) -> pd.DataFrame:
    """skipped.csv: a row per scenario, planner and reason with the number of trials, and their seeds in short."""
    seeds: dict[tuple[str, str, str], list[int]] = defaultdict(list)
    for trial, reason in skipped.items():
        seeds[trial.scenario, trial.planner, reason].append(trial.seed)
    rows = [
        (scenario, planner, len(numbers), as_ranges(numbers), reason)
        for (scenario, planner, reason), numbers in sorted(seeds.items())
    ]
    return pd.DataFrame(rows, columns=["scenario", "planner", "skipped", "seeds", "reason"])


def skipped_notes(skipped: Mapping[TrialKey, str]) -> Iterator[str]:
    """In words: how many trials of which planner were skipped and why; nothing when none was."""
    counts: dict[tuple[str, str], int] = defaultdict(int)
    for trial, reason in skipped.items():
        counts[trial.planner, reason] += 1
    groups = sorted(counts.items(), key=lambda group: (-group[1], group[0]))
    for (planner, reason), number in groups[:MAX_LINES]:
        yield f"skipped: {count(number, 'trial')} of {planner}, not counted in its figures: {reason}"
    if groups[MAX_LINES:]:
        yield f"... and {len(groups) - MAX_LINES} more planners and reasons; {SKIPPED_FILE} lists them all"
