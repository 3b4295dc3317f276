"""Which trials of a run are run again."""

from __future__ import annotations

from collections.abc import Iterable

from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.plan import TrialKey
from pytest_lpb.trial.files import read_metadata
from pytest_lpb.trial.outcome import DEADLINE, WORKER_CRASH

CLOCKED = (DEADLINE, WORKER_CRASH)  # outcomes that a trial need not have again


def sample(run: RunFolder, per_planner: int) -> dict[TrialKey, dict[str, object]]:
    """Trials to run again, with what their files say of themselves: as many of each planner, spread over the run.

    Left out are trials that were never run since no problem could be drawn, and those that the clock or a crash ended.
    """
    found: dict[str, dict[TrialKey, dict[str, object]]] = {}
    for path in run.trial_files():
        metadata = read_metadata(path)
        if metadata["trajectory_hash"] and metadata["outcome"] not in CLOCKED:
            key = TrialKey(metadata["scenario"], metadata["planner"], metadata["seed"])
            found.setdefault(key.planner, {})[key] = metadata
    return {key: trials[key] for trials in found.values() for key in spread(sorted(trials), per_planner)}


def spread(trials: Iterable[TrialKey], count: int) -> list[TrialKey]:
    """At most `count` trials at even distances, the last among them: what trials leave behind shows in later ones."""
    known = list(trials)
    kept = min(count, len(known))
    return [known[-(-(place + 1) * len(known) // kept) - 1] for place in range(kept)]
