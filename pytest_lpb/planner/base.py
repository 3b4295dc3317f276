"""The class that every planner derives from, and what a planner is told of its problem."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.planner.read_only import ReadOnlyDict
from pytest_lpb.planner.registry import register
from pytest_lpb.problem.hashing import copied
from pytest_lpb.problem.preview import Preview
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import Limits, Robot, robot_from

FloatArray = NDArray[np.float64]
Observation = Mapping[str, FloatArray]


@dataclass(frozen=True)
class GoalInfo:
    """A sub-goal as planners see it: what it asks for, not where its target will be."""

    name: str
    type: str
    link: str | None
    size: int  # entries of its target
    tolerance: float | None  # [m or rad]
    weight: float
    primary: bool
    moving: bool
    entry: Mapping[str, Any]  # axes, point, joints, axis, .. as in the scenario file


@dataclass(frozen=True)
class ObstacleInfo:
    """An obstacle as planners see it: never where it will be."""

    name: str
    shape: str
    radius: float | None  # [m]
    size: tuple[float, ...] | None  # [m] full lengths
    moving: bool
    length: float | None = None  # [m] along z; of a capsule between its cap centres
    file: str | None = None  # of a mesh
    scale: float = 1.0  # of a mesh
    concave: bool = False  # of a mesh: its inside is free
    parameters: Mapping[str, Any] = field(default_factory=dict)  # keys of a shape that a user has registered


OBSTACLE_KEYS = tuple(field.name for field in fields(ObstacleInfo))


def arrays_of(robot: Robot) -> dict[str, FloatArray]:
    """Arrays of a robot that planners are told of, by the path that leads to them."""
    limits = {f"problem.robot.limits.{field.name}": getattr(robot.limits, field.name) for field in fields(Limits)}
    return {"problem.robot.base_pose": robot.base_pose, **limits}


@dataclass(frozen=True)
class Structure:
    """What a composed solver depends on; hashable, to cache solvers by."""

    robot: str  # canonical JSON of the robot
    control: str
    goals: tuple[tuple[str, str, str | None, int], ...]  # name, type, link, size
    shapes: tuple[tuple[str, int], ...]  # shape and capacity, the next power of two


class PlannerProblem:
    """What a planner is told before a trial. Targets and obstacle positions come with each observation.

    Attributes: name, seed, dt [s], period [s], duration [s], control, dimension (2 or 3), goal, obstacles, robot,
    structure.
    """

    def __init__(self, entry: Mapping[str, Any]) -> None:
        self._entry = dict(entry)
        self.name: str = entry["name"]
        self.seed: int = entry["seed"]
        self.dt: float = entry["dt"]
        self.period: float = entry["period"]
        self.duration: float = entry["duration"]
        self.robot: Robot = robot_from(entry["robot"])
        for array in arrays_of(self.robot).values():
            array.flags.writeable = False
        self.control: str = self.robot.control
        self.dimension: int = self.robot.dimension
        self.goal = tuple(
            GoalInfo(**{**goal, "entry": ReadOnlyDict(f"problem.goal[{index}].entry", goal["entry"])})
            for index, goal in enumerate(entry["goal"])
        )
        self.obstacles = tuple(
            ObstacleInfo(**{**item, "size": tuple(item["size"]) if item["size"] else None})
            for item in entry["obstacles"]
        )

    @classmethod
    def of(cls, problem: Problem, period: float) -> PlannerProblem:
        """What planners may know of a problem, with their period [s]."""
        hidden = {"target", "trajectory", "spline", "periodic"}
        goal = [
            {
                "name": goal.name,
                "type": goal.type,
                "link": goal.link,
                "size": goal.motion.size,
                "tolerance": goal.tolerance,
                "weight": goal.weight,
                "primary": goal.primary,
                "moving": goal.moving,
                "entry": {key: value for key, value in entry.items() if key not in hidden},
            }
            for goal, entry in zip(problem.goal, problem.entry["goal"], strict=True)
        ]
        obstacles = [{key: getattr(o, key) for key in OBSTACLE_KEYS} for o in problem.obstacles]
        settings = {
            "name": problem.name,
            "seed": problem.seed,
            "dt": problem.dt,
            "duration": problem.duration,
        }
        robot = problem.robot.to_dict()
        # A copy: whatever a planner does to it, the problem stays as it is.
        entry = {**settings, "period": period, "robot": robot, "goal": goal, "obstacles": obstacles}
        return cls(copied(entry))

    @property
    def structure(self) -> Structure:
        """What a composed solver depends on: robot, control, goal types, obstacle shapes and capacity."""
        counts: dict[str, int] = {}
        for obstacle in self.obstacles:
            counts[obstacle.shape] = counts.get(obstacle.shape, 0) + 1
        capacities = tuple((shape, 1 << (count - 1).bit_length()) for shape, count in sorted(counts.items()))
        goals = tuple((goal.name, goal.type, goal.link, goal.size) for goal in self.goal)
        return Structure(json.dumps(self.robot.to_dict(), sort_keys=True), self.control, goals, capacities)

    def to_dict(self) -> dict[str, Any]:
        """Builtin types only; `PlannerProblem(entry)` rebuilds the same, in any process."""
        return dict(self._entry)


class Planner:
    """Base class of planners. A class attribute `name` registers the subclass.

    One instance runs all trials of a scenario, one after the other: `setup` must forget the last one.
    """

    name: ClassVar[str]
    preview: ClassVar[Preview | None] = None
    # A mapping of `robots`, `base` and `control` to what is supported, or a method `supports(self, problem)` that
    # returns True, False, or the reason why not. Trials of other problems are skipped.
    supports: ClassVar[Any] = MappingProxyType({})

    @dataclass(frozen=True)
    class Parameters:
        """No parameters; subclasses give their own frozen dataclass, every number with its unit in a comment."""

    parameters: Any  # an instance of the class's Parameters, set before every setup
    diagnostics: dict[str, float]  # recorded per call as planner_KEY

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        if "name" in cls.__dict__:
            register(cls)

    def __init__(self, parameters: Any = None) -> None:
        self.parameters = type(self).Parameters() if parameters is None else parameters
        self.diagnostics = {}

    @classmethod
    def preview_for(cls, parameters: Any) -> Preview | None:  # noqa: ARG003 - for planners whose horizon is one of them
        """What a planner with these parameters wants to see of the future; by default the class's `preview`."""
        return cls.preview

    def setup(self, problem: PlannerProblem) -> None:
        """Prepare for a trial, before the clock runs; the last trial must leave no trace."""

    def compute_action(self, observation: Observation) -> FloatArray:
        """The action for this observation, (n_actions,). May raise `pytest_lpb.Infeasible`."""
        raise NotImplementedError(f"{type(self).__name__} must define compute_action(self, observation)")

    def close(self) -> None:
        """Free what the planner holds; called once, after its last trial."""
