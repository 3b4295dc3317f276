"""A whole scenario file."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from pytest_lpb.names import listed
from pytest_lpb.scenario.schema.environment import Environment, Start
from pytest_lpb.scenario.schema.goal import MAX_GOALS, Goal
from pytest_lpb.scenario.schema.obstacle import MAX_OBSTACLES, Obstacle
from pytest_lpb.scenario.schema.randomize import Randomize
from pytest_lpb.scenario.schema.robot import Robot
from pytest_lpb.scenario.schema.success import Seed, Success, XFail
from pytest_lpb.scenario.schema.values import Distinct, Name, Part, Text

MAX_TRIALS = 1_000_000
MAX_TAGS = 50

# Marks that change how pytest runs an item, when they come from a file that only wants to be found by them.
REFUSED_TAGS = frozenset(
    {"skip", "skipif", "xfail", "parametrize", "usefixtures", "filterwarnings", "xdist_group", "flaky"}
)


def _selectable(tag: str) -> str:
    if tag in REFUSED_TAGS:
        raise ValueError(f"found {tag!r}; it means something to pytest itself: not allowed are {listed(REFUSED_TAGS)}")
    if tag in ("and", "or", "not") or tag.startswith("_"):
        raise ValueError(f"found {tag!r}; -m cannot select and, or, not, nor names with a leading underscore")
    return tag


Tag = Annotated[Name, AfterValidator(_selectable)]


class Certified(Part):
    """A path that was found and checked: proof that the problem of a seed can be solved."""

    seed: Seed = Field(description="whose problem it solves")
    length_m: Annotated[float, Field(allow_inf_nan=False, gt=0, le=1e6)] = Field(
        description="[m] of the primary goal's link along the path"
    )
    path: Text | None = Field(default=None, description="CSV file, t and q in its rows")


class ScenarioFile(Part):
    """A family of motion planning problems: contract section 2."""

    version: Literal[1] = Field(description="of this format")
    description: Text = Field(default="", description="for people")
    source: Text | None = Field(default=None, description="of a concrete problem: what it was drawn from")
    tags: Annotated[list[Tag], Field(max_length=MAX_TAGS), Distinct] = Field(default=[], description="pytest markers")
    robot: Robot = Field(description="what moves")
    environment: Environment = Field(default=Environment(), description="engine, clock, what ends a trial")
    start: Start = Field(default=Start(), description="state at t = 0")
    goal: Annotated[list[Goal], Field(min_length=1, max_length=MAX_GOALS)] = Field(
        description="sub-goals; those with a tolerance must be reached together"
    )
    obstacles: Annotated[list[Obstacle], Field(max_length=MAX_OBSTACLES)] = Field(
        default=[], description="what is in the way, fixed or moving"
    )
    randomize: Randomize | None = Field(default=None, description="what differs from seed to seed")
    seed: Seed = Field(default=0, description="first seed")
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)] = Field(default=1, description="how many seeds")
    success: Success = Field(default=Success(), description="what else makes a trial a success")
    certified: Certified | None = Field(default=None, description="proof that it can be solved")
    xfail: Annotated[dict[Name, XFail], Field(max_length=1000)] = Field(
        default={}, description="per planner: why it is known to fail"
    )
