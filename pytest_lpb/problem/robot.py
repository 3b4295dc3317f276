"""The robot of a problem: names, limits, kinematics. NumPy and scalars only; rebuilt from its dictionary."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pytest_lpb.names import suggestion
from pytest_lpb.problem.registries import robots

if TYPE_CHECKING:
    from pytest_lpb.problem.collision import CollisionSpace
    from pytest_lpb.problem.obstacle import Obstacle

FloatArray = NDArray[np.float64]

NON_HOLONOMIC_BASES = ("differential_drive", "bicycle")

# Planar robot models: model name -> "module:Class". A new one is one file and one line here.
ROBOT_MODELS: dict[str, str] = {
    "point": "pytest_lpb.problem.planar.point:Point",
    "planar_arm": "pytest_lpb.problem.planar.arm:PlanarArm",
    "differential_drive": "pytest_lpb.problem.planar.differential_drive:DifferentialDrive",
}
# All others are URDF files, or known by a name that this class knows.
SPATIAL_ROBOT = "pytest_lpb.problem.spatial.robot:SpatialRobot"


@dataclass(frozen=True)
class Limits:
    """Lower and upper limits; ±inf where there is none."""

    position: FloatArray  # (dof, 2) [rad or m]
    velocity: FloatArray  # (n_actions, 2) of u [rad/s or m/s]
    acceleration: FloatArray  # (n_actions, 2) of du/dt [rad/s^2 or m/s^2]
    effort: FloatArray  # (n_actions, 2) [N m or N]

    def to_dict(self) -> dict[str, list[list[float]]]:
        """As nested lists, with ±inf."""
        return {name: getattr(self, name).tolist() for name in ("position", "velocity", "acceleration", "effort")}


@dataclass(frozen=True)
class CollisionBody:
    """Part of the robot whose distance is measured: capsules fixed to a link.

    In the plane they are the body. In space they hold its geometry: exact for spheres and capsules, larger for others.
    """

    name: str
    link: str
    capsules: tuple[tuple[float, ...], ...]  # (ax, ay, bx, by, radius), in space (ax, ay, az, bx, by, bz, radius) [m]


class Robot(ABC):
    """A robot's kinematics and limits. Poses are in the world frame.

    Args:
        entry: the `robot` section of a concrete problem (every default filled in).
    """

    dimension: ClassVar[int]

    def __init__(self, entry: Mapping[str, Any]) -> None:
        self.entry = dict(entry)
        self.model: str | None = entry.get("model")
        self.name: str = entry["name"]
        self.control: str = entry["control"]
        self.base: str = entry["base"]
        self.body_radius: float = float(entry.get("body_radius") or 0.0)  # [m]; 0: the robot has none
        self.urdf_path: str | None = None
        self.base_pose = np.eye(self.dimension + 1)
        self.joint_names, self.joint_types = self._joints()
        self.link_names = self._links()
        self.dof = len(self.joint_names)
        self.n_actions = self._count_actions()
        self.limits = self._limits()

    @cached_property
    def collision_bodies(self) -> tuple[CollisionBody, ...]:
        """The parts whose distances are measured."""
        return self._collision_bodies()

    @cached_property
    def self_collision_pairs(self) -> tuple[tuple[str, str], ...]:
        """Pairs of bodies that must not touch."""
        return self._self_collision_pairs()

    @abstractmethod
    def _joints(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Joint names and joint types (`revolute` or `prismatic`), in the order of q."""

    @abstractmethod
    def _links(self) -> tuple[str, ...]:
        """Link names; every one has a frame."""

    @abstractmethod
    def _geometry(self) -> tuple[CollisionBody, ...]:
        """Bodies of the robot's own geometry, for `collision: geometry`."""

    @abstractmethod
    def _adjacent(self, first: str, second: str) -> bool:
        """Whether two links are joined, so that their contact says nothing."""

    @abstractmethod
    def forward_kinematics(self, q: ArrayLike, link: str) -> FloatArray:
        """Pose of a link's frame in the world at q (dof,): (4, 4), planar (3, 3). Raises ValueError: unknown link."""

    @abstractmethod
    def jacobian(self, q: ArrayLike, link: str) -> FloatArray:
        """Velocity of a link's frame per qd, (6, dof), planar (3, dof); linear rows first, world axes."""

    @abstractmethod
    def integrate(
        self, q: list[float], u: list[float], action: list[float], dt: float
    ) -> tuple[list[float], list[float]]:
        """State (q, u) after dt [s] under the constant action: du/dt under acceleration control, else u itself."""

    @abstractmethod
    def joint_velocity(self, q: Sequence[float], u: list[float]) -> list[float]:
        """qd at q under the actuated velocity u."""

    @abstractmethod
    def frames(self, q: Sequence[float]) -> Sequence[tuple[float, ...]]:
        """Frames of all links at q, in the order of `link_names`, as sub-goals read them."""

    def frames_of(self, configurations: FloatArray) -> list[Sequence[tuple[float, ...]]]:
        """Frames as `frames` gives them, at each of several q (N, dof)."""
        return [self.frames(q) for q in configurations.tolist()]

    @abstractmethod
    def collision_space(self, obstacles: Sequence[Obstacle]) -> CollisionSpace:
        """Where this robot's clearance can be asked for; to be closed."""

    @abstractmethod
    def link_positions(self, q: FloatArray) -> FloatArray:
        """Positions of all link frames along a trajectory q (N, dof): (N, links, 2 or 3) [m]."""

    def action_map(self, q: ArrayLike) -> FloatArray:  # noqa: ARG002 - constant for holonomic robots
        """B with qd = B u, (dof, n_actions)."""
        return np.eye(self.dof)

    @property
    def action_kinds(self) -> tuple[str, ...]:
        """What each entry of u is the rate of: prismatic [m] or revolute [rad]."""
        return self.joint_types

    @property
    def action_names(self) -> tuple[str, ...]:
        """Names of the entries of u: the joints' where each has its own."""
        return self.joint_names if self.n_actions == self.dof else tuple(f"u{i}" for i in range(self.n_actions))

    @property
    def non_holonomic(self) -> bool:
        """Whether u has fewer entries than q, since the base cannot move sideways."""
        return self.base in NON_HOLONOMIC_BASES

    @property
    def reach(self) -> float:
        """Largest distance of a link's frame from the base [m]; inf for a robot that moves about."""
        return inf

    @property
    def headings(self) -> tuple[int, ...]:
        """Indices in q of headings of a base: angles without limits, whose errors are wrapped."""
        return (2,) if self.non_holonomic else ()

    def link_index(self, link: str) -> int:
        """Position of a link in `link_names`. Raises ValueError for an unknown one."""
        try:
            return self.link_names.index(link)
        except ValueError:
            hint = suggestion(link, self.link_names)
            raise ValueError(f"no link {link!r} in {self.name}{hint}; links: {', '.join(self.link_names)}") from None

    def to_dict(self) -> dict[str, Any]:
        """The `robot` section this robot was built from."""
        return dict(self.entry)

    def hashed(self) -> dict[str, Any]:
        """What identifies the robot, wherever its files lie."""
        return self.entry

    def _count_actions(self) -> int:
        return self.dof

    def _limits(self) -> Limits:
        given = self.entry.get("limits") or {}
        return Limits(
            position=limit_array(given.get("position"), self.dof),
            velocity=limit_array(given.get("velocity"), self.n_actions),
            acceleration=limit_array(given.get("acceleration"), self.n_actions),
            effort=limit_array(given.get("effort"), self.n_actions),
        )

    def _collision_bodies(self) -> tuple[CollisionBody, ...]:
        collision = self.entry.get("collision", "geometry")
        if collision == "geometry":
            return self._geometry()
        if "link_spheres" in collision:
            radius = float(collision["link_spheres"])
            return tuple(CollisionBody(link, link, ((0.0, 0.0, 0.0, 0.0, radius),)) for link in self.link_names)
        return tuple(
            CollisionBody(link, link, tuple((s[0], s[1], s[0], s[1], s[-1]) for s in spheres))
            for link, spheres in collision["spheres"].items()
        )

    def _self_collision_pairs(self) -> tuple[tuple[str, str], ...]:
        given = self.entry.get("self_collision_pairs")
        if given is not None and not isinstance(given, Mapping):
            return tuple((str(first), str(second)) for first, second in given)
        excepted = {frozenset(pair) for pair in (given or {}).get("except", ())}
        return tuple(pair for pair in self._default_pairs() if frozenset(pair) not in excepted)

    def _default_pairs(self) -> tuple[tuple[str, str], ...]:
        """Pairs of bodies that can collide, where a scenario lists none."""
        bodies = self.collision_bodies
        return tuple(
            (first.name, second.name)
            for index, first in enumerate(bodies)
            for second in bodies[index + 1 :]
            if not self._adjacent(first.link, second.link)
        )


def limit_array(entries: Sequence[Sequence[float] | None] | None, count: int) -> FloatArray:
    """Limits of a scenario as (count, 2); None, for one entry or for all, means unlimited."""
    limits = np.empty((count, 2))
    limits[:] = (-np.inf, np.inf)
    for index, entry in enumerate(entries or ()):
        if entry is not None:
            limits[index] = entry
    return limits


def robot_from(entry: Mapping[str, Any]) -> Robot:
    """The robot of a concrete problem's `robot` section. Raises ScenarioError for an unknown model."""
    model = entry.get("model") or ""
    registered = robots.get(model) if model and model not in ROBOT_MODELS else None
    if registered is not None and registered.create is not None:
        own: Robot = registered.create(entry)
        return own
    target = ROBOT_MODELS.get(model, SPATIAL_ROBOT)
    module, _, name = target.partition(":")
    robot: Robot = getattr(import_module(module), name)(entry)
    return robot
