"""How users add engines, robots, shapes of obstacles and types of sub-goals to scenario files.

A class is registered where it is defined: in conftest.py, in a module named by ini `lpb_plugins`, or in a package with
an entry point of a group of `registries.GROUPS`.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.problem.registries import (
    EngineType,
    GoalType,
    Origin,
    RobotType,
    ShapeType,
    engines,
    goals,
    robots,
    shapes,
)

CONTROLS = ("acceleration", "velocity")

C = TypeVar("C", bound=type)


def register_engine(
    name: str, *, dimension: int, controls: Sequence[str] = CONTROLS, dynamics: bool = False
) -> Callable[[C], C]:
    """Register a class of engines (see `pytest_lpb.environment.engine.Engine`): `environment: {engine: NAME}`.

    Args:
        name: in scenario files.
        dimension: 2 or 3, as its robots and shapes have.
        controls: values of `robot: {control: ..}` that it can apply.
        dynamics: whether it can do with `environment: {dynamics: true}`.

    Raises ConfigurationError for a name that is not allowed, built in, or taken by another place.
    """
    _check_dimension("engine", name, dimension)
    origin = _caller()

    def register(cls: C) -> C:
        engines.add(EngineType(name, cls, origin, dimension, tuple(controls), dynamics))
        return cls

    return register


def register_robot(
    name: str, *, base: str = "fixed", body_radius: float = 0.1, keys: Mapping[str, Any] | None = None
) -> Callable[[C], C]:
    """Register a class of planar robots (see `pytest_lpb.problem.planar.robot.PlanarRobot`): `robot: {model: NAME}`.

    Args:
        name: in scenario files.
        base: what it stands on: fixed, holonomic, differential_drive.
        body_radius: default radius of its bodies [m].
        keys: further keys of `robot`: name -> type, or (type, default). `wheel_base` and `links` may be among them.

    Raises ConfigurationError for a name that is not allowed, built in, or taken by another place.
    """
    origin = _caller()

    def register(cls: C) -> C:
        robots.add(RobotType(name, cls, origin, base, body_radius, dict(keys or {})))
        return cls

    return register


def register_urdf(
    name: str,
    path: str | Path,
    *,
    joints: Sequence[str] | None = None,
    locked_joints: Mapping[str, float] | None = None,
    base: str = "fixed",
    wheel_base: float | None = None,
    steering: Sequence[str] = (),
) -> None:
    """Register a URDF file as a robot in space: `robot: {model: NAME}`.

    Args:
        name: in scenario files.
        path: the file; a relative one is below the folder of the module that registers it.
        joints: planned joints in the order of q; None: all that move but the locked ones.
        locked_joints: joints held at a position [rad or m].
        base: fixed, holonomic, differential_drive or bicycle.
        wheel_base: of a moving base [m].
        steering: joints turned by a bicycle's steering angle.

    Raises ConfigurationError for a name that is not allowed, built in, or taken, and when there is no such file.
    """
    origin = _caller()
    file = (Path(origin.file).parent / path).resolve()
    if not file.is_file():
        raise ConfigurationError(f"robot {name!r}: there is no file {file}")
    urdf = {
        "path": file,
        "joints": None if joints is None else tuple(joints),
        "locked": dict(locked_joints or {}),
        "base": base,
        "wheel_base": wheel_base,
        "steering": tuple(steering),
    }
    robots.add(RobotType(name, None, origin, base, urdf=urdf))


def register_shape(name: str, *, dimension: int, keys: Mapping[str, Any]) -> Callable[[C], C]:
    """Register a class of obstacle shapes: `obstacles: [{shape: NAME, ..}]`, and in `randomize: {obstacles: ..}`.

    In the plane a `pytest_lpb.problem.planar.shapes.PlacedShape`; in space a class whose attribute `vertices` (n, 3)
    [m] spans the shape, which is their convex hull. Both are made of the obstacle's entry.

    Args:
        name: in scenario files.
        dimension: 2 or 3.
        keys: of the entry: name -> type, or (type, default). Those of type float can be drawn from ranges.

    Raises ConfigurationError for a name that is not allowed, built in, or taken by another place.
    """
    _check_dimension("shape", name, dimension)
    origin = _caller()

    def register(cls: C) -> C:
        shapes.add(ShapeType(name, cls, origin, dimension, dict(keys)))
        return cls

    return register


def register_goal(
    name: str, *, size: int, keys: Mapping[str, Any] | None = None, dimension: int | None = None
) -> Callable[[C], C]:
    """Register a class of sub-goals (see `pytest_lpb.problem.goal.SubGoal`): `goal: [{type: NAME, ..}]`.

    Args:
        name: in scenario files.
        size: entries of its target.
        keys: of the entry, besides target, tolerance and the like: name -> type, or (type, default). `link` and
            `joints` are checked to be those of the robot.
        dimension: 2 or 3, of the robots it is for; None: both.

    Raises ConfigurationError for a name that is not allowed, built in, or taken by another place.
    """
    if dimension is not None:
        _check_dimension("goal type", name, dimension)
    origin = _caller()

    def register(cls: C) -> C:
        goals.add(GoalType(name, cls, origin, dimension, size, dict(keys or {})))
        return cls

    return register


def _check_dimension(kind: str, name: str, dimension: int) -> None:
    if dimension not in (2, 3):
        raise ConfigurationError(f"{kind} {name!r}: dimension: found {dimension!r}; allowed: 2 or 3")


def _caller() -> Origin:
    """The module that calls a function of this one."""
    frame = inspect.currentframe()
    while frame is not None and frame.f_globals.get("__name__") == __name__:
        frame = frame.f_back
    names = {} if frame is None else frame.f_globals
    module = str(names.get("__name__", ""))
    file = names.get("__file__") or getattr(sys.modules.get(module), "__file__", None)
    return Origin(module, str(Path(file).resolve()) if file else "")
