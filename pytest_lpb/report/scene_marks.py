"""The parts of a scene: obstacles, goal, robot and path, as marks on a canvas."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import ScenarioError
from pytest_lpb.report.canvas import path_through
from pytest_lpb.report.depiction import Sheet
from pytest_lpb.report.numbers import show, show_exact
from pytest_lpb.report.projection import Projection
from pytest_lpb.report.scale import LARGEST
from pytest_lpb.report.view import Mark, PlannerStyle

if TYPE_CHECKING:
    from pytest_lpb.problem.obstacle import Obstacle
    from pytest_lpb.problem.robot import CollisionBody, Robot
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
        """Path of the goal's link, (N + 1, 2 or 3) [m]."""
        return self.trajectory.link(primary_link(self.trajectory))[:, : self.trajectory.problem.dimension]

    @property
    def last_row(self) -> int:
        """The last row with a finite configuration."""
        return int(finite_rows(self.trajectory)[-1])

    @property
    def violation_row(self) -> int:
        """Row at or after the first contact, or the last row."""
        touching = np.flatnonzero(self.trajectory.step_clearance < 0)
        return int(touching[0]) if len(touching) else self.last_row


def finite_rows(trajectory: Trajectory) -> NDArray[np.intp]:
    """Rows with a finite configuration."""
    return np.flatnonzero(np.isfinite(trajectory.q).all(axis=1))


def primary_link(trajectory: Trajectory) -> str:
    """The link that the primary goal speaks of; the last link for a joint goal."""
    link = trajectory.problem.primary.link
    return link if link is not None else trajectory.problem.robot.link_names[-1]


def configurations(trajectory: Trajectory) -> FloatArray:
    """Joint positions, those that diverged cut off where numbers can still be added, (N + 1, dof)."""
    return np.clip(trajectory.q, -LARGEST, LARGEST)


def around_links(trajectory: Trajectory, projection: Projection) -> FloatArray:
    """Points (N, 2) [m] around the links' frames at all rows with finite numbers, as they are seen."""
    robot = trajectory.problem.robot
    seen = projection.of(robot.link_positions(configurations(trajectory)[finite_rows(trajectory)])).reshape(-1, 2)
    return np.concatenate([seen - robot.body_radius, seen + robot.body_radius])


def obstacle_marks(sheet: Sheet, obstacle: Obstacle, until: float) -> Iterator[Mark]:
    """An obstacle at the start and, where it moves, its track and ghosts up to the time `until` [s]."""
    times = np.linspace(0.0, until, 121)
    positions, turns = obstacle.poses(times)
    if obstacle.moving:
        yield Mark(sheet.line(positions), "track", title=f"{obstacle.name}: track")
        for row in np.linspace(0, 120, OBSTACLE_GHOSTS + 1).astype(int)[1:]:
            yield Mark(
                sheet.outline(obstacle, positions[row], turns[row]),
                "obstacle ghost",
                title=f"{obstacle.name} at {show(times[row])} s",
            )
    yield Mark(sheet.outline(obstacle, positions[0], turns[0]), "obstacle", title=obstacle.name)


def goal_points(trajectory: Trajectory) -> FloatArray:
    """Targets of the primary goal over time, (N + 1, 2 or 3) [m]; empty when it is no place in the world.

    NaN along axes that the goal says nothing of.
    """
    problem = trajectory.problem
    entry = goal_entry(trajectory)
    if problem.primary.type != "position" or entry.get("relative_to") not in (None, "world"):
        return np.empty((0, problem.dimension))
    points = np.full((len(trajectory), problem.dimension), np.nan)
    points[:, entry.get("axes") or slice(None)] = trajectory.goal(problem.primary.name)
    return points


def goal_entry(trajectory: Trajectory) -> Any:
    """The primary goal's entry in the concrete problem."""
    name = trajectory.problem.primary.name
    return next(entry for entry in trajectory.problem.to_dict()["goal"] if entry["name"] == name)


