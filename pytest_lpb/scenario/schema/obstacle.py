"""The `obstacles` part of a scenario file."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from pytest_lpb.scenario.schema.values import (
    Coordinate,
    Direction3,
    Expression,
    Length,
    Name,
    Part,
    Quaternion,
    Spline,
    Text,
    Trajectory,
    Vector,
)

MAX_OBSTACLES = 1_000


class AxisAngle(Part):
    """A rotation about an axis, by an angle that may depend on time."""

    axis: Direction3 = Field(description="of any length but zero, in the world")
    angle: Annotated[
        Annotated[Coordinate, Tag("(angle)")] | Annotated[Expression, Tag("(expression)")],
        Discriminator(lambda value: "(expression)" if isinstance(value, str) else "(angle)"),
    ] = Field(description="[rad], or an expression in t")


_ORIENTATION_FORMS = ((str, "(expression)"), (list, "(quaternion)"), (dict | AxisAngle, "(turn)"))


def _orientation_form(value: Any) -> str:
    return next((form for kind, form in _ORIENTATION_FORMS if isinstance(value, kind)), "(angle)")


Orientation = Annotated[
    Annotated[Coordinate, Tag("(angle)")]
    | Annotated[Expression, Tag("(expression)")]
    | Annotated[Quaternion, Tag("(quaternion)")]
    | Annotated[AxisAngle, Tag("(turn)")],
    Discriminator(_orientation_form),
]


class Placed(Part):
    """What every obstacle has; exactly one of position, trajectory and spline."""

    name: Name | None = Field(default=None, description="default obstacle0, obstacle1, ... by position in the file")
    position: Vector | None = Field(default=None, description="of the centre [m]")
    trajectory: Trajectory | None = Field(default=None, description="expressions in t")
    spline: Spline | None = Field(default=None, description="rows [t, x, y, ...]")
    periodic: bool | None = Field(default=None, description="whether the spline repeats")
    orientation: Orientation | None = Field(
        default=None,
        description="in the plane an angle [rad] or an expression in t; in space a quaternion wxyz or {axis, angle}",
    )


class Circle(Placed):
    """A disc."""

    shape: Literal["circle"] = Field(description="which obstacle it is")
    radius: Length = Field(description="[m]")


class Sphere(Placed):
    """A sphere."""

    shape: Literal["sphere"] = Field(description="which obstacle it is")
    radius: Length = Field(description="[m]")


class Rectangle(Placed):
    """A rectangle of full side lengths."""

    shape: Literal["rectangle"] = Field(description="which obstacle it is")
    size: Annotated[list[Length], Field(min_length=2, max_length=2)] = Field(description="[m] full side lengths")


class Box(Placed):
    """A box of full side lengths."""

    shape: Literal["box"] = Field(description="which obstacle it is")
    size: Annotated[list[Length], Field(min_length=3, max_length=3)] = Field(description="[m] full side lengths")


class Cylinder(Placed):
    """A cylinder along z."""

    shape: Literal["cylinder"] = Field(description="which obstacle it is")
    radius: Length = Field(description="[m]")
    length: Length = Field(description="[m] along z")


class Capsule(Placed):
    """A capsule along z; the length is between the centres of its caps."""

    shape: Literal["capsule"] = Field(description="which obstacle it is")
    radius: Length = Field(description="[m]")
    length: Length = Field(description="[m] along z")


class Mesh(Placed):
    """A triangle mesh from a file."""

    shape: Literal["mesh"] = Field(description="which obstacle it is")
    file: Text = Field(description="path of an .obj or .stl file, relative to the scenario file")
    scale: Length = Field(default=1.0, description="factor of its coordinates")
    concave: bool = Field(default=False, description="its surface in place of its convex hull")


def shape_tag(value: Any) -> str | None:
    """The union tag of an obstacle: its shape in parentheses."""
    shape = value.get("shape") if isinstance(value, dict) else getattr(value, "shape", None)
    return f"({shape})" if isinstance(shape, str) else None


SHAPES: dict[str, type[Placed]] = {  # by tag
    "(circle)": Circle,
    "(rectangle)": Rectangle,
    "(sphere)": Sphere,
    "(box)": Box,
    "(cylinder)": Cylinder,
    "(capsule)": Capsule,
    "(mesh)": Mesh,
}

Obstacle = Annotated[
    Annotated[Circle, Tag("(circle)")]
    | Annotated[Rectangle, Tag("(rectangle)")]
    | Annotated[Sphere, Tag("(sphere)")]
    | Annotated[Box, Tag("(box)")]
    | Annotated[Cylinder, Tag("(cylinder)")]
    | Annotated[Capsule, Tag("(capsule)")]
    | Annotated[Mesh, Tag("(mesh)")],
    Discriminator(shape_tag),
]
