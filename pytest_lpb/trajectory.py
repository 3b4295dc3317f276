"""Raw data of one trial, as KPIs, plots and reports see it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import RecordingError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.problem.hold import first_held_row

if TYPE_CHECKING:
    from pytest_lpb.problem.goal import SubGoal
    from pytest_lpb.problem.problem import Problem

FloatArray = NDArray[np.float64]

AXES = ("x", "y", "z")
MAX_WALL_PER_CPU = 1.2  # ratio of wall to CPU time of planner calls that counts as undisturbed


class Trajectory:
    """One recorded trial: N + 1 rows at t = k dt; the last row has no action (NaN).

    Args:
        columns: raw data by column name (see the contract's trial file), each (N + 1,); float64, or text for
            `clearance_body` and `clearance_obstacle`.
        metadata: outcome, message, wall_s, setup_ms, workers, cores, parameters, hashes.
        problem: the concrete problem.
    """

    def __init__(self, columns: Mapping[str, NDArray[Any]], metadata: Mapping[str, Any], problem: Problem) -> None:
        self.columns = columns
        for column in columns.values():
            column.flags.writeable = False  # raw data never change, whatever a KPI does
        self.metadata = metadata
        self.problem = problem
        # What KPIs have computed from the raw data and share with each other; raw data never change.
        self.derived: dict[object, Any] = {}

    def __len__(self) -> int:
        return len(self.columns["t"])

    @property
    def t(self) -> FloatArray:
        """Time of each row, (N + 1,) [s]."""
        return self.column("t")

    @cached_property
    def q(self) -> FloatArray:
        """Joint positions, (N + 1, dof) [rad or m]."""
        return self._numbered("q")

    @cached_property
    def qd(self) -> FloatArray:
        """Joint velocities, (N + 1, dof) [rad/s or m/s]."""
        return self._numbered("qd")

    @cached_property
    def u(self) -> FloatArray:
        """Actuated velocities, (N + 1, n_actions)."""
        return self._numbered("u")

    @cached_property
    def action(self) -> FloatArray:
        """The planner's actions, (N + 1, n_actions); the last row is NaN."""
        return self._numbered("action")

    @cached_property
    def applied(self) -> FloatArray:
        """The actions after the robot's limits, (N + 1, n_actions); the last row is NaN."""
        return self._numbered("applied")

    def link(self, name: str) -> FloatArray:
        """Position of a link's frame in the world, (N + 1, 3) [m]; z = 0 in planar problems."""
        return self._position("link", name)

    def obstacle(self, name: str) -> FloatArray:
        """Position of an obstacle in the world, (N + 1, 3) [m]; z = 0 in planar problems."""
        return self._position("obstacle", name)

    def goal(self, name: str) -> FloatArray:
        """Target of a sub-goal, (N + 1, size) in the sub-goal's own unit."""
        return self._numbered(f"goal_{name}_")

    def goal_error(self, name: str) -> FloatArray:
        """Distance of the robot to a sub-goal, (N + 1,) in the sub-goal's own unit [m or rad].

        Of joints in m and in rad it is the larger number of both: see `goal_errors`.
        """
        return self.column(f"goal_{name}_error")

    def goal_errors(self, goal: SubGoal) -> tuple[FloatArray, ...]:
        """Distance of the robot to a sub-goal, (N + 1,) [m or rad] for each of its `components`, in one unit each."""
        if any(component.column not in self.columns for component in goal.components) and len(goal.components) > 1:
            return self._joint_errors(goal)
        return tuple(self.column(component.column) for component in goal.components)

    def _joint_errors(self, goal: SubGoal) -> tuple[FloatArray, ...]:
        """Errors by unit of a trial recorded before they had columns: from joint positions and targets."""
        rows = zip(self.q.tolist(), self.goal(goal.name).tolist(), strict=True)
        errors = [goal.errors(goal.value(q, None), target) for q, target in rows]
        return tuple(np.array(errors).reshape(-1, len(goal.components)).T)

    @property
    def clearance(self) -> FloatArray:
        """Signed distance of the robot to the nearest obstacle at each row, (N + 1,) [m]; NaN without obstacles."""
        return self.column("clearance_m")

    @property
    def self_clearance(self) -> FloatArray:
        """Signed distance between the robot's own bodies at each row, (N + 1,) [m]; NaN without pairs to check."""
        return self.column("self_clearance_m")

    @property
    def step_clearance(self) -> FloatArray:
        """Least clearance on the way to each row, from the row before it on, (N + 1,) [m]; NaN without obstacles.

        Found to 1e-4 m where the least of the whole trial depends on it, or where it goes below the scenario's safety
        margin between two rows that keep it; elsewhere that of the nearer row. Of trials recorded without it, that of
        each row.
        """
        return self.columns.get("clearance_step_min_m", self.clearance)

    @property
    def self_step_clearance(self) -> FloatArray:
        """The same between the robot's own bodies, (N + 1,) [m]; NaN without pairs to check."""
        return self.columns.get("self_clearance_step_min_m", self.self_clearance)

    @property
    def contact_time(self) -> float | None:
        """Time of the contact that ended or would have ended the trial [s], to 1e-3 dt; None without one."""
        return self.metadata.get("contact_time_s")

    @property
    def solver_wall_ms(self) -> FloatArray:
        """Wall time of each call of the planner, (N + 1,) [ms]; NaN in rows without a call."""
        return self.column("solver_wall_ms")

    @property
    def solver_cpu_ms(self) -> FloatArray:
        """Thread CPU time of each call of the planner, (N + 1,) [ms]; NaN in rows without a call."""
        return self.column("solver_cpu_ms")

    def planner(self, key: str) -> FloatArray:
        """A diagnostic that the planner recorded at each call, (N + 1,)."""
        return self.column(f"planner_{key}")

    def within(self, goal: SubGoal) -> NDArray[np.bool_]:
        """Whether a sub-goal is within its tolerance, or has none, (N + 1,)."""
        within = np.ones(len(self), dtype=np.bool_)
        for component, error in zip(goal.components, self.goal_errors(goal), strict=True):
            if component.tolerance is not None:
                within &= error <= component.tolerance
        return within

    @cached_property
    def goal_row(self) -> int | None:
        """First row of the first interval within every tolerance that lasts the hold time; None without one.

        Sub-goals without a tolerance are preferences and are not asked, as in the trial itself.
        """
        within = np.ones(len(self), dtype=np.bool_)
        for goal in self.problem.goal:
            within &= self.within(goal)
        hold_rows = self.problem.hold_rows
        if hold_rows is None and len(self) <= self.problem.steps:
            return None  # "to the end" means the scenario's, not that of a trial cut short
        return first_held_row(within, hold_rows)

    @property
    def timing_contended(self) -> bool:
        """Whether other processes disturbed the timing: more workers than cores - 1, or calls that had to wait."""
        return bool(self.metadata["workers"] > self.metadata["cores"] - 1) or self.calls_waited

    @cached_property
    def calls_waited(self) -> bool:
        """Whether the planner's calls had to wait for a core: the median ratio of wall to CPU time is above 1.2."""
        called = ~np.isnan(self.solver_wall_ms) & (self.solver_cpu_ms > 0.0)
        ratios = self.solver_wall_ms[called] / self.solver_cpu_ms[called]
        return bool(len(ratios)) and float(np.median(ratios)) > MAX_WALL_PER_CPU

    @property
    def outcome(self) -> str:
        """How the trial ended: one of the outcomes of `pytest_lpb.trial.outcome`."""
        return str(self.metadata["outcome"])

    def column(self, name: str) -> NDArray[Any]:
        """A column of the trial file, (N + 1,). Raises RecordingError for a name that is not in the file."""
        try:
            return self.columns[name]
        except KeyError:
            hint = suggestion(name, self.columns)
            raise RecordingError(
                f"no column {name!r} in this trial{hint}; recorded are {listed(self.columns)}"
            ) from None

    def _numbered(self, prefix: str) -> FloatArray:
        names: list[str] = []
        while f"{prefix}{len(names)}" in self.columns:
            names.append(f"{prefix}{len(names)}")
        if not names:
            self.column(f"{prefix}0")
        matrix = np.column_stack([self.columns[name] for name in names])
        matrix.flags.writeable = False
        return matrix

    def _position(self, kind: str, name: str) -> FloatArray:
        self.column(f"{kind}_{name}_x")
        position = np.zeros((len(self), 3))
        for axis, letter in enumerate(AXES[: self.problem.dimension]):
            position[:, axis] = self.columns[f"{kind}_{name}_{letter}"]
        return position
