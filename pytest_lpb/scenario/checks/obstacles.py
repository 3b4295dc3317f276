"""Checks of the listed obstacles."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from pytest_lpb.documents.faults import Fault, Loc
from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion import angle_motion, turning_motion
from pytest_lpb.names import listed
from pytest_lpb.scenario.checks.goal import check_motion, stays_finite
from pytest_lpb.scenario.schema.available import SAME_SHAPE, dimension_of, shapes_of
from pytest_lpb.scenario.schema.environment import Environment
from pytest_lpb.scenario.schema.obstacle import AxisAngle, Mesh, Obstacle

DRAWN_NAME = re.compile(r"drawn[0-9]+")
MESH_SUFFIXES = (".obj", ".stl")  # PyBullet reads .dae files for robots only


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
    allowed = shapes_of(environment.engine)
    for index, obstacle in enumerate(obstacles):
        if obstacle.shape not in allowed:
            yield Fault(("obstacles", index, "shape"), wrong_shape(obstacle.shape, environment.engine, allowed))


def wrong_shape(shape: str, engine: str, allowed: Sequence[str]) -> str:
    """What to say of a shape that the engine has not."""
    hint = f"; did you mean {SAME_SHAPE[shape]!r}?" if shape in SAME_SHAPE else ""
    return f"{shape} is not available with the engine {engine}{hint}; allowed: {listed(allowed)}"


def check_motions(obstacles: list[Obstacle], environment: Environment) -> Iterator[Fault]:
    """Each obstacle is placed once, in the right dimension, and stays finite for the duration."""
    dimension = dimension_of(environment.engine)
    for index, obstacle in enumerate(obstacles):
        place = ("obstacles", index)
        yield from check_motion(place, obstacle, "position", (dimension, "coordinates [m]"), environment)
        yield from _ORIENTATIONS[dimension]((*place, "orientation"), obstacle, environment)


def _check_angle(place: Loc, obstacle: Obstacle, environment: Environment) -> Iterator[Fault]:
    """In the plane: a number or an expression in t."""
    if isinstance(obstacle.orientation, list | AxisAngle):
        found = "a list of 4" if isinstance(obstacle.orientation, list) else "an axis and an angle"
        yield Fault(place, f"found {found}; in the plane an angle [rad] is required")
    elif isinstance(obstacle.orientation, str):
        yield from stays_finite(place, angle_motion(obstacle.orientation), environment)


def _check_turn(place: Loc, obstacle: Obstacle, environment: Environment) -> Iterator[Fault]:
    """In space: a quaternion, or an axis and an angle."""
    given = obstacle.orientation
    if given is None:
        return
    if isinstance(given, str | float | int):
        yield Fault(place, f"found {given!r}; in space a quaternion wxyz or {{axis, angle}} is required")
        return
    motion = turning_motion(given if isinstance(given, list) else given.model_dump())
    yield from stays_finite(place, motion, environment)


_ORIENTATIONS = {2: _check_angle, 3: _check_turn}


def check_meshes(obstacles: list[Obstacle]) -> Iterator[Fault]:
    """Mesh files are there, and sound."""
    for index, obstacle in enumerate(obstacles):
        if not isinstance(obstacle, Mesh):
            continue
        path, place = Path(obstacle.file), ("obstacles", index, "file")
        if path.suffix.lower() not in MESH_SUFFIXES:
            yield Fault(place, f"found {path.name!r}; allowed are files {listed(MESH_SUFFIXES)}")
        elif not path.exists():
            yield Fault(place, f"there is no file {path}")
        else:
            yield from _check_mesh(place, path)


def _check_mesh(place: Loc, path: Path) -> Iterator[Fault]:
    # Imported late: most scenarios have no meshes.
    from pytest_lpb.problem.spatial.mesh_files import check_mesh

    try:
        check_mesh(path)
    except ScenarioError as error:
        yield Fault(place, str(error).removeprefix(f"{path.parent}/"))
