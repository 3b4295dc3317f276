"""The seam between environment and simulator. A new engine is one file and one line in `ENGINES`."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Protocol

from pytest_lpb.environment.continuous import StepBounds
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.collision import Clearance
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.registries import engines

# Engine name -> "module:Class".
ENGINES: dict[str, str] = {
    "planar": "pytest_lpb.environment.planar:PlanarEngine",
    "pybullet": "pytest_lpb.environment.bullet:BulletEngine",
}


class Engine(Protocol):
    """Simulates one robot among obstacles; the environment does goals, limits and bookkeeping.

    One that knows its motion between two rows has an attribute `continuous: StepBounds` as well: contact is then found
    there too. Others are judged at their rows.
    """

    contact_slack_m: float  # depth from which bodies collide
    q: list[float]  # joint positions [rad or m]
    u: list[float]  # actuated velocities
    qd: list[float]  # joint velocities
    frames: Any  # link frames as the problem's sub-goals read them

    def __init__(self, problem: Problem) -> None: ...

    def set_state(self, q: list[float], u: list[float]) -> None:
        """Put the robot into a state."""

    def advance(self, action: list[float]) -> None:
        """Move by one step under a constant action that is within the limits."""

    def place_obstacles(self, positions: list[list[float]], orientations: list[Any]) -> None:
        """Move all obstacles, in the problem's order; positions [m], angles [rad] or quaternions wxyz."""

    def clearance(self) -> tuple[Clearance, Clearance]:
        """Signed distance to the nearest obstacle, and between the robot's own bodies."""

    def close(self) -> None:
        """Free what the engine holds."""


def engine_for(problem: Problem) -> Engine:
    """The engine that a problem names, with the problem loaded. Raises ScenarioError for one that is unknown here."""
    target = ENGINES.get(problem.engine)
    if target is not None:
        module, _, name = target.partition(":")
        engine: Engine = getattr(import_module(module), name)(problem)
        return engine
    registered = engines.get(problem.engine)
    if registered is None:
        raise ScenarioError(f"unknown engine {problem.engine!r}: what registers it is not loaded")
    own: Engine = registered.create(problem)
    return own


def continuous(engine: Engine) -> StepBounds | None:
    """What knows an engine's motion between two rows; None for engines of users' own that do not say."""
    found: StepBounds | None = getattr(engine, "continuous", None)
    return found
