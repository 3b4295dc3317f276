"""Pictures of spatial trials: rendered in software without a display, or shown in PyBullet's window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow
from PIL import ImageDraw, ImageFont

from pytest_lpb.environment.camera import Image
from pytest_lpb.environment.goal_marks import GoalMark, goal_marks, traced_pose
from pytest_lpb.environment.heading import arrow, heading_of
from pytest_lpb.environment.paint import Rgb, add_ball, add_samples, backdrop, sampled
from pytest_lpb.environment.picture import RealTime
from pytest_lpb.environment.spatial_view import camera_for, start_frames
from pytest_lpb.environment.spatial_window import SpatialWindow
from pytest_lpb.environment.visuals import VisibleBodies
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import Client
from pytest_lpb.problem.spatial.robot import SpatialRobot

WIDTH, HEIGHT = 640, 480  # [px]
WINDOW_RATE_HZ = 30.0  # pictures per second of simulated time in a window
GOAL: Rgb = (0, 158, 115)
PATH: Rgb = (213, 94, 0)
AXES: tuple[Rgb, ...] = ((200, 40, 40), (30, 140, 30), (40, 70, 200))  # x, y, z of a frame
INK: Rgb = (60, 66, 74)
PAPER: Rgb = (240, 242, 245)  # around the letters
TEXT_PX = 14
MARK_SIZE = 0.035  # half a goal's cross, or an axis of a frame, in distances of the camera
CELLS_M = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # of the grid on the ground
ABOVE = 0.02  # of its length, by which the arrow of a heading is above the ground
CELLS_ACROSS = 6  # of them at least, in the distance of the camera


class SpatialPicture:
    """Draws spatial problems, see `Picture`.

    Args:
        show: whether in PyBullet's window; raises LpbError where there is no display.
        around: places (N, 3) [m] to be held in the picture besides.
    """

    def __init__(self, *, show: bool, around: FloatArray | None = None) -> None:
        self._around = around
        self._window = SpatialWindow() if show else None
        self._scene: RenderedScene | None = None
        self._problem: Problem | None = None
        self._time = RealTime()

    def draw(self, problem: Problem, row: int, q: list[float]) -> NDArray[np.uint8] | None:
        """Draw a row; (height, width, 3) without a window, None with one, which is shown in real time."""
        first = self._problem is not problem or row == 0
        if self._window is not None:
            self._show(self._window, problem, row, q, first=first)
            return None
        if self._problem is not problem or self._scene is None:
            self._forget()
            self._scene, self._problem = RenderedScene(problem, self._around), problem
        if row == 0:
            self._scene.restart()
        return self._scene.picture(row * problem.dt, q)

    def _show(self, window: SpatialWindow, problem: Problem, row: int, q: list[float], *, first: bool) -> None:
        t = row * problem.dt
        if first:
            window.load(problem)
            self._problem = problem
        elif row % max(1, round(1.0 / (WINDOW_RATE_HZ * problem.dt))):
            return
        window.show(t, q)
        if first:
            self._time.restart(t)
        elif window.open:
            self._time.wait_for(t)

    def _forget(self) -> None:
        if self._scene is not None:
            self._scene.close()
            self._scene = None

    def close(self) -> None:
        """Close the window and free the client; again is no harm."""
        self._forget()
        if self._window is not None:
            self._window.close()


class RenderedScene:
    """One problem, rendered by PyBullet in a client of its own; goals, path and ground are painted over it.

    Args:
        problem: a spatial one.
        around: places (N, 3) [m] to be held in the picture.
    """

    def __init__(self, problem: Problem, around: FloatArray | None) -> None:
        assert isinstance(problem.robot, SpatialRobot), f"{problem.robot.name} is no spatial robot"
        self._problem = problem
        self._robot = problem.robot
        self._client = Client()
        self._bodies = VisibleBodies(self._client, problem)
        self._bodies.place(0.0, start_frames(problem))
        self.camera = camera_for(problem, self._client, self._bodies, (WIDTH, HEIGHT), around)
        cells = [cell for cell in CELLS_M if cell * CELLS_ACROSS <= self.camera.distance]
        self._backdrop = backdrop(self.camera, max(cells, default=CELLS_M[0]))
        self._heading = heading_of(self._robot)
        self._font = ImageFont.load_default(TEXT_PX)
        self.restart()

    def restart(self) -> None:
        """Begin a new path."""
        self._last: FloatArray | None = None
        self._path: list[FloatArray] = []

    def picture(self, t: float, q: list[float]) -> Image:
        """The picture (height, width, 3) at a time [s] and joint positions q (dof,); the path goes on to there."""
        frames = self._robot.link_frames(q)
        self._bodies.place(t, frames)
        picture, depth, _ = self.camera.take(self._client)
        empty = np.isinf(depth)
        picture[empty] = self._backdrop[empty]
        self._extend_path(frames)
        add_samples(picture, depth, np.concatenate(self._path), PATH)
        for mark in goal_marks(self._problem, t, frames):
            self._add_mark(picture, depth, mark)
        self._add_heading(picture, depth, frames)
        return self._with_title(picture, f"{self._problem.name}, seed {self._problem.seed}, t = {t:.2f} s")

    def _extend_path(self, frames: FloatArray) -> None:
        here = traced_pose(self._problem.primary, self._problem, frames)[:3, 3]
        last = here if self._last is None else self._last
        self._path.append(sampled(self.camera, np.stack([last, here])))
        self._last = here

    def _add_mark(self, picture: Image, depth: FloatArray, mark: GoalMark) -> None:
        length = MARK_SIZE * self.camera.distance
        axes = np.eye(3) if mark.rotation is None else mark.rotation
        begin = -length if mark.rotation is None else 0.0
        for index, color in enumerate(AXES):
            ends = mark.position + np.array([[begin], [length]]) * axes[:, index]
            add_samples(picture, depth, sampled(self.camera, ends), GOAL if mark.rotation is None else color)
        if mark.radius > 0.0:
            add_ball(picture, depth, self.camera, mark.position, mark.radius, GOAL)

    def _add_heading(self, picture: Image, depth: FloatArray, frames: FloatArray) -> None:
        if self._heading is not None:
            link, length = self._heading
            for line in arrow(frames[self._robot.link_index(link)], length):
                add_samples(picture, depth, sampled(self.camera, line + np.array([0.0, 0.0, ABOVE * length])), INK)

    def _with_title(self, picture: Image, title: str) -> Image:
        canvas = Pillow.fromarray(picture)
        ImageDraw.Draw(canvas).text((10, 8), title, fill=INK, font=self._font, stroke_width=2, stroke_fill=PAPER)
        return np.array(canvas)

    def close(self) -> None:
        """Free the client."""
        self._client.close()
