"""Checks of the robot and its start."""

from collections.abc import Iterator, Sequence

from pytest_lpb.documents.faults import Fault
from pytest_lpb.errors import ScenarioError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.scenario.robots import is_planar
from pytest_lpb.scenario.schema.available import controls_of, engines_of
from pytest_lpb.scenario.schema.environment import Environment, Start
from pytest_lpb.scenario.schema.robot import CollisionSpheres, ExceptPairs, Robot
from pytest_lpb.scenario.self_collision import concrete_pairs
from pytest_lpb.scenario.structure import COMMON_KEYS, Model, Structure, planar_model, planar_models, planar_structure


def check_model(robot: Robot) -> Iterator[Fault]:
    """The robot is of a model that is known, or of a URDF file, and has no keys of other models."""
    if (robot.model is None) == (robot.urdf is None):
        found = "neither" if robot.model is None else "both"
        yield Fault(("robot",), f"found {found} of model and urdf; exactly one is required")
    elif is_planar(robot):
        model = planar_model(robot.model or "")
        assert model is not None
        faults = list(_check_keys(robot, model))
        yield from faults or _check_made(robot)
    else:
        yield from _check_spatial(robot)


def _check_made(robot: Robot) -> Iterator[Fault]:
    """The class of a registered robot takes its keys."""
    try:
        planar_structure(robot)
    except ScenarioError as error:
        yield Fault(("robot",), str(error))


def _check_spatial(robot: Robot) -> Iterator[Fault]:
    # Imported late: planar scenarios need none of it.
    from pytest_lpb.scenario.spatial import RobotFaultError, SpatialDescription, spatial_models

    known = sorted({*planar_models(), *spatial_models()})
    if robot.model is not None and robot.model not in known:
        yield Fault(
            ("robot", "model"), f"unknown {robot.model!r}{suggestion(robot.model, known)}; allowed: {', '.join(known)}"
        )
        return
    try:
        SpatialDescription(robot)
    except RobotFaultError as error:
        yield error.fault


def _check_keys(robot: Robot, model: Model) -> Iterator[Fault]:
    allowed = COMMON_KEYS | model.keys
    given = {key for key in robot.model_fields_set if getattr(robot, key) is not None}
    for key in sorted(given - allowed):
        yield Fault(("robot", key), f"has no meaning for the model {robot.model}; allowed: {listed(allowed)}")
    if robot.base not in (None, model.base):
        yield Fault(
            ("robot", "base"),
            f"{robot.base} is not available for the model {robot.model}; allowed: {model.base}",
        )
    for key in model.required:
        if getattr(robot, key) is None:
            hint = f"; {robot.model} needs a count of links, or their lengths [m]" if key == "links" else ""
            yield Fault(("robot", key), f"is missing{hint}")
    if robot.limits is not None and robot.limits.effort is not None:
        yield Fault(("robot", "limits", "effort"), "has no meaning in the plane, where nothing is driven by forces")


def check_engine_fits(robot: Robot, environment: Environment, structure: Structure) -> Iterator[Fault]:
    """Planar robots run in the planar engine, spatial ones in PyBullet."""
    wanted = engines_of(structure.dimension)
    if environment.engine not in wanted:
        name = robot.model or "a URDF robot"
        yield Fault(
            ("environment", "engine"),
            f"{environment.engine} does not have {name}; write environment: {{engine: {' or '.join(wanted)}}}",
        )


def check_control(robot: Robot, environment: Environment) -> Iterator[Fault]:
    """The engine can apply this kind of action."""
    allowed = controls_of(environment.engine)
    if robot.control not in allowed:
        yield Fault(
            ("robot", "control"),
            f"{robot.control} is not available with the engine {environment.engine}; allowed: {listed(allowed)}",
        )
    elif robot.control == "torque" and not environment.dynamics:
        yield Fault(("robot", "control"), "torque needs simulated forces; write environment: {dynamics: true}")


def check_limits(robot: Robot, structure: Structure) -> Iterator[Fault]:
    """One limit per joint, or per action."""
    names = {"position": structure.joints}
    names |= dict.fromkeys(("velocity", "acceleration", "effort"), structure.actions)
    for key, entries in names.items():
        given = getattr(robot.limits, key, None)
        if given is not None and len(given) != len(entries):
            yield Fault(("robot", "limits", key), wrong_length(given, entries))


def wrong_length(given: Sequence[object], names: Sequence[str]) -> str:
    """What to say of a list that is not as long as the names of its entries."""
    return f"found {len(given)} entries; {len(names)} required: {', '.join(names)}"


