"""The problems of an old run, to be run again with any planners."""

from __future__ import annotations

from pathlib import Path

from pytest_lpb.errors import RecordingError
from pytest_lpb.study.family import RecordedFamily

PREFIX = "seed"


def recorded_families(run: Path) -> list[RecordedFamily]:
    """The distinct problems of a run folder, by scenario key and seed. Raises RecordingError when it has none.

    Each planner of the old run has its own copy of a problem; they are the same.
    """
    trials = run / "trials"
    found: dict[str, dict[int, Path]] = {}
    for path in sorted(trials.rglob(f"{PREFIX}*.yaml")):
        seed = path.stem.removeprefix(PREFIX)
        scenario = path.relative_to(trials).parts[:-2]  # a file elsewhere is none of a trial
        if scenario and seed.isdecimal():
            key = "/".join(scenario)
            found.setdefault(key, {}).setdefault(int(seed), path)
    if not found:
        raise RecordingError(f"{run}: it has no problem files (trials/SCENARIO/PLANNER/seedK.yaml)")
    return [RecordedFamily(key, dict(sorted(files.items())), run.name) for key, files in sorted(found.items())]
