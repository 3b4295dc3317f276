"""What users have added to scenario files, by name: engines, robots, shapes of obstacles, types of sub-goals.

`registration` adds to these tables. Built-in ones have tables of their own, and are looked up first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import ConfigurationError, ScenarioError, in_one_line
from pytest_lpb.names import is_name

GROUPS = ("pytest_lpb.engines", "pytest_lpb.robots", "pytest_lpb.shapes", "pytest_lpb.goals")


@dataclass(frozen=True)
class Origin:
    """Where something was registered: what loads it again in another process."""

    module: str
    file: str

    @property
    def own(self) -> bool:
        """Whether it is of this package."""
        return self.module.partition(".")[0] == "pytest_lpb"


@dataclass(frozen=True)
class EngineType:
    """A registered engine: `create(problem)` gives an `environment.engine.Engine`."""

    name: str
    create: Callable[[Any], Any]
    origin: Origin
    dimension: int
    controls: tuple[str, ...]
    dynamics: bool


@dataclass(frozen=True)
class RobotType:
    """A registered robot: a class of planar robots, or (`urdf`) a URDF file in space.

    Attributes:
        keys: further keys of `robot`: name -> type, or (type, default).
        urdf: the fields of a `problem.spatial.library.LibraryRobot`.
    """

    name: str
    create: Callable[[Mapping[str, Any]], Any] | None
    origin: Origin
    base: str = "fixed"
    body_radius: float = 0.1
    keys: Mapping[str, Any] = field(default_factory=dict)
    urdf: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class ShapeType:
    """A registered shape: `create(entry)` gives a `PlacedShape`, in space an object with `vertices`, (n, 3) [m]."""

    name: str
    create: Callable[[Mapping[str, Any]], Any]
    origin: Origin
    dimension: int
    keys: Mapping[str, Any]


@dataclass(frozen=True)
class GoalType:
    """A registered type of sub-goal: `create(entry, robot)` gives a `SubGoal` whose target has `size` entries."""

    name: str
    create: Callable[[Mapping[str, Any], Any], Any]
    origin: Origin
    dimension: int | None
    size: int
    keys: Mapping[str, Any]


FloatArray = NDArray[np.float64]

T = TypeVar("T", EngineType, RobotType, ShapeType, GoalType)


class Registry(Generic[T]):
    """Registered ones of a kind, by name."""

    def __init__(self, kind: str, built_in: Sequence[str], reserved: Sequence[str] = ()) -> None:
        self._kind = kind
        self._built_in = frozenset(built_in)
        self._reserved = frozenset(reserved)
        self._entries: dict[str, T] = {}

    def add(self, entry: T) -> None:
        """Register; once more from the same place (a module imported again) replaces. Raises ConfigurationError."""
        name, kind = entry.name, self._kind
        if not isinstance(name, str) or not is_name(name):
            raise ConfigurationError(f"{kind} {name!r}: its name may have letters, digits, _ . - only")
        if name in self._built_in:
            raise ConfigurationError(f"{kind} {name!r} is built in; choose another name ({place_of(entry.origin)})")
        other = self._entries.get(name)
        if other is not None and _identity(other) != _identity(entry):
            raise ConfigurationError(
                f"{kind} {name!r} is taken: {place_of(other.origin)} and {place_of(entry.origin)} both register it"
            )
        for key in getattr(entry, "keys", ()):
            if not str(key).isidentifier() or key in self._reserved:
                raise ConfigurationError(
                    f"{kind} {name!r}: key {key!r} is not allowed: it is no identifier, or every {kind} has it"
                )
        self._entries[name] = entry
        _state.version += 1

    def get(self, name: str) -> T | None:
        """The one of a name; None for one that is built in or unknown. Raises ConfigurationError: entry points."""
        if name not in self._entries and name not in self._built_in:
            load_entry_points()
        return self._entries.get(name)

    def all(self) -> list[T]:
        """All, by name. Raises ConfigurationError for entry points that cannot be loaded."""
        load_entry_points()
        return [self._entries[name] for name in sorted(self._entries)]


# Names that are built in; a test holds them to the tables of their classes.
ENGINES = ("planar", "pybullet")
ROBOTS = (
    *("point", "planar_arm", "differential_drive", "point_3d", "arm_3d", "cart", "car"),
    *("panda", "kuka_iiwa", "xarm6", "husky", "racecar"),
    *("ur3", "ur5", "ur5_gripper", "ur10", "kinova", "tiago", "tiago_no_hand", "tiago_dual", "double_pendulum"),
)
SHAPES = {2: ("circle", "rectangle"), 3: ("sphere", "box", "cylinder", "capsule", "mesh")}  # by dimension
GOALS = ("position", "orientation", "joint", "alignment")

_MOTION = ("name", "trajectory", "spline", "periodic")

engines: Registry[EngineType] = Registry("engine", ENGINES)
robots: Registry[RobotType] = Registry(
    "robot",
    ROBOTS,
    (
        *("model", "urdf", "name", "control", "base", "body_radius", "collision", "limits", "self_collision_pairs"),
        *("joints", "locked_joints", "base_pose", "base_size"),
    ),
)
shapes: Registry[ShapeType] = Registry(
    "shape", (*SHAPES[2], *SHAPES[3]), (*_MOTION, "shape", "position", "orientation", "count", "velocity", "file")
)
goals: Registry[GoalType] = Registry("goal type", GOALS, (*_MOTION, "type", "tolerance", "weight", "primary", "target"))
REGISTRIES: tuple[Registry[Any], ...] = (engines, robots, shapes, goals)


@dataclass
class _State:
    version: int = 0  # changes with every registration: what was made of the registries is out of date
    loaded: bool = False  # whether entry points were


_state = _State()


def version() -> int:
    """A number that changes with every registration. Raises ConfigurationError for entry points."""
    load_entry_points()
    return _state.version


def load_entry_points() -> None:
    """Import what installed packages offer, once. Raises ConfigurationError when something cannot be imported."""
    if _state.loaded:
        return
    for group in GROUPS:
        for point in entry_points(group=group):
            try:
                point.load()
            except ConfigurationError:
                raise
            except Exception as error:
                # A package may raise anything while it is imported.
                raise ConfigurationError(f"entry point {point.name!r} of {group}: {in_one_line(error)}") from error
    _state.loaded = True


def origins() -> list[Origin]:
    """Where users' engines, robots, shapes and types of sub-goals were registered."""
    found = [entry.origin for registry in REGISTRIES for entry in registry.all()]
    return list(dict.fromkeys(origin for origin in found if not origin.own))


