"""A planner in a process of its own, behind the interface of every planner."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter_ns
from typing import Any

from pytest_lpb.isolation.session import Session
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.planner.base import FloatArray, Observation, Planner, PlannerProblem
from pytest_lpb.problem.preview import Preview
from pytest_lpb.problem.robot import Robot

NS_PER_MS = 1e6


@dataclass(frozen=True)
class FarParameters:
    """Parameters of a planner elsewhere."""

    given: Mapping[str, Any]  # what is sent to it
    resolved: Mapping[str, Any]  # with its defaults, for the record
    preview: Preview | None = None  # what it wants to see of the future with them


class IsolatedPlanner(Planner):
    """Passes everything on to a far process, which `setup` starts when there is none.

    Args:
        parameters: FarParameters.
        isolation: where, and within which limits.
        planner: `module:Class` or a registered name; empty for a program.
        folder: where the planner's module lies, or None.
    """

    parameters: FarParameters

    def __init__(self, parameters: FarParameters, isolation: Isolation, planner: str, folder: Path | None) -> None:
        super().__init__(parameters)
        self._session = Session(isolation, planner, folder)
        self.round_trip_ms: float | None = None  # of the last call, beyond the time measured in the far process

    @property
    def measured_ns(self) -> tuple[int, int] | None:
        """Wall and CPU time of the last call, measured in the far process [ns]; None when it did not say."""
        return self._session.measured_ns

    def setup(self, problem: PlannerProblem) -> None:
        """Set the far planner up. Raises Infeasible, DeadlineError or PlannerError."""
        self._session.set_up(problem.to_dict(), self.parameters.given, lambda: robot_description(problem.robot))

    def compute_action(self, observation: Observation) -> FloatArray:
        """The far planner's action. Raises Infeasible, DeadlineError or PlannerError."""
        self.round_trip_ms = None
        started = perf_counter_ns()
        answer = self._session.act(observation)
        elapsed = perf_counter_ns() - started
        if self.measured_ns is not None:
            self.round_trip_ms = (elapsed - self.measured_ns[0]) / NS_PER_MS
        if answer.diagnostics:
            self.diagnostics = dict(answer.diagnostics)
        return answer.action

    def close(self) -> None:
        """Close the far planner and end its process."""
        self._session.close()


def robot_description(robot: Robot) -> dict[str, Any]:
    """Attributes of a robot in builtin types, for those who cannot build it; None stands for no limit."""
    names = ("name", "control", "base", "dimension", "dof", "n_actions", "joint_names", "joint_types", "link_names")
    limits = {
        key: [[bound if abs(bound) < float("inf") else None for bound in row] for row in rows]
        for key, rows in robot.limits.to_dict().items()
    }
    return {
        **{name: getattr(robot, name) for name in names},
        "body_radius": robot.body_radius,
        "urdf_path": robot.urdf_path,
        "base_pose": robot.base_pose.tolist(),
        "limits": limits,
        "collision_bodies": [(body.name, body.link, body.capsules) for body in robot.collision_bodies],
        "self_collision_pairs": robot.self_collision_pairs,
    }
