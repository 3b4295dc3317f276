"""Known failures: xfail data of scenarios and of planner files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pytest_lpb.trial.outcome import OUTCOMES, SOFTWARE_FAULTS, SUCCESS

if TYPE_CHECKING:
    from pytest_lpb.plugin.items import PlannerCollector

# Without `outcomes`, any failure to plan is expected; a fault of the software never is.
DEFAULT_OUTCOMES = tuple(name for name in OUTCOMES if name not in (*SOFTWARE_FAULTS, SUCCESS, "worker_crash"))


@dataclass(frozen=True)
class Expectation:
    """A failure that is known."""

    reason: str
    outcomes: tuple[str, ...] | None

    def covers(self, outcome: str) -> bool:
        """Whether a failed trial's outcome is the expected one; a success that misses its criteria counts as any."""
        return outcome == SUCCESS or outcome in (self.outcomes or DEFAULT_OUTCOMES)


def expectation_of(collector: PlannerCollector, seed: int, scenario: str) -> Expectation | None:
    """The known failure of one trial: the scenario's word first, then the planner file's."""
    known = collector.scenario.xfail.get(collector.name)
    if known is not None:
        return _for_seed(known.reason, known.outcomes, known.seeds, seed)
    entry = collector.configuration.expected_failure(scenario)
    if entry is None:
        return None
    if not isinstance(entry, Mapping):
        return Expectation(str(entry), None)
    return _for_seed(str(entry.get("reason", "")), _tuple(entry.get("outcomes")), _tuple(entry.get("seeds")), seed)


def _for_seed(
    reason: str, outcomes: tuple[str, ...] | None, seeds: tuple[int, ...] | None, seed: int
) -> Expectation | None:
    return Expectation(reason, outcomes) if seeds is None or seed in seeds else None


def _tuple(values: Any) -> tuple[Any, ...] | None:
    return None if values is None else tuple(values)
