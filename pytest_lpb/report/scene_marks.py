"""The parts of a scene: obstacles, goal, robot and path, as marks on a canvas."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.problem.planar.shapes import SHAPES
from pytest_lpb.report.canvas import Canvas, path_through
from pytest_lpb.report.numbers import show, show_exact
from pytest_lpb.report.scale import LARGEST
from pytest_lpb.report.view import Mark, PlannerStyle

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle
    from pytest_lpb.trajectory import Trajectory

FloatArray = NDArray[np.float64]

OBSTACLE_GHOSTS = 4
ROBOT_GHOSTS = 5
CONTACTS = ("collision", "self_collision")
CROSS = np.array([[-5.0, -5.0], [5.0, 5.0], [np.nan, np.nan], [-5.0, 5.0], [5.0, -5.0]])  # [px]


@dataclass(frozen=True)
class Drawn:
    """A planner's trial in a scene."""

    style: PlannerStyle
    trajectory: Trajectory
    outcome: str

    @property
    def path(self) -> FloatArray:
        """Path of the goal's link, (N + 1, 2) [m]."""
        return self.trajectory.link(primary_link(self.trajectory))[:, :2]

    @property
    def last_row(self) -> int:
        """The last row with a finite configuration."""
        return int(np.flatnonzero(np.isfinite(self.trajectory.q).all(axis=1))[-1])

    @property
    def violation_row(self) -> int:
        """Row of the first contact, or the last row."""
        touching = np.flatnonzero(self.trajectory.clearance < 0)
        return int(touching[0]) if len(touching) else self.last_row


def primary_link(trajectory: Trajectory) -> str:
    """The link that the primary goal speaks of; the last link for a joint goal."""
    link = trajectory.problem.primary.link
    return link if link is not None else trajectory.problem.robot.link_names[-1]


def configurations(trajectory: Trajectory) -> FloatArray:
    """Joint positions, those that diverged cut off where numbers can still be added, (N + 1, dof)."""
    return np.clip(trajectory.q, -LARGEST, LARGEST)


def placed_corners(obstacle: Obstacle, position: FloatArray, angle: float) -> FloatArray:
    """Corners of an obstacle in the world, (N, 2) [m]; of a disc, those of the square around it."""
    outline = SHAPES[obstacle.shape](obstacle.entry).outline()
    if isinstance(outline, float):
        return position + outline * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.asarray(position + np.array(outline) @ turn.T)


def obstacle_marks(canvas: Canvas, obstacle: Obstacle, until: float) -> Iterator[Mark]:
    """An obstacle at the start and, where it moves, its track and ghosts up to the time `until` [s]."""
    times = np.linspace(0.0, until, 121)
    positions, angles = obstacle.poses(times)
    if obstacle.moving:
        yield Mark(canvas.line(positions), "track", title=f"{obstacle.name}: track")
        for row in np.linspace(0, 120, OBSTACLE_GHOSTS + 1).astype(int)[1:]:
            yield Mark(
                _outline(canvas, obstacle, positions[row], float(angles[row])),
                "obstacle ghost",
                title=f"{obstacle.name} at {show(times[row])} s",
            )
    yield Mark(_outline(canvas, obstacle, positions[0], float(angles[0])), "obstacle", title=obstacle.name)


def goal_points(trajectory: Trajectory) -> FloatArray:
    """Targets of the primary goal over time, (N + 1, 2) [m]; empty when it is no place in the world."""
    goal = trajectory.problem.primary
    target = trajectory.goal(goal.name)
    reference = goal_entry(trajectory).get("relative_to")
    if goal.type != "position" or target.shape[1] != 2 or reference not in (None, "world"):
        return np.empty((0, 2))
    return target


def goal_entry(trajectory: Trajectory) -> Any:
    """The primary goal's entry in the concrete problem."""
    name = trajectory.problem.primary.name
    return next(entry for entry in trajectory.problem.to_dict()["goal"] if entry["name"] == name)


def goal_marks(canvas: Canvas, trajectory: Trajectory) -> Iterator[Mark]:
    """The goal with its tolerance; the track of a moving one."""
    goal = trajectory.problem.primary
    points = goal_points(trajectory)
    if len(points) == 0:
        return
    if goal.moving:
        yield Mark(canvas.line(points), "track goal-track", title=f"track of goal {goal.name}")
    tolerance = goal.tolerance
    if tolerance is not None:
        yield Mark(
            canvas.disc(points[0], tolerance),
            "tolerance",
            title=f"goal {goal.name}: within {show_exact(tolerance)} m",
        )
    x, y = canvas.pixels(points[:1])[0]
    yield Mark(f"M{x - 6:.1f} {y:.1f}h12M{x:.1f} {y - 6:.1f}v12", "goal", title=f"goal {goal.name}")


