"""Robots made here instead of read from a file: a point and an n-link arm in space, a cart, a car."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import pi

import numpy as np

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.rotations import matrix_of_rpy
from pytest_lpb.problem.spatial.urdf import Geometry, Inertial, Joint, Link, UrdfModel, translation

BASE_BODY = "mobile_base"  # link of the box that carries a robot

BODY_COLOR = (0.0, 0.447, 0.698, 1.0)
WHEEL_COLOR = (0.15, 0.15, 0.15, 1.0)
CART_HEIGHT_M = 0.3
CAR_WIDTH_M = 0.4
CAR_HEIGHT_M = 0.3
CAR_OVERHANG_M = 0.1  # [m] of the body behind the rear axle and before the front one
WHEEL_RADIUS_M = 0.08
WHEEL_WIDTH_M = 0.04
DENSITY = 500.0  # [kg/m^3]


@dataclass(frozen=True)
class Sizes:
    """What a generated robot is made to measure."""

    links: tuple[float, ...] = ()  # [m] lengths
    body_radius: float = 0.1  # [m]
    wheel_base: float = 0.5  # [m]


def _posed(x: float, y: float, z: float, roll: float = 0.0, pitch: float = 0.0) -> FloatArray:
    pose = translation(x, y, z)
    pose[:3, :3] = matrix_of_rpy(roll, pitch, 0.0)
    return pose


def _inertial(size: Sequence[float], origin: FloatArray) -> Inertial:
    """Of a solid box, its sides along the axes of its frame `origin`."""
    x, y, z = size
    mass = DENSITY * x * y * z
    return Inertial(mass, origin, mass / 12.0 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y]))


def _body(name: str, shape: Geometry, box: Sequence[float], more: Sequence[Geometry] = ()) -> Link:
    colored = Geometry(shape.kind, shape.size, shape.origin, color=BODY_COLOR)
    return Link(name, (shape,), (colored, *more), _inertial(box, shape.origin))


def _point(sizes: Sizes) -> UrdfModel:
    ball = Geometry("sphere", (sizes.body_radius,))
    links = [Link("lpb_origin"), Link("lpb_along_x"), Link("lpb_along_y"), _body("body", ball, [sizes.body_radius] * 3)]
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    joints = [
        Joint(name, "prismatic", parent.name, child.name, axis=axis)
        for (name, axis), parent, child in zip(axes.items(), links, links[1:], strict=False)
    ]
    return UrdfModel("point_3d", tuple(links), tuple(joints))


def _arm(sizes: Sizes) -> UrdfModel:
    radius = sizes.body_radius
    links = [_body("base", Geometry("sphere", (radius,)), [radius] * 3)]
    joints = []
    before = 0.0
    for index, length in enumerate(sizes.links, start=1):
        middle = _posed(0.5 * length, 0.0, 0.0, pitch=0.5 * pi)  # the capsule's axis z along the link's x
        links.append(_body(f"link{index}", Geometry("capsule", (radius, length), middle), [radius, radius, length]))
        axis = (0.0, 0.0, 1.0) if index == 1 else (0.0, 1.0, 0.0)
        joints.append(
            Joint(f"joint{index}", "revolute", links[-2].name, links[-1].name, translation(before, 0.0, 0.0), axis)
        )
        before = length
    joints.append(Joint("tip", "fixed", links[-1].name, "end", translation(before, 0.0, 0.0)))
    return UrdfModel("arm_3d", (*links, Link("end")), tuple(joints))


def _wheel(x: float, y: float) -> Geometry:
    return Geometry(
        "cylinder",
        (WHEEL_RADIUS_M, WHEEL_WIDTH_M),
        _posed(x, y, WHEEL_RADIUS_M, roll=0.5 * pi),
        color=WHEEL_COLOR,
    )


def _cart(sizes: Sizes) -> UrdfModel:
    radius = sizes.body_radius
    shape = Geometry("cylinder", (radius, CART_HEIGHT_M), translation(0.0, 0.0, 0.5 * CART_HEIGHT_M))
    nose = Geometry(
        "box",
        (0.3 * radius, 0.3 * radius, 0.02),
        translation(0.7 * radius, 0.0, CART_HEIGHT_M + 0.01),
        color=WHEEL_COLOR,
    )
    wheels = [_wheel(0.0, side * radius) for side in (-1.0, 1.0)]
    return UrdfModel("cart", (_body("base", shape, [radius, radius, CART_HEIGHT_M], [nose, *wheels]),), ())


def _car(sizes: Sizes) -> UrdfModel:
    size = (sizes.wheel_base + 2.0 * CAR_OVERHANG_M, CAR_WIDTH_M, CAR_HEIGHT_M)
    shape = Geometry("box", size, translation(0.5 * sizes.wheel_base, 0.0, 0.5 * CAR_HEIGHT_M))
    cabin = Geometry(
        "box",
        (0.4 * size[0], 0.8 * CAR_WIDTH_M, 0.12),
        translation(0.35 * sizes.wheel_base, 0.0, CAR_HEIGHT_M + 0.06),
        color=WHEEL_COLOR,
    )
    wheels = [_wheel(x, side * 0.5 * CAR_WIDTH_M) for x in (0.0, sizes.wheel_base) for side in (-1.0, 1.0)]
    return UrdfModel("car", (_body("base", shape, size, [cabin, *wheels]),), ())


@dataclass(frozen=True)
class GeneratedModel:
    """A robot known by name, made to measure.

    Attributes:
        build: makes it.
        base: fixed, or the base it stands on.
        body_radius: default [m]; None where it has no meaning.
        wheel_base: default [m]; None where it has no meaning.
        position_limits: default limits of entries of q [rad or m].
    """

    build: Callable[[Sizes], UrdfModel]
    base: str
    body_radius: float | None
    wheel_base: float | None = None
    position_limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)


# A new generated robot is one entry here.
GENERATED: dict[str, GeneratedModel] = {
    "point_3d": GeneratedModel(_point, "fixed", 0.2),
    "arm_3d": GeneratedModel(_arm, "fixed", 0.05),
    "cart": GeneratedModel(_cart, "differential_drive", 0.2, 0.4),
    "car": GeneratedModel(_car, "bicycle", None, 0.5, {"delta": (-0.6, 0.6)}),
}


def base_body(size: Sequence[float]) -> Link:
    """The box (length, width, height) [m] that carries a robot, standing on z = 0 of the base's frame."""
    length, width, height = size
    shape = Geometry("box", (length, width, height), translation(0.0, 0.0, 0.5 * height))
    wheels = [_wheel(0.0, side * 0.5 * width) for side in (-1.0, 1.0)]
    return _body(BASE_BODY, shape, size, wheels)
