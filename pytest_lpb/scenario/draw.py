"""Draws a concrete problem from a scenario: start, then goal, then obstacles that leave both free.

Values of one attempt never depend on how many attempts another item needed: every round draws anew for all items of a
part, and an item takes the first round that suits it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from math import cos, sin
from typing import Any

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.collision import CollisionSpace
from pytest_lpb.problem.goal import SubGoal, goal_from
from pytest_lpb.problem.hashing import copied
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.registries import default_of, shapes
from pytest_lpb.problem.robot import FloatArray, Robot, robot_from
from pytest_lpb.scenario.feasibility import goal_fault, is_free, start_fault
from pytest_lpb.scenario.inverse_kinematics import goal_configurations
from pytest_lpb.scenario.load import Scenario
from pytest_lpb.scenario.streams import Stream

PARTS = ("start", "goal", "obstacles")
MAX_ATTEMPTS = 1000


def parts_drawn(scenario: Scenario, flags: Iterable[str] = ()) -> tuple[str, ...]:
    """Parts of a scenario that are drawn: those it names, and those of `flags` that have ranges."""
    wanted = {*scenario.draw, *flags}
    return tuple(part for part in PARTS if part in wanted and scenario.randomize.get(part) is not None)


def obstacle_counts(scenario: Scenario, flags: Iterable[str] = ()) -> tuple[int, int]:
    """Fewest and most obstacles that a problem of this scenario can have."""
    listed = len(scenario.concrete["obstacles"])
    if "obstacles" not in parts_drawn(scenario, flags):
        return listed, listed
    kept = listed if scenario.keep_obstacles else 0
    counts = [group["count"] for group in scenario.randomize["obstacles"]]
    return kept + sum(fewest for fewest, _ in counts), kept + sum(most for _, most in counts)


def draw_problem(scenario: Scenario, seed: int, flags: Iterable[str] = (), name: str | None = None) -> Problem:
    """The problem of a seed.

    Args:
        scenario: the family of problems.
        seed: which one.
        flags: parts to draw besides those the scenario draws; parts without ranges stay fixed.
        name: the problem's name; default the file's stem.

    Raises ScenarioError when no feasible problem is found within 1000 attempts per item.
    """
    parts = parts_drawn(scenario, flags)
    draw = _Draw(scenario, seed, parts)
    try:
        draw.run(parts)
    finally:
        draw.close()
    return Problem.from_dict(draw.entry, scenario.path.stem if name is None else name)


def check_feasible(scenario: Scenario, flags: Iterable[str] = ()) -> None:
    """Check what no seed changes: a start and goal that are not drawn must be free and within reach.

    Raises ScenarioError with the file and line of the start or the goal.
    """
    parts = parts_drawn(scenario, flags)
    entry = scenario.concrete
    robot = robot_from(entry["robot"])
    obstacles = _listed_obstacles(scenario, parts)
    _check_loads(scenario, robot, obstacles)
    faults = []
    if "start" not in parts:
        fault = start_fault(robot, entry["start"]["q"], obstacles)
        if fault:
            faults.append(f"{scenario.place(('start',))}: start: {fault}")
    if "goal" not in parts:
        goal = goal_from(entry["goal"], robot)
        fault = goal_fault(robot, goal, np.array(entry["start"]["q"], dtype=float), obstacles)
        if fault:
            faults.append(f"{scenario.place(('goal',))}: goal: {fault}")
    if faults:
        raise ScenarioError(*faults)


def _check_loads(scenario: Scenario, robot: Robot, obstacles: Sequence[Obstacle]) -> None:
    """Check that robot and obstacles can be put into a world. Raises ScenarioError with the place of what cannot."""
    for key, present in (("robot", ()), ("obstacles", obstacles)):
        try:
            robot.collision_space(present).close()
        except ScenarioError as error:
            raise ScenarioError(f"{scenario.place((key,))}: {key}: {error}") from None


def _listed_obstacles(scenario: Scenario, parts: Sequence[str]) -> list[Obstacle]:
    if "obstacles" in parts and not scenario.keep_obstacles:
        return []
    return [Obstacle(entry) for entry in scenario.concrete["obstacles"]]


class _Draw:
    """One problem in the making; `entry` is its concrete dictionary."""

    def __init__(self, scenario: Scenario, seed: int, parts: tuple[str, ...]) -> None:
        self._scenario = scenario
        self._seed = seed
        self.entry: dict[str, Any] = copied(scenario.concrete)
        self.entry["seed"] = seed
        self.entry["trials"] = 1
        self._drop_certificate(parts)
        self._robot = robot_from(self.entry["robot"])
        self._obstacles = _listed_obstacles(scenario, parts)
        self.entry["obstacles"] = [obstacle.entry for obstacle in self._obstacles]

    @cached_property
    def _space(self) -> CollisionSpace:
        """Opened when the first part is drawn."""
        return self._robot.collision_space(self._obstacles)

    def close(self) -> None:
        """Free what drawing needed."""
        if "_space" in self.__dict__:
            self._space.close()

    def run(self, parts: tuple[str, ...]) -> None:
        """Draw the parts, each given those before."""
        if "start" in parts:
            self._draw_start()
        self._start_q: FloatArray = np.array(self.entry["start"]["q"], dtype=float)
        if "goal" in parts:
            self._draw_goal()
        if "obstacles" in parts:
            self._draw_obstacles()

    def _drop_certificate(self, parts: tuple[str, ...]) -> None:
        """Keep a certified path only where it is of this very problem."""
        certified = self.entry.get("certified")
        same = set(parts) == set(parts_drawn(self._scenario)) and (
            not parts or certified is None or certified["seed"] == self._seed
        )
        if certified is not None and not same:
            del self.entry["certified"]

    def _stream(self, part: str, index: int = 0) -> Stream:
        return Stream(self._seed, part, self._scenario.randomize[part], index)

    def _draw_start(self) -> None:
        ranges = self._scenario.randomize["start"]["q"]
        stream = self._stream("start")
        for _ in range(MAX_ATTEMPTS):
            q = stream.uniform(ranges)
            if is_free(self._space, q, self._scenario.margin):
                self.entry["start"]["q"] = q
                return
        raise self._fault("start", "every start drawn from these ranges was in collision")

    def _draw_goal(self) -> None:
        ranges = self._scenario.randomize["goal"]
        stream = self._stream("goal")
        reachable = isinstance(ranges, dict)
        for _ in range(MAX_ATTEMPTS):
            if reachable:
                q = stream.uniform(ranges["q"])
                if not is_free(self._space, q, self._scenario.margin):
                    continue
                if not self._aligned(q):
                    continue
                self._aim_at(q)
                self._goal_configurations = [np.array(q)]
                return
            self._set_primary(stream.uniform(ranges))
            if self._find_goal_configurations():
                return
        raise self._fault("goal", "every goal drawn from these ranges was in collision or out of reach")

    def _goal(self) -> tuple[SubGoal, ...]:
        return goal_from(self.entry["goal"], self._robot)

    def _aim_at(self, q: list[float]) -> None:
        """Put every target where the robot has it at q."""
        frames = self._robot.frames(q)
        for entry, sub_goal in zip(self.entry["goal"], self._goal(), strict=True):
            if sub_goal.type != "alignment":
                _fix_target(entry, sub_goal.value(q, frames))

    def _aligned(self, q: list[float]) -> bool:
        """Whether q meets the alignments that are required: they have no target that could be put there."""
        frames = self._robot.frames(q)
        return all(
            sub_goal.distance(sub_goal.value(q, frames), [0.0]) <= sub_goal.tolerance
            for sub_goal in self._goal()
            if sub_goal.type == "alignment" and sub_goal.tolerance is not None
        )

    def _set_primary(self, target: list[float]) -> None:
        _fix_target(next(entry for entry in self.entry["goal"] if entry["primary"]), target)

    def _find_goal_configurations(self) -> bool:
        """Configurations at the goal that keep the margin from the obstacles so far; whether there is any."""
        required = [goal for goal in self._goal() if goal.tolerance is not None and not goal.moving]
        found = goal_configurations(self._robot, required, self._start_q) if required else []
        self._goal_configurations = [q for q in found if is_free(self._space, q.tolist(), self._scenario.margin)]
        return bool(self._goal_configurations) or not required

    def _draw_obstacles(self) -> None:
        if not hasattr(self, "_goal_configurations"):
            self._find_goal_configurations()
        number = 0
        for index, group in enumerate(self._scenario.randomize["obstacles"]):
            stream = self._stream("obstacles", index)
            count = stream.integer(*group["count"])
            names = [f"drawn{number + i}" for i in range(count)]
            number += count
            self.entry["obstacles"] += self._draw_group(group, names, stream, index)

    def _draw_group(self, group: dict[str, Any], names: list[str], stream: Stream, index: int) -> list[dict[str, Any]]:
        fields, ranges = _group_ranges(group)
        fixed = {key: group[key] for key in _size_keys(group["shape"])[1] if key in group}
        placed: dict[int, dict[str, Any]] = {}
        for _ in range(MAX_ATTEMPTS):
            for item, values in enumerate(stream.rows(len(names), ranges)):
                if item not in placed:
                    entry = _obstacle_entry(names[item], group["shape"], fields, values) | fixed
                    if self._suits(entry):
                        placed[item] = entry
            if len(placed) == len(names):
                return [placed[item] for item in range(len(names))]
        missing = next(item for item in range(len(names)) if item not in placed)
        raise self._fault(f"obstacles[{index}]", f"obstacle {names[missing]!r} always blocked the start or the goal")

    def _suits(self, entry: dict[str, Any]) -> bool:
        """Whether an obstacle leaves the start free, and a configuration at the goal besides those lost before."""
        margin = self._scenario.margin
        space, obstacle = self._space, Obstacle(entry)
        if space.clearance_of(obstacle, self._start_q.tolist()) < margin:
            return False
        if not self._goal_configurations:
            return True
        left = [q for q in self._goal_configurations if not space.clearance_of(obstacle, q.tolist()) < margin]
        if left:
            self._goal_configurations = left
        return bool(left)

    def _fault(self, part: str, what: str) -> ScenarioError:
        key = part.partition("[")[0]
        place = self._scenario.place(("randomize", key))
        return ScenarioError(
            f"{place}: randomize.{part}: seed {self._seed}: {what} ({MAX_ATTEMPTS} attempts); "
            "widen the ranges, or use fewer or smaller obstacles or a smaller margin"
        )


def _fix_target(entry: dict[str, Any], target: list[float]) -> None:
    for key in ("trajectory", "spline", "periodic"):
        entry.pop(key, None)
    entry["target"] = target


def _size_keys(shape: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Keys of a shape that are drawn from ranges, and those of a registered one that are taken as they are."""
    registered = shapes.get(shape)
    if registered is None:
        return ("radius", "length", "size"), ()
    drawn = tuple(key for key, kind in registered.keys.items() if default_of(kind)[0] is float)
    return drawn, tuple(key for key in registered.keys if key not in drawn)


