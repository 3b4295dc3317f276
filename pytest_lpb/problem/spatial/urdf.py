"""Robots as URDF files describe them: links with their geometry, joints between them.

Reading is in `urdf_reader`, writing in `urdf_writer`. Lengths in m, angles in rad; poses are (4, 4) homogeneous.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import cos, inf, sin
from pathlib import Path

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.names import suggestion
from pytest_lpb.problem.robot import FloatArray


def identity() -> FloatArray:
    """The pose that changes nothing, (4, 4), read-only."""
    pose = np.eye(4)
    pose.flags.writeable = False
    return pose


def translation(x: float, y: float, z: float) -> FloatArray:
    """The pose (4, 4) of a frame moved by (x, y, z) [m]."""
    pose = np.eye(4)
    pose[:3, 3] = (x, y, z)
    return pose


@dataclass(frozen=True, eq=False)
class Geometry:
    """A shape on a link.

    Attributes:
        kind: box, sphere, cylinder, capsule or mesh.
        size: box: full lengths [m]; sphere: (radius,); cylinder and capsule: (radius, length) along z, a capsule's
            between its cap centres; mesh: scale per axis.
        origin: pose in the link's frame, (4, 4).
        file: of a mesh, absolute; None where it is not there.
        missing: of such a mesh, what to say of it.
        color: red, green, blue, opacity in [0, 1]; of visuals.
        line: of the URDF file, where it names a mesh.
    """

    kind: str
    size: tuple[float, ...]
    origin: FloatArray = field(default_factory=identity)
    file: Path | None = None
    color: tuple[float, float, float, float] | None = None
    line: int = 0
    missing: str = ""


@dataclass(frozen=True, eq=False)
class Inertial:
    """Mass [kg], pose (4, 4) of the centre of mass's frame in the link's, inertia (3, 3) [kg m^2] in that frame."""

    mass: float
    origin: FloatArray
    inertia: FloatArray


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid part of a robot."""

    name: str
    collisions: tuple[Geometry, ...] = ()
    visuals: tuple[Geometry, ...] = ()
    inertial: Inertial | None = None


@dataclass(frozen=True, eq=False)
class Joint:
    """How a child link moves on its parent; limits are ±inf where there are none.

    Attributes:
        kind: fixed, revolute or prismatic (continuous joints are revolute without limits).
        origin: pose of the joint's frame, and of the child at zero, in the parent's frame (4, 4).
        axis: unit vector in the joint's frame (3,).
        lower, upper: [rad or m]; velocity [rad/s or m/s]; effort [N m or N].
        mimic: (joint, multiplier, offset) of the joint that it follows, or None.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: FloatArray = field(default_factory=identity)
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    lower: float = -inf
    upper: float = inf
    velocity: float = inf
    effort: float = inf
    mimic: tuple[str, float, float] | None = None


def joint_motion(joint: Joint, position: float) -> FloatArray:
    """Pose (4, 4) of a joint's child link relative to the joint's frame, at a position [rad or m]."""
    pose = np.eye(4)
    axis = np.asarray(joint.axis, dtype=float)
    if joint.kind == "prismatic":
        pose[:3, 3] = position * axis
    elif joint.kind == "revolute":
        x, y, z = axis
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        pose[:3, :3] = np.eye(3) + sin(position) * cross + (1.0 - cos(position)) * cross @ cross  # Rodrigues
    return pose


@dataclass(frozen=True, eq=False)
class UrdfModel:
    """A robot's links, parents before children, and the joints in the order of their child links.

    Attributes:
        path: of the file; None for a robot that has none.
        notes: what was read in one of several ways, or is not there and not needed; no fault.
        warnings: what is probably not meant.
        absent: names of meshes, as the file has them, that are not there.
        located: files of meshes whose packages the environment variables of ROS name, by `package://NAME/..`.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    path: Path | None = None
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    absent: tuple[str, ...] = ()
    located: Mapping[str, Path] = field(default_factory=dict)

    @property
    def root(self) -> str:
        """Name of the link that is no joint's child."""
        return self.links[0].name

    @cached_property
    def _links(self) -> dict[str, Link]:
        return {link.name: link for link in self.links}

    @cached_property
    def _joints(self) -> dict[str, Joint]:
        return {joint.name: joint for joint in self.joints}

    def link(self, name: str) -> Link:
        """A link. Raises ScenarioError for an unknown name."""
        if name not in self._links:
            raise ScenarioError(f"no link {name!r} in {self.name}{suggestion(name, self._links)}")
        return self._links[name]

    def joint(self, name: str) -> Joint:
        """A joint. Raises ScenarioError for an unknown name."""
        if name not in self._joints:
            raise ScenarioError(f"no joint {name!r} in {self.name}{suggestion(name, self._joints)}")
        return self._joints[name]

    @cached_property
    def movable(self) -> tuple[str, ...]:
        """Names of the joints that move by themselves: neither fixed nor mimicking another."""
        return tuple(joint.name for joint in self.joints if joint.kind != "fixed" and joint.mimic is None)

    @cached_property
    def meshes(self) -> tuple[Path, ...]:
        """All mesh files, sorted."""
        shapes = (shape for link in self.links for shape in (*link.collisions, *link.visuals))
        return tuple(sorted({shape.file for shape in shapes if shape.file is not None}))
