"""Which parts a robot has, for its distances to obstacles and to itself."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Protocol

from pytest_lpb.planner.scene.parts import Ball, Block, Part, part_of_capsule
from pytest_lpb.problem.robot import Robot
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.urdf import Geometry


class Taken(Protocol):
    """What a planner's parameters say of how a robot is taken."""

    @property
    def sphere_excess(self) -> float:
        """[m] How far fitted balls may reach beyond a link."""

    @property
    def spheres_per_shape(self) -> int:
        """The largest number of balls per shape of a link."""

    @property
    def self_collision_reach(self) -> float:
        """[m] Pairs of bodies that never come nearer do not count."""


def steered(robot: Robot) -> bool:
    """Whether a robot is a base that must turn to evade: it cannot move sideways, and has no arm that could."""
    return robot.non_holonomic and robot.n_actions == 2


def parts_of(robot: Robot, parameters: Taken, *, exact: bool, lookahead: float) -> list[Part]:
    """Parts that meet obstacles: spheres that hold the links, or the links themselves.

    A non-holonomic base without an arm cannot evade sideways, but a point ahead of it can: it has its parts there too.

    Args:
        robot: any.
        parameters: how it is taken.
        exact: the links themselves.
        lookahead: [m] how far ahead that point is.
    """
    parts: list[Part] = list((_EXACT if exact else _BALLS)[robot.dimension](robot, parameters))
    if steered(robot):
        parts += [replace(part, ahead=lookahead) for part in parts]
    return parts


def balls_of(robot: Robot, parameters: Taken) -> dict[str, list[Part]]:
    """Balls that cover each collision body."""
    balls: dict[str, list[Part]] = {}
    for ball in _BALLS[robot.dimension](robot, parameters):
        balls.setdefault(ball.body, []).append(ball)
    return balls


def capsules_of(robot: Robot) -> dict[str, list[Part]]:
    """Balls and capsules that hold each collision body, for distances between bodies."""
    return {
        body.name: [part_of_capsule(body.name, body.link, capsule) for capsule in body.capsules]
        for body in robot.collision_bodies
    }


def _planar(robot: Robot, parameters: Taken) -> Iterator[Part]:  # noqa: ARG001
    for parts in capsules_of(robot).values():
        yield from parts


def _planar_balls(robot: Robot, parameters: Taken) -> Iterator[Part]:
    for part in _planar(robot, parameters):
        yield from part.balls(parameters.sphere_excess)


def _spatial_balls(robot: Robot, parameters: Taken) -> Iterator[Part]:
    from pytest_lpb.problem.spatial.cover import link_balls  # late: it needs PyBullet

    assert isinstance(robot, SpatialRobot)
    for body, balls in link_balls(robot, parameters.sphere_excess, parameters.spheres_per_shape).items():
        yield from (Ball(body, body, radius, (x, y, z)) for x, y, z, radius in balls)


def _spatial(robot: Robot, parameters: Taken) -> Iterator[Part]:
    assert isinstance(robot, SpatialRobot)
    for body in robot.body_names:
        for shape in robot.urdf.link(body).collisions:
            yield from _OF_GEOMETRY.get(shape.kind, _fitted)(body, shape, parameters)


def _of_round(body: str, shape: Geometry, parameters: Taken) -> Iterator[Part]:  # noqa: ARG001
    from pytest_lpb.problem.spatial.meshes import capsule_of  # late: it needs PyBullet

    yield part_of_capsule(body, body, capsule_of(shape))


def _of_box(body: str, shape: Geometry, parameters: Taken) -> Iterator[Part]:
    cover = tuple(_fitted(body, shape, parameters))
    yield Block(body, body, 0.0, tuple(shape.origin.ravel().tolist()), shape.size, cover)


def _fitted(body: str, shape: Geometry, parameters: Taken) -> Iterator[Ball]:
    from pytest_lpb.problem.spatial.cover import covering_balls  # late: it needs PyBullet

    for x, y, z, radius in covering_balls(shape, parameters.sphere_excess, parameters.spheres_per_shape):
        yield Ball(body, body, radius, (x, y, z))


# By dimension.
_EXACT: Mapping[int, Callable[[Robot, Taken], Iterator[Part]]] = {2: _planar, 3: _spatial}
_BALLS: Mapping[int, Callable[[Robot, Taken], Iterator[Part]]] = {2: _planar_balls, 3: _spatial_balls}
_OF_GEOMETRY: Mapping[str, Callable[[str, Geometry, Taken], Iterator[Part]]] = {
    "sphere": _of_round,
    "capsule": _of_round,
    "box": _of_box,
}
