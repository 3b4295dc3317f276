"""Watches a trial row by row: goal held, first violation, standstill; and names the outcome."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan

from pytest_lpb.environment.continuous import StepBounds
from pytest_lpb.environment.engine import Engine, continuous
from pytest_lpb.environment.limits import PositionLimits
from pytest_lpb.problem.collision import Clearance
from pytest_lpb.problem.continuous_collision import first_touch
from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.problem import Problem

STALL_SPEED = 1e-3  # largest |u| of a robot that stands still [rad/s or m/s]
STALL_TIME_S = 5.0  # standstill at the end of a trial that makes a timeout `stalled`


NOTHING: Clearance = (nan, "", "")


@dataclass(frozen=True)
class Violation:
    """The first violation of a trial.

    Attributes:
        outcome: collision, self_collision or joint_limit.
        row: the first at or after the violation.
        clearance: of the two bodies, at that row; positive where they touched before it and are free again.
        joint: index of the joint beyond its limits.
        time: of first contact [s].
    """

    outcome: str
    row: int
    clearance: Clearance = NOTHING
    joint: int | None = None
    time: float | None = None


class Monitor:
    """State of a trial's goal and violations.

    Attributes: goal_errors (one per component of a sub-goal, [m or rad]), clearance and self_clearance of the current
    row, violation (the first, or None), goal_row (first row of the first held interval, or None).
    """

    goal_errors: list[float]
    clearance: Clearance
    self_clearance: Clearance

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._position_limits = PositionLimits(problem.robot)
        self._hold_rows = problem.hold_rows
        self._goals = list(enumerate(problem.goal))
        self._targets: list[list[float]] = [[] for _ in problem.goal]
        self._one_error_each = all(type(goal).errors is SubGoal.errors for goal in problem.goal)  # faster
        components = [(goal, component) for goal in problem.goal for component in goal.components]
        self._required = [(i, part.tolerance) for i, (_, part) in enumerate(components) if part.tolerance is not None]
        self._primary = [(i, part) for i, (goal, part) in enumerate(components) if goal is problem.primary]
        self.violation: Violation | None = None
        self.goal_row: int | None = None
        self._entered: int | None = None
        self._moved_at = -1
        self.clearance = self.self_clearance = NOTHING
        self._motion: StepBounds | None = None  # what knows the way to the next row

    def set_target(self, index: int, target: list[float]) -> None:
        """Move the target of a sub-goal."""
        self._targets[index] = target

    def begin(self, engine: Engine) -> None:
        """Measure the engine's state, which is that of row 0."""
        self.check(0, engine)
        self._motion = continuous(engine)

    def check(self, row: int, engine: Engine) -> None:
        """Measure the engine's state, which is that of this row, one after the last."""
        q, frames = engine.q, engine.frames
        targets = self._targets
        if self._one_error_each:
            self.goal_errors = [goal.distance(goal.value(q, frames), targets[i]) for i, goal in self._goals]
        else:
            self.goal_errors = [
                error for i, goal in self._goals for error in goal.errors(goal.value(q, frames), targets[i])
            ]
        self._check_goal(row)
        before, own_before = self.clearance[0], self.self_clearance[0]
        self.clearance, self.self_clearance = engine.clearance()
        if self.violation is None:
            motion = self._motion
            if motion is not None:
                gap, own_gap = before + self.clearance[0], own_before + self.self_clearance[0]
                if motion.may_have_touched(row, gap, own_gap):
                    self.violation = contact_since(row, motion, self._problem.dt)
            if self.violation is None:
                self._check_row(row, q, -engine.contact_slack_m)
        for speed in engine.u:
            if not -STALL_SPEED < speed < STALL_SPEED:
                self._moved_at = row
                break

    @property
    def primary_errors(self) -> dict[str, float]:
        """Errors of the primary goal in the current row, by unit."""
        return {component.unit: self.goal_errors[index] for index, component in self._primary}

    @property
    def goal_distance(self) -> float:
        """Error of the primary goal in the current row [m or rad]; of one over both units the larger in tolerances.

        The goal is within its tolerance where this is at most `goal_tolerance`.
        """
        if len(self._primary) == 1:
            return self.goal_errors[self._primary[0][0]]
        return max(self.goal_errors[index] / (component.tolerance or 1.0) for index, component in self._primary)

    @property
    def goal_tolerance(self) -> float:
        """Tolerance of `goal_distance`: the primary goal's [m or rad], of one over both units 1; inf without one."""
        tolerance = self._problem.primary.tolerance
        if tolerance is None:
            return inf
        return tolerance if len(self._primary) == 1 else 1.0

    def _check_goal(self, row: int) -> None:
        for index, tolerance in self._required:
            if not self.goal_errors[index] <= tolerance:
                self._entered = None
                return
        if self._entered is None:
            self._entered = row
        if self.goal_row is None and self._hold_rows is not None and row - self._entered >= self._hold_rows:
            self.goal_row = self._entered

    def _check_row(self, row: int, q: list[float], deepest: float) -> None:
        if self.clearance[0] < deepest:
            self.violation = Violation("collision", row, self.clearance, time=row * self._problem.dt)
        elif self.self_clearance[0] < deepest:
            self.violation = Violation("self_collision", row, self.self_clearance, time=row * self._problem.dt)
        else:
            joint = self._position_limits.violated(q)
            if joint is not None:
                self.violation = Violation("joint_limit", row, joint=joint)

    @property
    def contact_time(self) -> float | None:
        """When bodies first touched [s]; None where the first violation is no contact."""
        return None if self.violation is None else self.violation.time

    def outcome(self, last_row: int) -> str:
        """What a trial that ends with this row has come to: the first violation, success, stalled or timeout."""
        if self.violation is not None:
            return self.violation.outcome
        if self._hold_rows is None:
            self.goal_row = self._entered
        if self.goal_row is not None:
            return "success"
        still_for = (last_row - self._moved_at) * self._problem.dt
        return "stalled" if still_for > STALL_TIME_S else "timeout"


def contact_since(row: int, engine: StepBounds, dt: float) -> Violation | None:
    """The first contact on the way to a row, which the engine has reached; None where there is none."""
    bodies = engine.swept_bodies(row)
    touch = first_touch(bodies, -engine.contact_slack_m)
    if touch is None:
        engine.restore()
        return None
    distance = bodies.distances(1.0, [touch.pair])[0]
    engine.restore()
    outcome = "self_collision" if bodies.is_own(touch.pair) else "collision"
    return Violation(outcome, row, (distance, *bodies.names(touch.pair)), time=(row - 1 + touch.share) * dt)
