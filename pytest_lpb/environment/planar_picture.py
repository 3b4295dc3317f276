"""Pictures of planar trials, drawn with matplotlib."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from numpy.typing import NDArray

from pytest_lpb.environment.framing import with_neighbours
from pytest_lpb.environment.heading import arrow, heading_of
from pytest_lpb.environment.picture import RealTime
from pytest_lpb.errors import LpbError
from pytest_lpb.problem.planar.collision import PlanarCollision
from pytest_lpb.problem.planar.robot import PlanarRobot
from pytest_lpb.problem.planar.shapes import outline_of, planar_shape
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.shown import literal

SIZE_INCH = 6.4
DPI = 100
MARGIN_M = 0.5  # [m] around everything that is drawn
WINDOW_RATE_HZ = 20.0  # pictures per second of simulated time in a window
WINDOWLESS_BACKENDS = ("agg", "pdf", "svg", "ps", "cairo", "template")
# No planner's colour of the report, since the robot is any planner's.
ROBOT, GOAL, OBSTACLE, PATH, INK = "#51606f", "#009e73", "#b8bfc7", "#d55e00", "#1b1f24"


class PlanarPicture:
    """Draws planar problems, see `Picture`.

    Args:
        show: whether in a window; raises LpbError where matplotlib cannot open one.
        around: places (N, 2) [m] to be held in the picture besides.
    """

    def __init__(self, *, show: bool, around: FloatArray | None = None) -> None:
        self._show = show
        self._around = np.empty((0, 2)) if around is None else around
        self._problem: Problem | None = None
        self._path: list[tuple[float, float]] = []
        self._time = RealTime()
        if show:
            self._figure = _window_figure()
        else:
            self._figure = Figure(figsize=(SIZE_INCH, SIZE_INCH), dpi=DPI)
            FigureCanvasAgg(self._figure)
        self._axes: Axes = self._figure.add_subplot()

    def draw(self, problem: Problem, row: int, q: list[float]) -> NDArray[np.uint8] | None:
        """Draw a row; (height, width, 3) without a window, None with one, which is shown in real time."""
        robot = problem.robot
        assert isinstance(robot, PlanarRobot)
        first = self._problem is not problem or row == 0
        if first:
            self._problem, self._path = problem, []
        frames = robot.frames(q)
        self._path.append(frames[-1][:2])
        if self._show and not first and row % max(1, round(1.0 / (WINDOW_RATE_HZ * problem.dt))):
            return None
        self._axes.clear()
        self._draw_obstacles(problem, row)
        self._draw_goal(problem, row)
        self._axes.plot(*zip(*self._path, strict=True), color=PATH, linewidth=1.2)
        xs, ys = zip(*(frame[:2] for frame in frames), strict=True)
        self._axes.plot(xs, ys, color=ROBOT, alpha=0.7, linewidth=2.0)
        for ax, ay, bx, by, radius in PlanarCollision(robot, []).capsules(frames):
            self._axes.add_patch(Polygon(_capsule(ax, ay, bx, by, radius), color=ROBOT, alpha=0.7, linewidth=0))
        self._draw_heading(robot, q)
        self._finish(problem, row)
        canvas: Any = self._figure.canvas
        canvas.draw()
        if not self._show:
            return np.asarray(canvas.buffer_rgba())[..., :3].copy()
        canvas.flush_events()
        (self._time.restart if first else self._time.wait_for)(row * problem.dt)
        return None

    def _draw_obstacles(self, problem: Problem, row: int) -> None:
        t = np.array([row * problem.dt])
        collision = PlanarCollision(problem.robot, problem.obstacles)  # type: ignore[arg-type] # planar here
        for obstacle, shape in zip(problem.obstacles, collision.shapes, strict=True):
            positions, angles = obstacle.poses(t)
            x, y, angle = float(positions[0, 0]), float(positions[0, 1]), float(angles[0])
            outline = outline_of(shape)
            if isinstance(outline, float):
                self._axes.add_patch(Circle((x, y), outline, color=OBSTACLE, linewidth=0))
            else:
                turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
                self._axes.add_patch(Polygon(np.array(outline) @ turn + (x, y), color=OBSTACLE, linewidth=0))

    def _draw_heading(self, robot: PlanarRobot, q: list[float]) -> None:
        found = heading_of(robot)
        if found is not None:
            for line in arrow(robot.forward_kinematics(q, found[0]), found[1]):
                self._axes.plot(line[:, 0], line[:, 1], color=INK, linewidth=1.6, solid_capstyle="round")

    def _draw_goal(self, problem: Problem, row: int) -> None:
        for goal in problem.goal:
            target = goal.motion.evaluate(np.array([row * problem.dt]))[0][0]
            if goal.type == "position" and len(target) == 2:
                place = (float(target[0]), float(target[1]))
                self._axes.plot(*place, "+", color=GOAL, markersize=10)
                self._axes.add_patch(Circle(place, goal.tolerance or 0.0, color=GOAL, fill=False))

    def _finish(self, problem: Problem, row: int) -> None:
        axes = self._axes
        axes.set_title(f"{literal(problem.name)}, seed {problem.seed}, t = {row * problem.dt:.2f} s", fontsize=10)
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        low, high = _extent(problem, self._around)
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.set_aspect("equal")

    def close(self) -> None:
        """Close the window."""
        if self._show:
            from matplotlib import pyplot

            pyplot.close(self._figure)


def _window_figure() -> Figure:
    from matplotlib import get_backend, pyplot

    if get_backend().lower() in WINDOWLESS_BACKENDS:
        raise LpbError(
            "--lpb-render (render_mode 'human') needs a display, and matplotlib found none: "
            "run it on a desktop, or use render_mode 'rgb_array'"
        )
    figure = pyplot.figure(figsize=(SIZE_INCH, SIZE_INCH))
    figure.show()
    return figure


def _capsule(ax: float, ay: float, bx: float, by: float, radius: float) -> NDArray[np.float64]:
    """Outline of a capsule, (points, 2) [m]."""
    angle = np.arctan2(by - ay, bx - ax)
    half = np.linspace(-np.pi / 2, np.pi / 2, 16)
    far = np.column_stack([bx + radius * np.cos(angle + half), by + radius * np.sin(angle + half)])
    near = np.column_stack([ax - radius * np.cos(angle + half), ay - radius * np.sin(angle + half)])
    return np.vstack([far, near])


def _extent(problem: Problem, around: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Corners of what is seen: start, goal, an arm's reach, what is around, and obstacles near them."""
    t = np.linspace(0.0, problem.duration, 50)
    points = [problem.robot.link_positions(problem.start_q[None])[0]]
    points += [g.motion.evaluate(t)[0] for g in problem.goal if g.type == "position" and g.motion.size == 2]
    reach = sum(getattr(problem.robot, "lengths", ()))
    points.append(np.array([[-reach, -reach], [reach, reach]]) if reach else points[0])
    stacked = np.vstack(points)
    low, high = stacked.min(axis=0), stacked.max(axis=0)
    if len(around):
        size = np.maximum(high - low, 2.0 * MARGIN_M)
        # A path that runs far away must not shrink the picture.
        low = np.minimum(low, around.min(axis=0).clip(low - size))
        high = np.maximum(high, around.max(axis=0).clip(None, high + size))
    margin = MARGIN_M + problem.robot.body_radius
    return with_neighbours(low - margin, high + margin, _boxes(problem))


def _boxes(problem: Problem) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Corners around each obstacle as it stands at the start."""
    for obstacle in problem.obstacles:
        place = obstacle.poses(np.zeros(1))[0][0]
        size = planar_shape(obstacle.entry).circumradius
        yield place - size, place + size
