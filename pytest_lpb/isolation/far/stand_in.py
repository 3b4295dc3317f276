"""What planner modules import as `pytest_lpb` where it can be neither imported nor sent: the same classes, in small."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

FloatArray = Any
Observation = Any
KINEMATICS = ("forward_kinematics", "jacobian", "action_map", "frames", "link_positions", "integrate", "joint_velocity")


class LpbError(Exception):
    """Base of errors that are raised on purpose."""


class Infeasible(LpbError):  # noqa: N818 - the public name
    """Raised by a planner that has found that its problem has no feasible action."""


@dataclass(frozen=True)
class Preview:
    """What a planner wants to see of the future."""

    steps: int
    step_s: float  # [s]


class Planner:
    """Base class of planners."""

    preview = None
    supports: Any = None

    @dataclass(frozen=True)
    class Parameters:
        """No parameters."""

    def __init__(self, parameters: Any = None) -> None:
        self.parameters = type(self).Parameters() if parameters is None else parameters
        self.diagnostics: Any = {}

    @classmethod
    def preview_for(cls, parameters: Any) -> Any:  # noqa: ARG003 - for planners whose horizon is one of them
        """What a planner with these parameters wants to see of the future."""
        return cls.preview

    def setup(self, problem: Any) -> None:
        """Prepare for a trial."""

    def compute_action(self, observation: Any) -> Any:
        """The action for this observation, (n_actions,)."""
        raise NotImplementedError(type(self).__name__ + " must define compute_action(self, observation)")

    def close(self) -> None:
        """Free what the planner holds."""


class DescribedRobot:
    """A robot by its description: all attributes, no kinematics."""

    def __init__(self, entry: Mapping[str, Any], description: Mapping[str, Any], reason: str) -> None:
        self.entry = dict(entry)
        self._reason = reason
        limits = description["limits"]
        self.__dict__.update(description)
        for name in ("joint_names", "joint_types", "link_names"):
            setattr(self, name, tuple(description[name]))
        self.base_pose = np.array(description["base_pose"])
        self.limits = SimpleNamespace(**{name: _limits(limits[name]) for name in limits})
        self.collision_bodies = tuple(
            SimpleNamespace(name=name, link=link, capsules=tuple(map(tuple, capsules)))
            for name, link, capsules in description["collision_bodies"]
        )
        self.self_collision_pairs = tuple(map(tuple, description["self_collision_pairs"]))

    def __getattr__(self, name: str) -> Any:
        if name in KINEMATICS:
            raise NotImplementedError("problem.robot." + name + " cannot be computed here: " + self._reason)
        raise AttributeError("a robot without its kinematics has no attribute " + repr(name))

    def to_dict(self) -> Any:
        """The robot section of the problem."""
        return dict(self.entry)


def _limits(rows: Any) -> Any:
    """Limits (n, 2), where None stands for unlimited."""
    unlimited = (-np.inf, np.inf)
    limits = np.array(
        [[unlimited[i] if row[i] is None else row[i] for i in (0, 1)] for row in rows], dtype=float
    ).reshape(-1, 2)
    limits.flags.writeable = False
    return limits


class PlannerProblem:
    """What a planner is told of its problem, with a robot that is described."""

    def __init__(self, entry: Mapping[str, Any], description: Mapping[str, Any], reason: str) -> None:
        self._entry = dict(entry)
        for name in ("name", "seed", "dt", "period", "duration"):
            setattr(self, name, entry[name])
        self.robot = DescribedRobot(entry["robot"], description, reason)
        self.control, self.dimension = description["control"], description["dimension"]
        self.goal = tuple(SimpleNamespace(**goal) for goal in entry["goal"])
        self.obstacles = tuple(
            SimpleNamespace(**dict(item, size=tuple(item["size"]) if item["size"] else None))
            for item in entry["obstacles"]
        )

    @property
    def structure(self) -> Any:
        """Hashable: what a composed solver depends on."""
        counts: Any = {}
        for item in self.obstacles:
            counts[item.shape] = counts.get(item.shape, 0) + 1
        goals = tuple((goal.name, goal.type, goal.link, goal.size) for goal in self.goal)
        capacities = tuple((shape, 1 << (count - 1).bit_length()) for shape, count in sorted(counts.items()))
        return (repr(sorted(self.robot.entry.items())), self.control, goals, capacities)

    def to_dict(self) -> Any:
        """Builtin types only."""
        return dict(self._entry)


def install() -> None:
    """Be `pytest_lpb`, and the modules of it that planners import names from."""
    public = {key: value for key, value in globals().items() if not key.startswith("__")}
    for name in ("", ".errors", ".planner", ".planner.base", ".problem", ".problem.preview", ".problem.problem"):
        module = ModuleType("pytest_lpb" + name)
        module.__dict__.update(public)
        module.__path__ = []  # a package: more may be imported below it
        sys.modules["pytest_lpb" + name] = module
