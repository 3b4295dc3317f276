"""The `success` and `xfail` parts of a scenario file."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Discriminator, Field, Tag

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.criterion import Criterion, parse_criterion
from pytest_lpb.scenario.schema.values import (
    CriterionText,
    Distinct,
    Part,
    Text,
    refused,
)

MAX_SEED = 2**63 - 1

Seed = Annotated[int, Field(ge=0, le=MAX_SEED)]
Outcome = Literal[
    "success",
    "collision",
    "self_collision",
    "joint_limit",
    "timeout",
    "stalled",
    "planner_error",
    "infeasible",
    "deadline",
    "worker_crash",
    "environment_error",
]


def _check_rate(text: str) -> Criterion:
    criterion = parse_criterion(text)
    if not 0.0 <= criterion.number <= 1.0:
        raise ScenarioError(f"found {criterion.number:g}; a success rate lies between 0 and 1")
    return criterion


def _hold_form(value: Any) -> str:
    return "(text)" if isinstance(value, str) else "(number)"


HoldTime = Annotated[
    Annotated[Literal["end"], Tag("(text)")]
    | Annotated[float, Field(allow_inf_nan=False, ge=0, le=1e6), Tag("(number)")],
    Discriminator(_hold_form),
]


class Success(Part):
    """When a trial is a success, besides every tolerance and no violation; further keys are KPIs."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, CriterionText]

    hold_time: HoldTime | None = Field(
        default=None,
        description="[s] within every tolerance, or `end`; default 0.5, for a moving primary goal `end`",
    )
    rate: Annotated[CriterionText, AfterValidator(refused(_check_rate))] | None = Field(
        default=None, description="success rate required of a planner, such as '>= 0.8'"
    )


class ExpectedFailure(Part):
    """A failure that is known and does not fail the run."""

    reason: Text = Field(description="why")
    outcomes: Annotated[list[Outcome], Field(min_length=1), Distinct] | None = Field(
        default=None, description="outcomes that are expected; default any failure"
    )
    seeds: Annotated[list[Seed], Field(min_length=1, max_length=10_000), Distinct] | None = Field(
        default=None, description="seeds it is expected for; default all"
    )


def _reason_alone(value: Any) -> Any:
    return {"reason": value} if isinstance(value, str) else value


XFail = Annotated[ExpectedFailure, BeforeValidator(_reason_alone, json_schema_input_type=str | ExpectedFailure)]
