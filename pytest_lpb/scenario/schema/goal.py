"""The `goal` part of a scenario file: sub-goals of four types."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from pytest_lpb.scenario.schema.values import (
    Coordinate,
    Distinct,
    Length,
    Name,
    Part,
    Spline,
    Trajectory,
    Vector,
    Weight,
    is_number,
)

MAX_GOALS = 20

Axis = Annotated[int, Field(ge=0, le=2)]
Direction = Annotated[list[Coordinate], Field(min_length=2, max_length=3)]


class Tolerance(Part):
    """A tolerance for each unit of the error."""

    m: Length | None = Field(default=None, description="[m] of prismatic joints")
    rad: Length | None = Field(default=None, description="[rad] of revolute joints")


def _tolerance_form(value: Any) -> str:
    return "(by unit)" if isinstance(value, dict | Tolerance) else "(number)"


class SubGoal(Part):
    """What every sub-goal has."""

    name: Name | None = Field(default=None, description="default goal0, goal1, ... by position in the file")
    tolerance: (
        Annotated[
            Annotated[Length, Tag("(number)")] | Annotated[Tolerance, Tag("(by unit)")], Discriminator(_tolerance_form)
        ]
        | None
    ) = Field(
        default=None,
        description="[m or rad], or one per unit, {m: .., rad: ..}; without: a preference, not needed for success",
    )
    weight: Weight = Field(default=1.0, description="for planners that weigh sub-goals")
    primary: bool = Field(default=False, description="the first sub-goal is primary unless one says so")


class MovingGoal(SubGoal):
    """A sub-goal with a target; exactly one of target, trajectory and spline."""

    target: Vector | None = Field(default=None, description="fixed, in the sub-goal's own coordinates [m or rad]")
    trajectory: Trajectory | None = Field(default=None, description="expressions in t")
    spline: Spline | None = Field(default=None, description="rows [t, x, y, ...]")
    periodic: bool | None = Field(default=None, description="whether the spline repeats")


class PositionGoal(MovingGoal):
    """A point of a link at a target position."""

    type: Literal["position"] = Field(description="which sub-goal it is")
    link: Name = Field(description="of the robot")
    axes: Annotated[list[Axis], Field(min_length=1, max_length=3), Distinct] | None = Field(
        default=None, description="axes of the world that count; default all"
    )
    point: Annotated[list[Coordinate], Field(min_length=2, max_length=3)] | None = Field(
        default=None, description="[m] in the link's frame; default its origin"
    )
    relative_to: Name | None = Field(default=None, description="link in whose frame the target lies")


def _angle_as_list(value: Any) -> Any:
    return [value] if is_number(value) else value


class OrientationGoal(MovingGoal):
    """A link at a target orientation: an angle in the plane, a quaternion wxyz in space."""

    type: Literal["orientation"] = Field(description="which sub-goal it is")
    link: Name = Field(description="of the robot")
    target: Annotated[
        Vector | None, BeforeValidator(_angle_as_list, json_schema_input_type=float | list[Coordinate] | None)
    ] = Field(default=None, description="[rad], or a quaternion wxyz")


class JointGoal(MovingGoal):
    """Joints at target positions; the error is the largest one."""

    type: Literal["joint"] = Field(description="which sub-goal it is")
    joints: Annotated[list[Name], Field(min_length=1, max_length=106), Distinct] = Field(
        description="names, in the order of the target"
    )


class AlignmentGoal(SubGoal):
    """An axis of a link along an axis of another frame."""

    type: Literal["alignment"] = Field(description="which sub-goal it is")
    link: Name = Field(description="of the robot")
    axis: Direction = Field(description="in the link's frame, of any length but zero")
    other: Name = Field(default="world", description="the other frame: a link, or the world")
    other_axis: Direction = Field(description="in the other frame")


def type_tag(value: Any) -> str | None:
    """The union tag of a sub-goal: its type in parentheses."""
    kind = value.get("type") if isinstance(value, dict) else getattr(value, "type", None)
    return f"({kind})" if isinstance(kind, str) else None


TYPES: dict[str, type[SubGoal]] = {  # by tag
    "(position)": PositionGoal,
    "(orientation)": OrientationGoal,
    "(joint)": JointGoal,
    "(alignment)": AlignmentGoal,
}

Goal = Annotated[
    Annotated[PositionGoal, Tag("(position)")]
    | Annotated[OrientationGoal, Tag("(orientation)")]
    | Annotated[JointGoal, Tag("(joint)")]
    | Annotated[AlignmentGoal, Tag("(alignment)")],
    Discriminator(type_tag),
]