def check_spheres(robot: Robot, structure: Structure) -> Iterator[Fault]:
    """Collision spheres: one form, on links that exist, in the plane for planar robots."""
    if not isinstance(robot.collision, CollisionSpheres):
        return
    place = ("robot", "collision")
    spheres = robot.collision.spheres
    if (spheres is None) == (robot.collision.link_spheres is None):
        found = "neither" if spheres is None else "both"
        yield Fault(place, f"found {found} of spheres and link_spheres; exactly one is required")
        return
    for link, rows in (spheres or {}).items():
        yield from unknown_name((*place, "spheres", link), link, structure.links, "link")
        for index, (_, _, z, radius) in enumerate(rows):
            if radius <= 0.0 or (structure.dimension == 2 and z != 0.0):
                yield Fault(
                    (*place, "spheres", link, index),
                    f"found z = {z:g}, r = {radius:g}; allowed: r > 0, and z = 0 for planar robots",
                )


def unknown_name(loc: tuple[str | int, ...], name: str, allowed: Sequence[str], kind: str) -> Iterator[Fault]:
    """A fault when `name` is none of the allowed ones."""
    if name not in allowed:
        hint = suggestion(name, allowed)
        yield Fault(loc, f"unknown {kind} {name!r}{hint}; allowed: {', '.join(allowed)}")


PAIRS = ("robot", "self_collision_pairs")


def check_pairs(robot: Robot, structure: Structure) -> Iterator[Fault]:
    """Self-collision pairs, or those that are excepted, name two bodies that exist, each pair once."""
    given = robot.self_collision_pairs
    if not isinstance(given, ExceptPairs):
        yield from _check_listed(PAIRS, given or (), structure)
        return
    if given.except_ is None and given.srdf is None:
        yield Fault(PAIRS, "found neither except nor srdf; one of them, or both, are required")
    yield from _check_listed((*PAIRS, "except"), given.except_ or (), structure)
    if given.srdf is not None:
        try:
            concrete_pairs(robot, structure.links, structure.bodies)
        except ScenarioError as error:
            yield Fault((*PAIRS, "srdf"), str(error))


def _check_listed(above: tuple[str, ...], pairs: Sequence[Sequence[str]], structure: Structure) -> Iterator[Fault]:
    seen: dict[frozenset[str], int] = {}
    for index, pair in enumerate(pairs):
        place: tuple[str | int, ...] = (*above, index)
        for position, body in enumerate(pair):
            yield from unknown_name((*place, position), body, structure.bodies, "body")
        first = seen.setdefault(frozenset(pair), index)
        if first != index:
            yield Fault(place, f"found {list(pair)} again; it is pair {first} already")


def check_start(start: Start, robot: Robot, structure: Structure) -> Iterator[Fault]:
    """The start has one number per joint and per action, and lies within the position limits."""
    other = {"qd": "u", "u": "qd"}[structure.velocity_key]
    if getattr(start, other) is not None:
        named = f"the model {robot.model}" if robot.model else "this URDF robot"
        yield Fault(
            ("start", other),
            f"has no meaning for {named}; its start velocity is {structure.velocity_key}: "
            f"{', '.join(structure.actions)}",
        )
    velocity = getattr(start, structure.velocity_key)
    if velocity is not None and len(velocity) != len(structure.actions):
        yield Fault(("start", structure.velocity_key), wrong_length(velocity, structure.actions))
    if start.q is not None and len(start.q) != structure.dof:
        yield Fault(("start", "q"), wrong_length(start.q, structure.joints))
        return
    default = "" if start.q else "; where start.q is not given, all joints start at 0"
    for fault in _outside_limits(start.q or [0.0] * structure.dof, robot, structure):
        yield Fault(fault.loc, fault.message + default)


def position_limits(robot: Robot, structure: Structure) -> Sequence[list[float] | None]:
    """Position limits per q [rad or m]: the file's, else the URDF's; None: unlimited."""
    return structure.position_limits or (robot.limits.position if robot.limits else None) or ()


def _outside_limits(q: Sequence[float], robot: Robot, structure: Structure) -> Iterator[Fault]:
    limits = position_limits(robot, structure)
    for index, (value, limit) in enumerate(zip(q, limits, strict=False)):
        if limit is not None and not limit[0] <= value <= limit[1]:
            yield Fault(("start", "q", index), f"joint {index + 1}: {value:g} is outside [{limit[0]:g}, {limit[1]:g}]")