@contextmanager
def preserved() -> Iterator[None]:
    """Undo on leaving whatever is registered inside: one session's registrations do not reach the next."""
    before = [dict(registry._entries) for registry in REGISTRIES]
    loaded = _state.loaded
    try:
        yield
    finally:
        for registry, entries in zip(REGISTRIES, before, strict=True):
            registry._entries = entries
        _state.loaded = loaded
        _state.version += 1


def default_of(key: Any) -> tuple[Any, Any]:
    """Type and default of a key; `...` for one that is required."""
    return key if isinstance(key, tuple) else (key, ...)


def registered_vertices(entry: Mapping[str, Any]) -> FloatArray:
    """Vertices (n, 3) [m] of an obstacle of a registered shape in space. Raises ScenarioError."""
    registered = shapes.get(entry["shape"])
    if registered is None or registered.dimension != 3:
        raise ScenarioError(f"unknown shape {entry['shape']!r}: what registers it is not loaded")
    vertices: FloatArray = np.array(registered.create(entry).vertices, dtype=float)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 4 or not np.isfinite(vertices).all():
        raise ScenarioError(
            f"shape {entry['shape']!r}: vertices: found an array of shape {vertices.shape}; "
            "allowed: (n, 3) finite numbers, of 4 or more points"
        )
    return vertices


def _identity(entry: Any) -> tuple[str, str]:
    return entry.origin.file or entry.origin.module, getattr(entry.create, "__qualname__", "")


def place_of(origin: Origin) -> str:
    """How messages call it."""
    return origin.file or origin.module
