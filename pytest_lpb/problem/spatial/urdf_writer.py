"""Writes a robot as URDF text that PyBullet loads."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from xml.sax.saxutils import quoteattr

import numpy as np

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.rotations import rpy_of_matrix
from pytest_lpb.problem.spatial.urdf import Geometry, Inertial, Joint, Link, UrdfModel

LEAST_MASS_KG = 1e-3  # of links that have none: PyBullet takes links without mass for fixed to the world
LEAST_INERTIA = 1e-6  # [kg m^2]
UNLIMITED = 1e9  # [rad, m, ..] how a joint without a limit is written


def urdf_text(model: UrdfModel, *, margin: float = 0.0) -> str:
    """A robot as URDF, with absolute mesh paths, and without its visuals, which nothing measures.

    Args:
        model: the robot.
        margin: [m] by which boxes and cylinders of the collision geometry grow on every side.
    """
    parts = [f"<robot name={quoteattr(model.name)}>"]
    parts += [_link(link, margin) for link in model.links]
    parts += [_joint(joint) for joint in model.joints]
    return "\n".join([*parts, "</robot>\n"])


def _link(link: Link, margin: float) -> str:
    # An element to a line: PyBullet cuts lines of 8192 bytes, in the middle of a number if need be.
    collisions = [f"<collision>{_shape(shape, margin)}</collision>" for shape in link.collisions]
    return "\n".join([f"<link name={quoteattr(link.name)}>", _inertial(link.inertial), *collisions, "</link>"])


def _inertial(inertial: Inertial | None) -> str:
    mass, origin, ixx, ixy, ixz, iyy, iyz, izz = (
        LEAST_MASS_KG,
        "",
        LEAST_INERTIA,
        0.0,
        0.0,
        LEAST_INERTIA,
        0.0,
        LEAST_INERTIA,
    )
    if inertial is not None and inertial.mass > 0.0:
        mass, origin = inertial.mass, _origin(inertial.origin)
        (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = possible(inertial.inertia).tolist()
    return (
        f'<inertial>{origin}<mass value="{mass!r}"/><inertia ixx="{ixx!r}" ixy="{ixy!r}" ixz="{ixz!r}" '
        f'iyy="{iyy!r}" iyz="{iyz!r}" izz="{izz!r}"/></inertial>'
    )


def possible(inertia: FloatArray) -> FloatArray:
    """An inertia that a body can have: where files have others, which PyBullet refuses, a ball's of the same size."""
    smallest, middle, largest = np.linalg.eigvalsh(inertia).tolist()
    if smallest > 0.0 and largest <= smallest + middle:
        return inertia
    ball: FloatArray = max((smallest + middle + largest) / 3.0, LEAST_INERTIA) * np.eye(3)
    return ball


def _box(shape: Geometry, margin: float) -> str:
    return f'<box size="{" ".join(repr(length + 2.0 * margin) for length in shape.size)}"/>'


def _sphere(shape: Geometry, margin: float) -> str:  # noqa: ARG001 - spheres have no margin
    return f'<sphere radius="{shape.size[0]!r}"/>'


def _cylinder(shape: Geometry, margin: float) -> str:
    return f'<cylinder radius="{shape.size[0] + margin!r}" length="{shape.size[1] + 2.0 * margin!r}"/>'


def _capsule(shape: Geometry, margin: float) -> str:  # noqa: ARG001 - capsules have no margin
    return f'<capsule radius="{shape.size[0]!r}" length="{shape.size[1]!r}"/>'


def _mesh(shape: Geometry, margin: float) -> str:  # noqa: ARG001 - hulls grow by themselves
    scale = " ".join(map(repr, shape.size))
    return f'<mesh filename={quoteattr(str(shape.file))} scale="{scale}"/>'


_SHAPES: dict[str, Callable[[Geometry, float], str]] = {
    "box": _box,
    "sphere": _sphere,
    "cylinder": _cylinder,
    "capsule": _capsule,
    "mesh": _mesh,
}


def _shape(shape: Geometry, margin: float) -> str:
    return f"{_origin(shape.origin)}<geometry>{_SHAPES[shape.kind](shape, margin)}</geometry>"


def _joint(joint: Joint) -> str:
    axis = " ".join(map(repr, joint.axis))
    limits = {"lower": joint.lower, "upper": joint.upper, "velocity": joint.velocity, "effort": joint.effort}
    written = " ".join(f'{key}="{_finite(value)!r}"' for key, value in limits.items())
    return (
        f'<joint name={quoteattr(joint.name)} type="{joint.kind}"><parent link={quoteattr(joint.parent)}/>'
        f'<child link={quoteattr(joint.child)}/>{_origin(joint.origin)}<axis xyz="{axis}"/><limit {written}/></joint>'
    )


def _finite(value: float) -> float:
    return value if isfinite(value) else (UNLIMITED if value > 0.0 else -UNLIMITED)


def _origin(pose: FloatArray) -> str:
    x, y, z = pose[:3, 3].tolist()
    roll, pitch, yaw = rpy_of_matrix(pose[:3, :3])
    return f'<origin xyz="{x!r} {y!r} {z!r}" rpy="{roll!r} {pitch!r} {yaw!r}"/>'
