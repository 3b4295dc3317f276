"""The trials that a run is to have, as run.json records them: what is missing can be told, and run later."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple

MAX_PLANNED = 10_000_000  # trials of a run
RANGE = re.compile("[0-9]{1,19}(-[0-9]{1,19})?")
DAMAGED = "delete it, and --lpb-resume runs its trial again"  # what to do with a trial file that cannot be read


class TrialKey(NamedTuple):
    """What a trial is called by."""

    scenario: str
    planner: str
    seed: int


def as_ranges(numbers: Iterable[int]) -> str:
    """Whole numbers in short, such as `0-99,105`."""
    runs: list[list[int]] = []
    for number in sorted(set(numbers)):
        if runs and number == runs[-1][1] + 1:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    return ",".join(str(first) if first == last else f"{first}-{last}" for first, last in runs)


def from_ranges(text: str) -> Iterator[int]:
    """The numbers that `as_ranges` wrote. Raises ValueError for other texts."""
    for numbers in _ranges(text):
        yield from numbers


def check_plan(plan: Mapping[str, Mapping[str, str]]) -> None:
    """Check a plan that somebody may have written by hand. Raises ValueError for odd seeds and for too many trials."""
    count = 0
    for planners in plan.values():
        for seeds in planners.values():
            count += sum(numbers.stop - numbers.start for numbers in _ranges(seeds))
            if count > MAX_PLANNED:
                raise ValueError(f"plans more trials than {MAX_PLANNED}")


def _ranges(text: str) -> Iterator[range]:
    for part in filter(None, text.split(",")):
        if RANGE.fullmatch(part) is None:
            raise ValueError(f"found the seeds {text[:40]!r}; allowed are such as '0-99,105'")
        first, _, last = part.partition("-")
        yield range(int(first), int(last or first) + 1)


def planned(trials: Collection[TrialKey]) -> dict[str, dict[str, str]]:
    """Trials as run.json holds them: seeds by scenario and planner."""
    seeds: dict[str, dict[str, list[int]]] = {}
    for trial in trials:
        seeds.setdefault(trial.scenario, {}).setdefault(trial.planner, []).append(trial.seed)
    return {
        scenario: {planner: as_ranges(numbers) for planner, numbers in sorted(planners.items())}
        for scenario, planners in sorted(seeds.items())
    }


def trials_of(plan: Mapping[str, Mapping[str, str]]) -> frozenset[TrialKey]:
    """The trials that run.json planned."""
    return frozenset(
        TrialKey(scenario, planner, seed)
        for scenario, planners in plan.items()
        for planner, seeds in planners.items()
        for seed in from_ranges(seeds)
    )
