"""Checks of the goal."""

from collections.abc import Callable, Iterator, Sequence
from math import hypot
from typing import Any

from pytest_lpb.documents.faults import Fault, Loc
from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion import Motion, NormalisedMotion, motion_from
from pytest_lpb.motion.motion import sampled_times
from pytest_lpb.problem.joint_goal import JOINT_UNITS
from pytest_lpb.problem.registries import goals as goal_types
from pytest_lpb.scenario.checks.robot import unknown_name
from pytest_lpb.scenario.schema.environment import MAX_STEPS, Environment
from pytest_lpb.scenario.schema.goal import (
    AlignmentGoal,
    Goal,
    JointGoal,
    MovingGoal,
    OrientationGoal,
    PositionGoal,
    Tolerance,
)
from pytest_lpb.scenario.schema.values import NO_DIRECTION
from pytest_lpb.scenario.structure import Structure

WORLD = "world"
WHERE = {2: "in the plane", 3: "in space"}
_SUFFIXES = ("", "_velocity", "_acceleration", "_preview")


def goal_names(goals: Sequence[Goal]) -> list[str]:
    """Names of the sub-goals, those without one by their position in the file."""
    return [goal.name or f"goal{index}" for index, goal in enumerate(goals)]


def primary_index(goals: Sequence[Goal]) -> int:
    """Position of the primary sub-goal."""
    return next((index for index, goal in enumerate(goals) if goal.primary), 0)


def check_names(goals: list[Goal]) -> Iterator[Fault]:
    """Names are unique, and so are the keys of observations made of them."""
    primary = primary_index(goals)
    taken = dict.fromkeys(("position", "velocity", "acceleration"), "the primary goal")
    names = goal_names(goals)
    for index, name in enumerate(names):
        keys = [name + suffix for suffix in _SUFFIXES]
        # goal_position is the primary goal's target: it alone may be called so.
        clash = next((key for key in keys if key in taken and (key, index) != ("position", primary)), None)
        if name in names[:index]:
            yield Fault(
                ("goal", index, "name"),
                f"{name!r} is the name of goal[{names.index(name)}] already; names are unique",
            )
        elif clash:
            yield Fault(
                ("goal", index, "name"),
                f"{name!r} makes the observation goal_{clash}, which {taken[clash]} has already",
            )
        taken |= dict.fromkeys(keys, f"goal[{index}] ({name})")


def check_primary(goals: list[Goal]) -> Iterator[Fault]:
    """At most one sub-goal is primary, and at least one defines success."""
    primary = [index for index, goal in enumerate(goals) if goal.primary]
    for index in primary[1:]:
        yield Fault(("goal", index, "primary"), f"goal[{primary[0]}] is primary already; one is allowed")
    if all(goal.tolerance is None for goal in goals):
        yield Fault(("goal",), "no sub-goal has a tolerance; without one success is undefined")


def check_tolerances(goals: list[Goal], structure: Structure) -> Iterator[Fault]:
    """A tolerance per unit has the units of the sub-goal's error, all of them."""
    for index, goal in enumerate(goals):
        if not isinstance(goal.tolerance, Tolerance):
            continue
        place = ("goal", index, "tolerance")
        given = goal.tolerance.model_dump(exclude_none=True)
        units = _units(goal, structure)
        if units and set(given) != units:
            found, needed = (" and ".join(sorted(each)) or "no unit" for each in (given, units))
            example = "{" + ", ".join(f"{unit}: {_EXAMPLES[unit]}" for unit in sorted(units)) + "}"
            yield Fault(place, f"found {found}; the error of this goal is in {needed}: one number, or {example}")


_EXAMPLES = {"m": 0.01, "rad": 0.05}


def _units(goal: Goal, structure: Structure) -> set[str]:
    """Units of a sub-goal's error; empty where they are not known: of an unknown joint, a fault of its own."""
    registered = goal_types.get(goal.type)
    if registered is not None:
        return set(filter(None, [getattr(registered.create, "unit", None)]))
    if not isinstance(goal, JointGoal):
        return {"m" if isinstance(goal, PositionGoal) else "rad"}
    types = dict(zip(structure.joints, structure.joint_types, strict=True))
    return {JOINT_UNITS[types[name]] for name in goal.joints} if set(goal.joints) <= set(types) else set()


def check_frames(goals: list[Goal], structure: Structure) -> Iterator[Fault]:
    """Links, joints and axes are those of the robot."""
    for index, goal in enumerate(goals):
        place = ("goal", index)
        yield from _dimension((*place, "type"), goal, structure)
        for position, joint in enumerate(getattr(goal, "joints", ())):
            yield from unknown_name((*place, "joints", position), joint, structure.joints, "joint")
        link = getattr(goal, "link", None)
        if link is not None:
            yield from unknown_name((*place, "link"), link, structure.links, "link")
        if isinstance(goal, PositionGoal):
            yield from _position_frames(place, goal, structure)
        elif isinstance(goal, AlignmentGoal):
            yield from _alignment_frames(place, goal, structure)


def _dimension(place: Loc, goal: Goal, structure: Structure) -> Iterator[Fault]:
    registered = goal_types.get(goal.type)
    if registered is not None and registered.dimension not in (None, structure.dimension):
        yield Fault(place, f"{goal.type} is for robots {WHERE[registered.dimension]} only")


