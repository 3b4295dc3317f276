"""What `lpb-report --reproduce` prints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.reproduce import Finding, Sameness, commands

MAX_LISTED = 20  # trials that differ


def reproduce_lines(run: RunFolder, found: Sequence[Finding]) -> Iterator[str]:
    """How to run it again, and what has changed since."""
    for where, command in commands(run):
        yield f"run it again {where}:"
        yield f"    {command}"
    yield ""
    others = [finding for finding in found if finding.state != "same"]
    for finding in others:
        yield f"{finding.what}: {finding.state}{f' ({finding.detail})' if finding.detail else ''}"
    same = len(found) - len(others)
    yield f"{same} of {len(found)} things it depends on (planners, scenarios, packages, commit) are the same"


def sameness_lines(first: str, second: str, sameness: Sameness) -> Iterator[str]:
    """Whether two runs did the same."""
    total = sameness.same + len(sameness.different)
    yield f"{sameness.same} of {total} trials of {first} and {second} are the same to the last bit, times apart"
    told = [f"{key.scenario} :: {key.planner} :: seed{key.seed}: another {what}" for key, what in sameness.different]
    for name, only in ((first, sameness.only_first), (second, sameness.only_second)):
        told += [f"{key.scenario} :: {key.planner} :: seed{key.seed}: only in {name}" for key in only]
    yield from told[:MAX_LISTED]
    if len(told) > MAX_LISTED:
        yield f"... and {len(told) - MAX_LISTED} more"