def _group_ranges(group: dict[str, Any]) -> tuple[list[tuple[str, int | None]], list[list[float]]]:
    """Fields of a group in their order of drawing, (key, index or None for a number), and the range of each."""
    fields: list[tuple[str, int | None]] = []
    ranges: list[list[float]] = []
    for key in ("position", *_size_keys(group["shape"])[0], "orientation", "velocity"):
        value = group.get(key)
        if value is None:
            continue
        if isinstance(value[0], list):
            fields += [(key, axis) for axis in range(len(value))]
            ranges += value
        else:
            fields.append((key, None))
            ranges.append(value)
    return fields, ranges


# A drawn angle as an obstacle's orientation, by dimension: itself, or a turn about z.
_ORIENTATIONS: dict[int, Callable[[float], Any]] = {
    2: lambda angle: angle,
    3: lambda angle: [cos(0.5 * angle), 0.0, 0.0, sin(0.5 * angle)],
}


def _obstacle_entry(name: str, shape: str, fields: list[tuple[str, int | None]], values: list[float]) -> dict[str, Any]:
    """A drawn obstacle as a concrete problem lists it; with a velocity its position becomes expressions in t."""
    drawn: dict[str, Any] = {}
    for (key, axis), value in zip(fields, values, strict=True):
        if axis is None:
            drawn[key] = value
        else:
            drawn.setdefault(key, []).append(value)
    velocity = drawn.pop("velocity", None)
    dimension = len(drawn["position"])
    entry: dict[str, Any] = {"name": name, "shape": shape}
    if velocity is not None and any(velocity):
        start = drawn.pop("position")
        entry["trajectory"] = [f"{x!r} + {v!r}*t" for x, v in zip(start, velocity, strict=True)]
    else:
        entry["position"] = drawn.pop("position")
    angle = drawn.pop("orientation", 0.0)
    return {**entry, **drawn, "orientation": _ORIENTATIONS[dimension](angle)}
