"""The plots of single trials that come with pytest-lpb."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import LogFormatter

from pytest_lpb.report.depiction import depiction_for
from pytest_lpb.report.plots import plot
from pytest_lpb.report.projection import PROJECTIONS, Disc
from pytest_lpb.report.scene_marks import goal_points, primary_link
from pytest_lpb.shown import literal

if TYPE_CHECKING:
    from pytest_lpb.trajectory import Trajectory


@plot("path")
def path(trajectory: Trajectory, axes: Any) -> None:
    """The goal link's path among the obstacles, seen along z; moving obstacles as they stand at the end."""
    points = trajectory.link(primary_link(trajectory))
    axes.plot(points[:, 0], points[:, 1], color="C0", label=trajectory.outcome)
    axes.plot(*points[0, :2], "o", color="C0", fillstyle="none", label="start")
    _draw_surroundings(trajectory, axes)
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(loc="best", fontsize="small")


def _draw_surroundings(trajectory: Trajectory, axes: Any) -> None:
    problem = trajectory.problem
    depiction, above = depiction_for(problem.dimension), PROJECTIONS[problem.dimension][0]
    for obstacle in problem.obstacles:
        positions, turns = obstacle.poses(trajectory.t)
        if obstacle.moving:
            axes.plot(positions[:, 0], positions[:, 1], ":", color="0.5", linewidth=1)
        outline = depiction.outline(obstacle, positions[-1], turns[-1], above)
        if isinstance(outline, Disc):
            axes.add_patch(Circle(tuple(outline.centre), outline.radius, color="0.7"))
        elif outline is not None:
            axes.add_patch(Polygon(outline, color="0.7"))
    targets = above.of(goal_points(trajectory))
    if len(targets) and np.isfinite(targets[-1]).all():
        axes.plot(*targets[-1], "+", color="C2", markersize=10, label="goal")
        tolerance = problem.primary.tolerance
        if tolerance is not None:
            axes.add_patch(Circle(tuple(targets[-1]), tolerance, edgecolor="C2", facecolor="none"))


@plot("clearance")
def clearance(trajectory: Trajectory, axes: Any) -> None:
    """Signed distance to the nearest obstacle over time."""
    axes.plot(trajectory.t, trajectory.clearance, color="C0")
    axes.axhline(0.0, color="C3", linewidth=1, label="contact")
    margin = trajectory.problem.safety_margin
    axes.axhline(margin, color="0.5", linewidth=1, linestyle="--", label="safety margin")
    axes.set(xlabel="time [s]", ylabel="clearance [m]")
    axes.legend(loc="best", fontsize="small")


@plot("goal_error")
def goal_error(trajectory: Trajectory, axes: Any) -> None:
    """Error of every sub-goal over time, with its tolerance."""
    parts = [
        (goal.name, part, error)
        for goal in trajectory.problem.goal
        for part, error in zip(goal.components, trajectory.goal_errors(goal), strict=True)
    ]
    for index, (name, part, error) in enumerate(parts):
        colour = f"C{index % 10}"
        axes.plot(trajectory.t, error, color=colour, label=f"{name} [{part.unit}]")
        if part.tolerance is not None:
            axes.axhline(part.tolerance, color=colour, linewidth=1, linestyle="--")
    axes.set(xlabel="time [s]", ylabel="error")
    axes.legend(loc="best", fontsize="small")


@plot("action")
def action(trajectory: Trajectory, axes: Any) -> None:
    """The planner's actions over time (lines), and what the limits left of them (dots)."""
    for index, name in enumerate(trajectory.problem.robot.action_names):
        colour = f"C{index % 10}"
        series = trajectory.action[:, index]
        axes.step(trajectory.t, series, where="post", color=colour, label=literal(name))
        axes.plot(trajectory.t, trajectory.applied[:, index], ".", color=colour, markersize=2)
    axes.set(xlabel="time [s]", ylabel=f"action ({trajectory.problem.control})")
    axes.legend(loc="best", fontsize="small")


class _PlainNumbers(LogFormatter):
    """Labels where matplotlib puts them, as `0.005` and not as a power."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return f"{x:g}" if super().__call__(x, pos) else ""


@plot("solver_time")
def solver_time(trajectory: Trajectory, axes: Any) -> None:
    """Wall and CPU time of each call of the planner."""
    for series, marker, label in (
        (trajectory.solver_wall_ms, ".", "wall time"),
        (trajectory.solver_cpu_ms, "+", "CPU time"),
    ):
        axes.plot(trajectory.t, series, marker, markersize=4, label=label)
    positive = np.concatenate([trajectory.solver_wall_ms, trajectory.solver_cpu_ms])
    if np.any(positive > 0):
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(_PlainNumbers())
        axes.yaxis.set_minor_formatter(_PlainNumbers(minor_thresholds=(2, 0.5)))
    axes.set(xlabel="time [s]", ylabel="solver time [ms]")
    axes.legend(loc="best", fontsize="small")