def _position_frames(place: Loc, goal: PositionGoal, structure: Structure) -> Iterator[Fault]:
    for position, axis in enumerate(goal.axes or ()):
        if axis >= structure.dimension:
            yield Fault((*place, "axes", position), f"found {axis}; allowed are 0 to {structure.dimension - 1}")
    if goal.point is not None and len(goal.point) != structure.dimension:
        yield Fault(
            (*place, "point"),
            f"found {len(goal.point)} coordinates; {structure.dimension} required in the link's frame",
        )
    if goal.relative_to is not None:
        yield from _other_link((*place, "relative_to"), goal.relative_to, goal.link, structure)


def _alignment_frames(place: Loc, goal: AlignmentGoal, structure: Structure) -> Iterator[Fault]:
    yield from _other_link((*place, "other"), goal.other, goal.link, structure)
    for key in ("axis", "other_axis"):
        axis = getattr(goal, key)
        if len(axis) != structure.dimension:
            yield Fault((*place, key), f"found {len(axis)} numbers; {structure.dimension} required")
        elif hypot(*axis) <= NO_DIRECTION:
            found = f"a vector no longer than {NO_DIRECTION:g}" if any(axis) else "a vector of zeros"
            yield Fault((*place, key), f"found {found}; it has no direction")


def _other_link(place: Loc, name: str, link: str, structure: Structure) -> Iterator[Fault]:
    yield from unknown_name(place, name, (*structure.links, WORLD), "link")
    if name == link:
        yield Fault(place, f"found {name!r}, the sub-goal's own link; allowed: another one")


def _position_size(goal: PositionGoal, dimension: int) -> tuple[int, str]:
    return (len(goal.axes), "one per axis") if goal.axes else (dimension, "coordinates [m]")


def _orientation_size(_: OrientationGoal, dimension: int) -> tuple[int, str]:
    return (1, "an angle [rad]") if dimension == 2 else (4, "a quaternion wxyz")


def _joint_size(goal: JointGoal, _: int) -> tuple[int, str]:
    return len(goal.joints), "one per joint"


# How many coordinates the target of a sub-goal with a target has, and what they are.
_TARGET_SIZES: dict[str, Callable[[Any, int], tuple[int, str]]] = {
    "position": _position_size,
    "orientation": _orientation_size,
    "joint": _joint_size,
}


def _target_size(goal: Any, dimension: int) -> tuple[int, str]:
    registered = goal_types.get(goal.type)
    return _TARGET_SIZES[goal.type](goal, dimension) if registered is None else (registered.size, "as registered")


def check_targets(goals: list[Goal], environment: Environment, structure: Structure) -> Iterator[Fault]:
    """Each target has the right length, in one form, and stays finite for the duration."""
    for index, goal in enumerate(goals):
        if isinstance(goal, MovingGoal):
            size = _target_size(goal, structure.dimension)
            faults = list(check_motion(("goal", index), goal, "target", size, environment))
            yield from faults
            if not faults and isinstance(goal, OrientationGoal) and structure.dimension == 3:
                yield from _check_turn(("goal", index), goal, environment)


def _check_turn(place: Loc, goal: OrientationGoal, environment: Environment) -> Iterator[Fault]:
    """A quaternion has a direction at all times."""
    forms = {form: getattr(goal, form) for form in ("target", "trajectory", "spline", "periodic")}
    given = next(form for form, value in forms.items() if value is not None)
    motion = motion_from(forms, "target")
    if any(stays_finite(place, NormalisedMotion(motion), environment)):
        yield Fault((*place, given), "a quaternion of zeros is no orientation; allowed is any other, at all times")


def check_motion(
    place: Loc, part: object, key: str, size: tuple[int, str], environment: Environment
) -> Iterator[Fault]:
    """A motion is given once, in the right dimension, and stays finite for the duration.

    Args:
        place: key path of the sub-goal or obstacle.
        part: the sub-goal or obstacle itself.
        key: name of the fixed form, `target` or `position`.
        size: number of coordinates, and what they are.
        environment: settings that give the times.
    """
    entry = {form: getattr(part, form) for form in (key, "trajectory", "spline", "periodic")}
    given = next((form for form in (key, "trajectory", "spline") if entry[form] is not None), key)
    try:
        motion = motion_from(entry, key)
    except ScenarioError as error:
        yield Fault(place if "exactly one" in str(error) else (*place, given), str(error))
        return
    if entry["periodic"] and given != "spline":
        yield Fault((*place, "periodic"), "has no meaning without a spline")
    if motion.size != size[0]:
        time = " after the time" if given == "spline" else ""
        yield Fault((*place, given), f"found {motion.size} coordinates{time}; required {size[0]}: {size[1]}")
        return
    yield from stays_finite((*place, given), motion, environment)


def stays_finite(place: Loc, motion: Motion, environment: Environment) -> Iterator[Fault]:
    """A fault when the motion is undefined or out of bounds at a time of the trial."""
    steps = min(round(environment.duration / environment.dt), MAX_STEPS) if motion.moving else 0
    try:
        motion.check_finite(sampled_times(environment.dt, steps))
    except ScenarioError as error:
        yield Fault(place, str(error))
