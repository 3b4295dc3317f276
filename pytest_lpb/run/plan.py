"""The trials that a run is to have, as run.json records them: what is missing can be told, and run later."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple

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
    """The numbers that `as_ranges` wrote."""
    for part in filter(None, text.split(",")):
        first, _, last = part.partition("-")
        yield from range(int(first), int(last or first) + 1)


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
