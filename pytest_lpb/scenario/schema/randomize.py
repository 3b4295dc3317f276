"""The `randomize` part of a scenario file: ranges that problems are drawn from."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from pytest_lpb.scenario.schema.obstacle import MAX_OBSTACLES, shape_tag
from pytest_lpb.scenario.schema.values import Box, Distance, Distinct, LengthRange, Part, Range

PartName = Literal["start", "goal", "obstacles"]
PARTS: tuple[PartName, ...] = ("start", "goal", "obstacles")


class Configuration(Part):
    """Ranges of the joint positions."""

    q: Box = Field(description="[lower, upper] per q [rad or m]")


def _goal_form(value: Any) -> str:
    return "(mapping)" if isinstance(value, dict | Configuration) else "(box)"


GoalRanges = Annotated[
    Annotated[Box, Tag("(box)")] | Annotated[Configuration, Tag("(mapping)")], Discriminator(_goal_form)
]

Number = Annotated[int, Field(ge=0, le=MAX_OBSTACLES)]


def _counts(value: Any) -> Any:
    if isinstance(value, int) and not isinstance(value, bool):
        value = [value, value]
    if isinstance(value, list) and len(value) == 2 and all(type(item) is int for item in value) and value[0] > value[1]:
        raise ValueError(f"found {value}; the lower bound comes first")
    return value


class Group(Part):
    """Obstacles drawn alike."""

    count: Annotated[
        list[Number],
        Field(min_length=2, max_length=2),
        BeforeValidator(_counts, json_schema_input_type=Number | list[Number]),
    ] = Field(description="how many: a number, or [fewest, most]")
    position: Box = Field(description="[lower, upper] per coordinate [m]")
    velocity: Box | None = Field(default=None, description="[lower, upper] per coordinate [m/s]; default at rest")
    orientation: Range | None = Field(
        default=None, description="[lower, upper] of the angle [rad], in space about z; default 0"
    )


class RoundGroup(Group):
    """Discs or spheres."""

    shape: Literal["circle", "sphere"] = Field(description="which obstacles they are")
    radius: LengthRange = Field(description="[m]")


class BoxGroup(Group):
    """Rectangles or boxes."""

    shape: Literal["rectangle", "box"] = Field(description="which obstacles they are")
    size: Annotated[list[LengthRange], Field(min_length=2, max_length=3)] = Field(
        description="[lower, upper] per side [m]"
    )


class LongGroup(Group):
    """Cylinders or capsules."""

    shape: Literal["cylinder", "capsule"] = Field(description="which obstacles they are")
    radius: LengthRange = Field(description="[m]")
    length: LengthRange = Field(description="[m]")


_GROUP_TAGS = {
    "(circle)": "(round)",
    "(sphere)": "(round)",
    "(rectangle)": "(sides)",
    "(box)": "(sides)",
    "(cylinder)": "(long)",
    "(capsule)": "(long)",
}


def group_tag(value: Any) -> str | None:
    """The union tag of a group: by its shape."""
    tag = shape_tag(value) or ""
    # A registered shape's group has the shape's own tag; a built-in shape without one cannot be drawn.
    return _GROUP_TAGS.get(tag, tag or None)


def as_list(value: Any) -> Any:
    """One group as a list of one."""
    return [value] if isinstance(value, dict) else value


GROUPS: dict[str, type[Part]] = {"(round)": RoundGroup, "(sides)": BoxGroup, "(long)": LongGroup}  # by tag

AnyGroup = Annotated[
    Annotated[RoundGroup, Tag("(round)")] | Annotated[BoxGroup, Tag("(sides)")] | Annotated[LongGroup, Tag("(long)")],
    Discriminator(group_tag),
]
Groups = Annotated[
    list[AnyGroup],
    Field(min_length=1, max_length=MAX_OBSTACLES),
    BeforeValidator(as_list, json_schema_input_type=AnyGroup | list[AnyGroup]),
]


class Randomize(Part):
    """What is drawn anew for every seed, and from which ranges."""

    draw: Annotated[list[PartName], Distinct] = Field(default=[], description="parts drawn without any flag")
    start: Configuration | None = Field(default=None, description="ranges of the start")
    goal: GoalRanges | None = Field(
        default=None, description="a box for the primary position, or {q: ranges} for reachable targets"
    )
    obstacles: Groups | None = Field(default=None, description="one group, or a list")
    keep_obstacles: bool = Field(default=True, description="whether the listed obstacles stay beside drawn ones")
    margin: Distance = Field(default=0.05, description="[m] free space around the robot at start and goal")
