"""What follows from a planar robot's model: its joints, links, bodies, and how many actions it takes."""

from collections.abc import Callable
from dataclasses import dataclass

from pytest_lpb.scenario.schema.robot import CollisionSpheres, Robot

Names = tuple[str, ...]

COMMON_KEYS = frozenset(
    {"model", "name", "control", "base", "body_radius", "collision", "limits", "self_collision_pairs"}
)


@dataclass(frozen=True)
class Model:
    """A robot model known by name; the functions take its number of links.

    Attributes:
        base: its only base.
        body_radius: default radius of its bodies [m].
        keys: keys of `robot` that only this model has.
        velocity_key: key of the start velocity: `qd`, or `u` for non-holonomic bases.
        actions: names of the entries of u.
    """

    base: str
    body_radius: float
    keys: frozenset[str]
    velocity_key: str
    joints: Callable[[int], Names]
    actions: Callable[[int], Names]
    links: Callable[[int], Names]
    bodies: Callable[[int], Names]


def _fixed(*names: str) -> Callable[[int], Names]:
    return lambda _: names


def _numbered(prefix: str, before: Names = (), after: Names = ()) -> Callable[[int], Names]:
    return lambda count: (*before, *(f"{prefix}{index}" for index in range(1, count + 1)), *after)


# A new planar model is one entry here (and its class in pytest_lpb.problem).
MODELS: dict[str, Model] = {
    "point": Model(
        base="fixed",
        body_radius=0.2,
        keys=frozenset(),
        velocity_key="qd",
        joints=_fixed("x", "y"),
        actions=_fixed("x", "y"),
        links=_fixed("body"),
        bodies=_fixed("body"),
    ),
    "planar_arm": Model(
        base="fixed",
        body_radius=0.1,
        keys=frozenset({"links"}),
        velocity_key="qd",
        joints=_numbered("joint"),
        actions=_numbered("joint"),
        links=_numbered("link", before=("base",), after=("end",)),
        bodies=_numbered("link", before=("base",)),
    ),
    "differential_drive": Model(
        base="differential_drive",
        body_radius=0.2,
        keys=frozenset({"wheel_base"}),
        velocity_key="u",
        joints=_fixed("x", "y", "theta"),
        actions=_fixed("v", "w"),
        links=_fixed("base"),
        bodies=_fixed("base"),
    ),
}


@dataclass(frozen=True)
class Structure:
    """Names of a robot's parts."""

    dimension: int
    velocity_key: str
    joints: Names  # in the order of q
    actions: Names  # in the order of u
    links: Names
    bodies: Names
    position_limits: tuple[list[float] | None, ...] = ()  # in space, per q [rad or m]; None: unlimited

    @property
    def dof(self) -> int:
        """Length of q."""
        return len(self.joints)


def planar_structure(robot: Robot) -> Structure | None:
    """The structure of a planar robot; None for others."""
    model = MODELS.get(robot.model or "")
    if model is None or robot.urdf is not None or ("links" in model.keys and robot.links is None):
        return None
    count = len(robot.links or ())
    links = model.links(count)
    bodies = model.bodies(count)
    if isinstance(robot.collision, CollisionSpheres):
        bodies = tuple(robot.collision.spheres or links)
    return Structure(
        dimension=2,
        velocity_key=model.velocity_key,
        joints=model.joints(count),
        actions=model.actions(count),
        links=links,
        bodies=bodies,
    )
