"""A study file: planners x scenarios x seeds, sweeps of their parameters, and what is made of the results."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from pytest_lpb.scenario.schema.file import MAX_TRIALS
from pytest_lpb.scenario.schema.randomize import PartName
from pytest_lpb.scenario.schema.success import Seed
from pytest_lpb.scenario.schema.values import Distinct, Name, Part, Text, refused
from pytest_lpb.study.change import check_name

MAX_ENTRIES = 1_000
MAX_VALUES = 100  # of one parameter


def _as_list(value: Any) -> Any:
    return value if isinstance(value, list) else [value]


Values = Annotated[list[Any], Field(min_length=1, max_length=MAX_VALUES), Distinct]
Planner = Annotated[str, Field(min_length=1, max_length=1000)]
Knob = Annotated[str, Field(max_length=200), AfterValidator(refused(check_name))]


class Sweep(Part):
    """Values of a planner's parameters, or of a scenario's knobs: every combination is run."""

    planner: Planner | None = Field(default=None, description="one of the study's planners")
    parameters: Annotated[dict[Name, Values], Field(min_length=1, max_length=4)] | None = Field(
        default=None, description="values of its parameters"
    )
    scenarios: Annotated[list[Text], Field(min_length=1, max_length=MAX_ENTRIES), BeforeValidator(_as_list)] | None = (
        Field(default=None, description="globs of scenario keys; default all of the study's")
    )
    knobs: Annotated[dict[Knob, Values], Field(min_length=1, max_length=4)] | None = Field(
        default=None, description="values of knobs, or at key paths of the scenario files"
    )


class Gate(Part):
    """The regression gate: as --lpb-baseline, --lpb-fail-on and --lpb-inconclusive."""

    baseline: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        description="a run folder or a baseline file, from this file's folder; or planner:NAME"
    )
    fail_on: Text | None = None
    inconclusive: Literal["fail", "pass"] | None = None


class StudyFile(Part):
    """A study; options of the command line go before what it says."""

    study: Annotated[str, Field(min_length=1, max_length=10_000)] = Field(description="what it is about")
    planners: Annotated[list[Planner], Field(min_length=1, max_length=MAX_ENTRIES), Distinct] = Field(
        description="as --lpb-planners; paths from this file's folder"
    )
    scenarios: Annotated[list[Text], Field(min_length=1, max_length=MAX_ENTRIES), BeforeValidator(_as_list)] = Field(
        description="scenario files or globs, from this file's folder"
    )
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)] | None = Field(default=None, description="per scenario")
    seed: Seed | None = Field(default=None, description="first seed")
    random: Annotated[list[PartName], Distinct] = Field(default=[], description="parts drawn as by flags")
    kpis: Annotated[list[Name], Field(min_length=1, max_length=MAX_ENTRIES), Distinct] | None = Field(
        default=None, description="KPIs to evaluate; default all"
    )
    verdict: Literal["trial", "rate", "none"] | None = Field(
        default=None, description="what fails, as --lpb-assert; default: none"
    )
    sweep: Annotated[list[Sweep], Field(max_length=100), BeforeValidator(_as_list)] = Field(default=[])
    gate: Gate | None = None