def goal_marks(sheet: Sheet, trajectory: Trajectory) -> Iterator[Mark]:
    """The goal with its tolerance; the track of a moving one."""
    goal = trajectory.problem.primary
    points = sheet.projection.of(goal_points(trajectory))
    if not np.isfinite(points).all() or len(points) == 0:
        return
    if goal.moving:
        yield Mark(sheet.canvas.line(points), "track goal-track", title=f"track of goal {goal.name}")
    tolerance = goal.tolerance
    if tolerance is not None:
        yield Mark(
            sheet.canvas.disc(points[0], tolerance),
            "tolerance",
            title=f"goal {goal.name}: within {show_exact(tolerance)} m",
        )
    x, y = sheet.canvas.pixels(points[:1])[0]
    yield Mark(f"M{x - 6:.1f} {y:.1f}h12M{x:.1f} {y - 6:.1f}v12", "goal", title=f"goal {goal.name}")


def robot_marks(sheet: Sheet, trajectory: Trajectory, row: int, css: str, drawn: Drawn | None) -> Iterator[Mark]:
    """The robot at a row."""
    robot = trajectory.problem.robot
    style = drawn.style if drawn else None
    yield from sheet.depiction.robot(sheet, trajectory, row, css, style)
    if robot.non_holonomic:
        pose = robot.forward_kinematics(configurations(trajectory)[row], robot.link_names[0])
        here, forward = pose[:-1, -1], pose[:-1, 0]
        ahead = here + forward * max(robot.body_radius, 8.0 / sheet.canvas.scale)
        yield Mark(sheet.line(np.array([here, ahead])), f"heading {css}", style)


def ghost_rows(drawn: Drawn) -> list[int]:
    """Rows at equal steps along the motion of the joints, without the first and the last."""
    steps = np.diff(configurations(drawn.trajectory), axis=0)
    moved = np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])
    if not np.isfinite(moved[-1]) or moved[-1] == 0:
        return []
    return [int(row) for row in np.searchsorted(moved, np.linspace(0, moved[-1], ROBOT_GHOSTS + 2)[1:-1])]


def path_marks(sheet: Sheet, drawn: Drawn) -> Iterator[Mark]:
    """A planner's path, the robot where it ends, and a cross where it touched something."""
    name, points, canvas = drawn.style.name, sheet.projection.of(drawn.path), sheet.canvas
    yield Mark(canvas.line(points), "path", drawn.style, title=f"{name}: {drawn.outcome}")
    finite = points[np.isfinite(points).all(axis=1)]
    if len(finite) == 0:
        return
    x, y = (round(float(place), 1) for place in canvas.pixels(finite[-1:])[0])
    solved = "solved" if drawn.outcome == "success" else "failed"
    yield Mark(drawn.style.marker, f"end {solved}", drawn.style, title=f"{name}: end, {drawn.outcome}", at=(x, y))
    if drawn.outcome in CONTACTS:
        place = canvas.pixels(sheet.projection.of(contact_point(drawn))[None, :])[0]
        yield Mark(path_through(place + CROSS), "collision", drawn.style, title=f"{name}: {drawn.outcome}")


def contact_point(drawn: Drawn) -> FloatArray:
    """The point on the touching body's axis that is nearest to the obstacle's centre, (2 or 3,) [m]."""
    trajectory, row = drawn.trajectory, drawn.violation_row
    robot, link_path = trajectory.problem.robot, drawn.path
    body_name = str(trajectory.columns.get("clearance_body", np.full(len(trajectory), ""))[row])
    obstacle = str(trajectory.columns.get("clearance_obstacle", np.full(len(trajectory), ""))[row])
    body = next((body for body in known_bodies(robot) if body.name == body_name), None)
    if body is None or drawn.outcome != "collision" or f"obstacle_{obstacle}_x" not in trajectory.columns:
        return np.asarray(link_path[row])
    d = trajectory.problem.dimension
    centre = trajectory.obstacle(obstacle)[row, :d]
    pose = robot.forward_kinematics(configurations(trajectory)[row], body.link)
    samples = np.concatenate(
        [np.linspace(axis[:d], axis[d : 2 * d], 41) @ pose[:d, :d].T + pose[:d, d] for axis in body.capsules]
    )
    away = np.clip(samples - centre, -LARGEST, LARGEST)
    return np.asarray(samples[np.argmin(np.linalg.norm(away, axis=1))])


def known_bodies(robot: Robot) -> Sequence[CollisionBody]:
    """What collides; nothing when a mesh cannot be read any more."""
    try:
        return robot.collision_bodies
    except (ScenarioError, OSError):
        return ()
