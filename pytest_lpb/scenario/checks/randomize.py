"""Checks of the ranges that problems are drawn from."""

from collections.abc import Iterator, Sequence

from pytest_lpb.documents.faults import Fault, Loc
from pytest_lpb.scenario.checks.goal import primary_index
from pytest_lpb.scenario.checks.obstacles import wrong_shape
from pytest_lpb.scenario.checks.robot import position_limits, wrong_length
from pytest_lpb.scenario.schema.available import dimension_of, shapes_of
from pytest_lpb.scenario.schema.environment import Environment
from pytest_lpb.scenario.schema.goal import Goal, MovingGoal, PositionGoal
from pytest_lpb.scenario.schema.randomize import BoxGroup, Configuration, Group, Randomize
from pytest_lpb.scenario.schema.robot import Robot
from pytest_lpb.scenario.schema.values import MAX_COORDINATE
from pytest_lpb.scenario.structure import Structure


def check_draw(randomize: Randomize | None) -> Iterator[Fault]:
    """Every part to draw has a range."""
    if randomize is None:
        return
    for index, part in enumerate(randomize.draw):
        if getattr(randomize, part) is None:
            yield Fault(("randomize", "draw", index), f"found {part}, but randomize has no {part} ranges")


def check_configurations(randomize: Randomize | None, robot: Robot, structure: Structure) -> Iterator[Fault]:
    """Ranges of q have one entry per joint, within the joint's limits."""
    for part in ("start", "goal"):
        ranges = getattr(randomize, part, None)
        if not isinstance(ranges, Configuration):
            continue
        place = ("randomize", part, "q")
        if len(ranges.q) != structure.dof:
            yield Fault(place, wrong_length(ranges.q, structure.joints))
            continue
        limits = position_limits(robot, structure)
        for index, ((lower, upper), limit) in enumerate(zip(ranges.q, limits, strict=False)):
            if limit is not None and not limit[0] <= lower <= upper <= limit[1]:
                yield Fault(
                    (*place, index),
                    f"joint {index + 1}: [{lower:g}, {upper:g}] reaches outside [{limit[0]:g}, {limit[1]:g}]",
                )


def check_goal(randomize: Randomize | None, goals: list[Goal]) -> Iterator[Fault]:
    """The goals to draw have fixed targets; a box is for a position."""
    if randomize is None or randomize.goal is None:
        return
    place = ("randomize", "goal")
    for index, goal in enumerate(goals):
        moves = isinstance(goal, MovingGoal) and goal.target is None
        if moves and (index == primary_index(goals) or isinstance(randomize.goal, Configuration)):
            yield Fault(place, f"goal[{index}] moves; only fixed targets can be drawn")
    primary = goals[primary_index(goals)]
    if isinstance(randomize.goal, Configuration):
        return
    if not isinstance(primary, PositionGoal):
        yield Fault(
            place,
            f"a box is for a position, and the primary sub-goal is of type {primary.type}; allowed: {{q: ranges}}",
        )
    elif primary.target is not None and len(randomize.goal) != len(primary.target):
        yield Fault(
            place,
            f"found {len(randomize.goal)} ranges; {len(primary.target)} required, as the primary target has",
        )


def check_groups(randomize: Randomize | None, environment: Environment) -> Iterator[Fault]:
    """Groups of drawn obstacles have shapes of the engine and ranges of its dimension."""
    allowed = shapes_of(environment.engine)
    groups = (randomize.obstacles if randomize else None) or []
    for index, group in enumerate(groups):
        place = ("randomize", "obstacles", index)
        if group.shape not in allowed:
            yield Fault((*place, "shape"), wrong_shape(group.shape, environment.engine, allowed))
            continue
        for key in ("position", "velocity"):
            yield from _ranges((*place, key), getattr(group, key), dimension_of(environment.engine))
        if isinstance(group, BoxGroup):
            yield from _ranges((*place, "size"), group.size, dimension_of(environment.engine))
        yield from _farthest(place, group, environment.duration)


def _farthest(place: Loc, group: Group, duration: float) -> Iterator[Fault]:
    speed = max((abs(bound) for pair in group.velocity or () for bound in pair), default=0.0)  # [m/s]
    reach = max(abs(bound) for pair in group.position for bound in pair) + speed * duration  # [m]
    if reach > MAX_COORDINATE:
        yield Fault(
            (*place, "velocity"),
            f"a drawn obstacle may go as far as {reach:.3g} m in {duration:g} s; allowed are {MAX_COORDINATE:g} m",
        )


def _ranges(place: Loc, ranges: Sequence[object] | None, dimension: int) -> Iterator[Fault]:
    if ranges is not None and len(ranges) != dimension:
        where = {2: "in the plane", 3: "in space"}[dimension]
        yield Fault(place, f"found {len(ranges)} ranges; {dimension} required {where}")
