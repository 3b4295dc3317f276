"""Checks of the listed obstacles."""

import re
from collections.abc import Iterator, Sequence

from pytest_lpb.documents.faults import Fault
from pytest_lpb.motion import angle_motion
from pytest_lpb.names import listed
from pytest_lpb.scenario.checks.goal import check_motion, stays_finite
from pytest_lpb.scenario.schema.available import AVAILABLE_SHAPES
from pytest_lpb.scenario.schema.environment import Environment
from pytest_lpb.scenario.schema.obstacle import Obstacle

DRAWN_NAME = re.compile(r"drawn[0-9]+")
_DIMENSIONS = {"planar": 2, "pybullet": 3}


def obstacle_names(obstacles: Sequence[Obstacle]) -> list[str]:
    """Names of the obstacles, those without one by their position in the file."""
    return [obstacle.name or f"obstacle{index}" for index, obstacle in enumerate(obstacles)]


def check_names(obstacles: list[Obstacle], source: str | None) -> Iterator[Fault]:
    """Names are unique, and none is kept for drawn obstacles, except in a concrete problem."""
    seen: dict[str, int] = {}
    for index, name in enumerate(obstacle_names(obstacles)):
        place = ("obstacles", index, "name")
        if seen.setdefault(name, index) != index:
            yield Fault(place, f"{name!r} is the name of obstacles[{seen[name]}] already; names are unique")
        if source is None and DRAWN_NAME.fullmatch(name):
            yield Fault(place, f"{name!r} is kept for drawn obstacles; choose another name")


def check_shapes(obstacles: list[Obstacle], environment: Environment) -> Iterator[Fault]:
    """The engine has these shapes."""
    allowed = AVAILABLE_SHAPES.get(environment.engine)
    for index, obstacle in enumerate(obstacles):
        if allowed and obstacle.shape not in allowed:
            yield Fault(("obstacles", index, "shape"), wrong_shape(obstacle.shape, environment.engine, allowed))


def wrong_shape(shape: str, engine: str, allowed: Sequence[str]) -> str:
    """What to say of a shape that the engine has not."""
    return f"{shape} is not available with the engine {engine}; allowed: {listed(allowed)}"


def check_motions(obstacles: list[Obstacle], environment: Environment) -> Iterator[Fault]:
    """Each obstacle is placed once, in the right dimension, and stays finite for the duration."""
    dimension = _DIMENSIONS[environment.engine]
    for index, obstacle in enumerate(obstacles):
        place = ("obstacles", index)
        yield from check_motion(place, obstacle, "position", (dimension, "coordinates [m]"), environment)
        if isinstance(obstacle.orientation, list) and dimension == 2:
            yield Fault((*place, "orientation"), "found a list of 4; in the plane an angle [rad] is required")
        elif isinstance(obstacle.orientation, str):
            yield from stays_finite((*place, "orientation"), angle_motion(obstacle.orientation), environment)
