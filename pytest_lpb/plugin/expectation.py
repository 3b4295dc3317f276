"""Known failures: xfail data of scenarios and of planner files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import TypeAdapter, ValidationError

from pytest_lpb.documents.faults import Fault, key_path
from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.scenario.load import Scenario
from pytest_lpb.scenario.messages import faults_of
from pytest_lpb.scenario.schema.success import ExpectedFailure, XFail
from pytest_lpb.trial.outcome import OUTCOMES, SOFTWARE_FAULTS, WORKER_CRASH

_ENTRY: TypeAdapter[ExpectedFailure] = TypeAdapter(XFail)

# Without `outcomes`, any failure to plan is expected; a fault of the software never is.
DEFAULT_OUTCOMES = tuple(name for name in OUTCOMES if name not in (*SOFTWARE_FAULTS, WORKER_CRASH))


@dataclass(frozen=True)
class Expectation:
    """A failure that is known; None: of any outcome, of any seed."""

    reason: str
    outcomes: tuple[str, ...] | None = None
    seeds: tuple[int, ...] | None = None

    def concerns(self, seed: int) -> bool:
        """Whether the trial of this seed is expected to fail."""
        return self.seeds is None or seed in self.seeds

    def covers(self, outcome: str) -> bool:
        """Whether a failed trial's outcome is the expected one; `success` is one that misses further criteria."""
        return outcome in (self.outcomes or DEFAULT_OUTCOMES)


def known_failure(scenario: Scenario, configuration: PlannerConfiguration, key: str) -> Expectation | None:
    """The known failure of a planner in a scenario: the scenario's word first, then the planner file's."""
    known = scenario.xfail.get(configuration.name)
    if known is not None:
        return Expectation(known.reason, known.outcomes, known.seeds)
    entry = configuration.expected_failure(key)
    return None if entry is None else _expectation(entry)


def check_known_failures(configuration: PlannerConfiguration) -> None:
    """Raise ConfigurationError for entries of a planner file's `xfail` that a scenario file could not have either."""
    faults = []
    for glob, entry in configuration.xfail.items():
        try:
            _expectation(entry)
        except ValidationError as error:
            faults += [
                f"{configuration.path}:{_line(configuration, glob, fault)}: "
                f"{key_path(('xfail', glob, *fault.loc))}: {fault.message}"
                for fault in faults_of(error, ExpectedFailure, entry)
            ]
    if faults:
        raise ConfigurationError("\n".join(faults))


def _line(configuration: PlannerConfiguration, glob: str, fault: Fault) -> int:
    document = configuration.document
    return document.line_of(("xfail", glob, *fault.loc)) if document is not None else 1


def _expectation(entry: Any) -> Expectation:
    known = _ENTRY.validate_python(entry)
    return Expectation(known.reason, _tuple(known.outcomes), _tuple(known.seeds))


def _tuple(values: list[Any] | None) -> tuple[Any, ...] | None:
    return None if values is None else tuple(values)