def robot_marks(canvas: Canvas, trajectory: Trajectory, row: int, css: str, drawn: Drawn | None) -> Iterator[Mark]:
    """The robot's bodies at a row."""
    robot = trajectory.problem.robot
    q = configurations(trajectory)[row]
    style = drawn.style if drawn else None
    by_radius: dict[float, list[FloatArray]] = {}
    for body in robot.collision_bodies:
        pose = robot.forward_kinematics(q, body.link)
        for capsule in body.capsules:
            ends = np.array(capsule[:4]).reshape(2, 2) @ pose[:2, :2].T + pose[:2, 2]
            by_radius.setdefault(capsule[4], []).append(canvas.pixels(ends))
    for radius, segments in by_radius.items():
        d = "".join(path_through(segment) for segment in segments)
        yield Mark(d, f"robot {css}", style, max(2 * radius * canvas.scale, 3.0))
    if robot.non_holonomic:
        pose = robot.forward_kinematics(q, robot.link_names[0])
        ahead = pose[:2, 2] + pose[:2, 0] * max(robot.body_radius, 8.0 / canvas.scale)
        yield Mark(canvas.line(np.array([pose[:2, 2], ahead])), f"heading {css}", style)


def ghost_rows(drawn: Drawn) -> list[int]:
    """Rows at equal steps along the motion of the joints, without the first and the last."""
    steps = np.diff(configurations(drawn.trajectory), axis=0)
    moved = np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])
    if not np.isfinite(moved[-1]) or moved[-1] == 0:
        return []
    return [int(row) for row in np.searchsorted(moved, np.linspace(0, moved[-1], ROBOT_GHOSTS + 2)[1:-1])]


def path_marks(canvas: Canvas, drawn: Drawn) -> Iterator[Mark]:
    """A planner's path, the robot where it ends, and a cross where it touched something."""
    name, points = drawn.style.name, drawn.path
    yield Mark(canvas.line(points), "path", drawn.style, title=f"{name}: {drawn.outcome}")
    finite = points[np.isfinite(points).all(axis=1)]
    if len(finite) == 0:
        return
    x, y = (round(float(place), 1) for place in canvas.pixels(finite[-1:])[0])
    solved = "solved" if drawn.outcome == "success" else "failed"
    yield Mark(drawn.style.marker, f"end {solved}", drawn.style, title=f"{name}: end, {drawn.outcome}", at=(x, y))
    if drawn.outcome in CONTACTS:
        place = canvas.pixels(contact_point(drawn)[None, :])[0]
        yield Mark(path_through(place + CROSS), "collision", drawn.style, title=f"{name}: {drawn.outcome}")


def contact_point(drawn: Drawn) -> FloatArray:
    """The point on the touching body's axis that is nearest to the obstacle's centre, (2,) [m]."""
    trajectory, row = drawn.trajectory, drawn.violation_row
    robot, link_path = trajectory.problem.robot, drawn.path
    body_name = str(trajectory.columns.get("clearance_body", np.full(len(trajectory), ""))[row])
    body = next((body for body in robot.collision_bodies if body.name == body_name), None)
    obstacle = str(trajectory.columns.get("clearance_obstacle", np.full(len(trajectory), ""))[row])
    if body is None or drawn.outcome != "collision" or f"obstacle_{obstacle}_x" not in trajectory.columns:
        return np.asarray(link_path[row])
    centre = trajectory.obstacle(obstacle)[row, :2]
    pose = robot.forward_kinematics(configurations(trajectory)[row], body.link)
    samples = np.concatenate(
        [np.linspace(capsule[:2], capsule[2:4], 41) @ pose[:2, :2].T + pose[:2, 2] for capsule in body.capsules]
    )
    away = np.clip(samples - centre, -LARGEST, LARGEST)
    return np.asarray(samples[np.argmin(np.linalg.norm(away, axis=1))])


def _outline(canvas: Canvas, obstacle: Obstacle, position: FloatArray, angle: float) -> str:
    outline = SHAPES[obstacle.shape](obstacle.entry).outline()
    if isinstance(outline, float):
        return canvas.disc(position, outline)
    return canvas.line(placed_corners(obstacle, position, angle), closed=True)
