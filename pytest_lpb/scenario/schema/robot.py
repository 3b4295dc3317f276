"""The `robot` part of a scenario file."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from pytest_lpb.documents.faults import described
from pytest_lpb.scenario.schema.values import (
    Coordinate,
    Distinct,
    Length,
    Name,
    Part,
    Quaternion,
    Range,
    Text,
    Vector3,
)

MAX_LINKS = 100
UNIT_LINK = 1.0  # [m]


def _unit_links(value: Any) -> Any:
    if isinstance(value, int) and not isinstance(value, bool):
        if not 1 <= value <= MAX_LINKS:
            raise ValueError(f"found {value} links; allowed are 1 to {MAX_LINKS}")
        return [UNIT_LINK] * value
    if not isinstance(value, list):
        raise ValueError(f"found {described(value)}; a count of links, or a list of lengths [m], is required")
    return value


Links = Annotated[
    list[Length],
    Field(min_length=1, max_length=MAX_LINKS),
    BeforeValidator(
        _unit_links,
        json_schema_input_type=Annotated[int, Field(ge=1, le=MAX_LINKS)]
        | Annotated[list[Length], Field(min_length=1, max_length=MAX_LINKS)],
    ),
]
LimitList = Annotated[list[Range | None], Field(max_length=MAX_LINKS + 6)]
BodyPair = Annotated[list[Name], Field(min_length=2, max_length=2), Distinct]
Sphere = Annotated[list[Coordinate], Field(min_length=4, max_length=4)]


class BasePose(Part):
    """Where the base of a URDF robot stands."""

    position: Vector3 = Field(default=[0.0, 0.0, 0.0], description="[m]")
    orientation: Quaternion = Field(default=[1.0, 0.0, 0.0, 0.0], description="quaternion wxyz")


class CollisionSpheres(Part):
    """Spheres or discs in place of a robot's collision geometry; exactly one of the keys."""

    spheres: Annotated[dict[Name, list[Sphere]], Field(max_length=MAX_LINKS)] | None = Field(
        default=None, description="per link a list of [x, y, z, r] in the link's frame [m]"
    )
    link_spheres: Length | None = Field(default=None, description="radius [m] of one sphere or disc at each link frame")


class Limits(Part):
    """Limits of a robot; a missing list means the URDF's, or unlimited; null in a list means unlimited."""

    position: LimitList | None = Field(default=None, description="[lower, upper] per q [rad or m]")
    velocity: LimitList | None = Field(default=None, description="[lower, upper] per action [rad/s or m/s]")
    acceleration: LimitList | None = Field(default=None, description="[lower, upper] per action [rad/s^2 or m/s^2]")
    effort: LimitList | None = Field(default=None, description="in space: [lower, upper] per action [N m or N]")


def _collision_form(value: Any) -> str:
    return "(mapping)" if isinstance(value, dict | CollisionSpheres) else "(text)"


Collision = Annotated[
    Annotated[Literal["geometry"], Tag("(text)")] | Annotated[CollisionSpheres, Tag("(mapping)")],
    Discriminator(_collision_form),
]


class ExceptPairs(Part):
    """The default self-collision pairs but some, for links that overlap by design; one key or both."""

    except_: Annotated[list[BodyPair], Field(max_length=10_000)] | None = Field(
        default=None, alias="except", description="pairs of bodies that may overlap"
    )
    srdf: Text | None = Field(
        default=None, description="path of an SRDF file of MoveIt: pairs that its disable_collisions name may overlap"
    )


def _pairs_form(value: Any) -> str:
    return "(mapping)" if isinstance(value, dict | ExceptPairs) else "(list)"


SelfCollisionPairs = Annotated[
    Annotated[list[BodyPair], Field(max_length=10_000), Tag("(list)")] | Annotated[ExceptPairs, Tag("(mapping)")],
    Discriminator(_pairs_form),
]


class Robot(Part):
    """The robot: a model known by name, or a URDF file."""

    model: Name | None = Field(
        default=None,
        description="point, planar_arm, differential_drive; in space point_3d, arm_3d, cart, car, panda, ...",
    )
    urdf: Text | None = Field(default=None, description="path of a URDF file, in place of model")
    name: Name | None = Field(
        default=None, description="key for a planner's per_robot parameters; default model or file"
    )
    links: Links | None = Field(default=None, description="planar_arm: a count of 1 m links, or their lengths [m]")
    joints: Annotated[list[Name], Field(max_length=MAX_LINKS), Distinct] | None = Field(
        default=None, description="URDF: planned joints in the order of q; []: only the base moves"
    )
    locked_joints: Annotated[dict[Name, Coordinate], Field(max_length=1000)] | None = Field(
        default=None, description="URDF: joints held at a position [rad or m]"
    )
    base: Literal["fixed", "holonomic", "differential_drive", "bicycle"] | None = Field(
        default=None, description="what it stands on; default the model's own, of a URDF fixed"
    )
    base_pose: BasePose | None = Field(default=None, description="URDF: where the base stands at q = 0")
    base_size: Annotated[list[Length], Field(min_length=3, max_length=3)] | None = Field(
        default=None, description="[m] length, width, height of a box that carries a robot on a moving base"
    )
    wheel_base: Length | None = Field(
        default=None,
        description="[m] differential drive: wheel separation; bicycle: axle distance; default 0.5 or known",
    )
    control: Literal["acceleration", "velocity", "torque"] = Field(
        default="acceleration", description="what actions are; torque needs dynamics: true"
    )
    body_radius: Length | None = Field(
        default=None, description="[m] of bodies that are made to measure; default 0.2, planar_arm 0.1, arm_3d 0.05"
    )
    collision: Collision = Field(default="geometry", description="what collides: its own geometry, or spheres")
    limits: Limits | None = Field(default=None, description="of positions, velocities, accelerations, efforts")
    self_collision_pairs: SelfCollisionPairs | None = Field(
        default=None,
        description="pairs of bodies; absent: all but adjacent; []: none; {except, srdf}: all but some",
    )
