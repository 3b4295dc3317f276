"""What follows from a planar robot's model: its joints, links, bodies, and how many actions it takes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pytest_lpb.errors import ScenarioError, in_one_line
from pytest_lpb.problem.registries import RobotType, default_of, robots
from pytest_lpb.problem.robot import NON_HOLONOMIC_BASES, robot_from
from pytest_lpb.scenario.schema.robot import CollisionSpheres, Robot

Names = tuple[str, ...]

DEFAULT_WHEEL_BASE = 0.5  # [m]
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
        defaults: of these keys.
        velocity_key: key of the start velocity: `qd`, or `u` for non-holonomic bases.
        joints, actions, links, bodies: names of the entries of q and of u, of links and bodies; of a registered robot
            its class says them.
    """

    base: str
    body_radius: float
    keys: frozenset[str]
    velocity_key: str
    joints: Callable[[int], Names] = lambda _: ()
    joint_types: Callable[[int], Names] = lambda _: ()
    actions: Callable[[int], Names] = lambda _: ()
    links: Callable[[int], Names] = lambda _: ()
    bodies: Callable[[int], Names] = lambda _: ()
    defaults: Mapping[str, Any] = field(default_factory=dict)

    @property
    def required(self) -> list[str]:
        """Keys that have no default."""
        return sorted(self.keys - self.defaults.keys())


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
        joint_types=_fixed("prismatic", "prismatic"),
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
        joint_types=lambda count: ("revolute",) * count,
        actions=_numbered("joint"),
        links=_numbered("link", before=("base",), after=("end",)),
        bodies=_numbered("link", before=("base",)),
    ),
    "differential_drive": Model(
        base="differential_drive",
        body_radius=0.2,
        keys=frozenset({"wheel_base"}),
        defaults={"wheel_base": DEFAULT_WHEEL_BASE},
        velocity_key="u",
        joints=_fixed("x", "y", "theta"),
        joint_types=_fixed("prismatic", "prismatic", "revolute"),
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
    joint_types: Names  # per q: prismatic or revolute
    position_limits: tuple[list[float] | None, ...] = ()  # in space, per q [rad or m]; None: unlimited

    @property
    def dof(self) -> int:
        """Length of q."""
        return len(self.joints)


def planar_models() -> list[str]:
    """Names of planar robots."""
    return [*MODELS, *(robot.name for robot in robots.all() if robot.urdf is None)]


def planar_model(name: str) -> Model | None:
    """A planar robot known by name."""
    registered = None if name in MODELS or not name else robots.get(name)
    if registered is None or registered.urdf is not None:
        return MODELS.get(name)
    defaults = {key: default for key, (_, default) in _keys_of(registered) if default is not ...}
    return Model(
        base=registered.base,
        body_radius=registered.body_radius,
        keys=frozenset(registered.keys),
        velocity_key="u" if registered.base in NON_HOLONOMIC_BASES else "qd",
        defaults=defaults,
    )


def _keys_of(registered: RobotType) -> list[tuple[str, tuple[Any, Any]]]:
    return [(key, default_of(kind)) for key, kind in registered.keys.items()]


def planar_entry(robot: Robot) -> dict[str, Any]:
    """The `robot` section of a planar robot, every default filled in."""
    model = planar_model(robot.model or "")
    assert model is not None, "only planar robots come here"
    links = robot.links or []
    plain: dict[str, Any] = {
        "model": robot.model,
        "name": robot.name or (f"{robot.model}_{len(links)}" if links else robot.model),
    }
    if "links" in model.keys:
        plain["links"] = list(links)
    plain["control"] = robot.control
    plain["base"] = model.base
    plain["body_radius"] = model.body_radius if robot.body_radius is None else robot.body_radius
    for key in sorted(model.keys - {"links"}):
        given = getattr(robot, key)
        plain[key] = model.defaults[key] if given is None else given
    plain["collision"] = (
        robot.collision if isinstance(robot.collision, str) else robot.collision.model_dump(exclude_none=True)
    )
    plain["limits"] = {key: getattr(robot.limits, key, None) for key in ("position", "velocity", "acceleration")}
    return plain


def _registered_structure(robot: Robot) -> Structure:
    """What the class of a registered robot says. Raises ScenarioError for keys that it refuses."""
    try:
        built = robot_from(planar_entry(robot))
        bodies = tuple(dict.fromkeys(body.name for body in built.collision_bodies))
    except (ScenarioError, ValueError, TypeError, KeyError) as error:
        raise ScenarioError(f"{robot.model} cannot be made: {in_one_line(error)}") from error
    return Structure(
        dimension=2,
        velocity_key="u" if built.non_holonomic else "qd",
        joints=built.joint_names,
        joint_types=built.joint_types,
        actions=built.action_names,
        links=built.link_names,
        bodies=bodies,
    )


def planar_structure(robot: Robot) -> Structure | None:
    """The structure of a planar robot; None for others."""
    model = planar_model(robot.model or "")
    if model is None or robot.urdf is not None or any(getattr(robot, key) is None for key in model.required):
        return None
    if robot.model not in MODELS:
        return _registered_structure(robot)
    count = len(robot.links or ())
    links = model.links(count)
    bodies = model.bodies(count)
    if isinstance(robot.collision, CollisionSpheres):
        bodies = tuple(robot.collision.spheres or links)
    return Structure(
        dimension=2,
        velocity_key=model.velocity_key,
        joints=model.joints(count),
        joint_types=model.joint_types(count),
        actions=model.actions(count),
        links=links,
        bodies=bodies,
    )
