"""The process that has PyBullet's window: reads what to show, a line of JSON each, and answers each line."""

from __future__ import annotations

import json
import os
import sys
from math import asin, atan, atan2, degrees, tan
from typing import Any, TextIO

import numpy as np

from pytest_lpb.environment.camera import Camera
from pytest_lpb.environment.goal_marks import GoalMark, goal_marks, traced_pose
from pytest_lpb.environment.spatial_view import camera_for, start_frames
from pytest_lpb.environment.visuals import VisibleBodies, add_body, put_body
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.rotations import from_matrix
from pytest_lpb.problem.spatial.urdf import Geometry

READY = "ready"
WIDTH, HEIGHT = 960, 720  # [px]
GOAL = (0.0, 0.62, 0.45)
PATH = (0.835, 0.369, 0.0)
FRAME = ((0.8, 0.15, 0.15), (0.1, 0.55, 0.1), (0.15, 0.3, 0.8))  # x, y, z
OPACITY = 0.45
LINE_PX = 3
STEP = 0.01  # of half of what is seen: what a path is longer by before it gets another line
LEAST_RADIUS = 0.02  # of half of what is seen: of a goal without a tolerance
AXIS_LENGTH, AXIS_RADIUS = 0.12, 0.05  # of half of what is seen, and of the length
BACKGROUND = (0.9, 0.92, 0.94)


class WindowClient(Client):
    """A client with PyBullet's window."""

    def __init__(self) -> None:
        colors = zip(("red", "green", "blue"), BACKGROUND, strict=True)
        background = " ".join(f"--background_color_{name}={value}" for name, value in colors)
        self.id = pybullet.connect(pybullet.GUI, options=f"--width={WIDTH} --height={HEIGHT} {background}")
        self.set_up()
        for flag in (pybullet.COV_ENABLE_GUI, pybullet.COV_ENABLE_SHADOWS, pybullet.COV_ENABLE_MOUSE_PICKING):
            self.call("configureDebugVisualizer", flag, 0)


class ShownScene:
    """One problem in the window."""

    def __init__(self, client: Client, problem: Problem) -> None:
        assert isinstance(problem.robot, SpatialRobot), f"{problem.robot.name} is no spatial robot"
        self._client = client
        self._problem = problem
        self._robot = problem.robot
        client.call("resetSimulation")
        client.call("removeAllUserDebugItems")
        client.call("configureDebugVisualizer", pybullet.COV_ENABLE_RENDERING, 0)
        frames = start_frames(problem)
        self._bodies = VisibleBodies(client, problem)
        self._bodies.place(0.0, frames)
        angle = 2.0 * atan(1.0 / client.call("getDebugVisualizerCamera")[3][5])
        camera = camera_for(problem, client, self._bodies, (WIDTH, HEIGHT), angle=angle)
        look_from(client, camera)
        self._size = camera.distance * tan(0.5 * angle)  # [m] half of what is seen
        self._marks = [self._bodies_of(mark) for mark in goal_marks(problem, 0.0, frames)]
        self._last = traced_pose(problem.primary, problem, frames)[:3, 3]
        client.call("configureDebugVisualizer", pybullet.COV_ENABLE_RENDERING, 1)

    def _bodies_of(self, mark: GoalMark) -> list[tuple[int, FloatArray]]:
        """What a goal's mark is made of: bodies, and their poses (4, 4) in the mark's frame."""
        if mark.rotation is None:
            shape = Geometry("sphere", (max(mark.radius, LEAST_RADIUS * self._size),))
            return [(add_body(self._client, shape, (*GOAL, OPACITY)), np.eye(4))]
        length = AXIS_LENGTH * self._size
        shape = Geometry("cylinder", (AXIS_RADIUS * length, length))
        made = []
        for axis, color in enumerate(FRAME):
            pose = np.eye(4)
            pose[:3, :3] = np.roll(np.eye(3), axis + 1, axis=0)  # z to x, y or z
            pose[axis, 3] = 0.5 * length
            made.append((add_body(self._client, shape, (*color, 1.0)), pose))
        return made

    def show(self, t: float, q: list[float]) -> None:
        """Show the problem at a time [s] and joint positions q (dof,); the path goes on to there."""
        frames = self._robot.link_frames(q)
        self._bodies.place(t, frames)
        for mark, bodies in zip(goal_marks(self._problem, t, frames), self._marks, strict=True):
            frame = np.eye(4)
            frame[:3, 3] = mark.position
            if mark.rotation is not None:
                frame[:3, :3] = mark.rotation
            for body, pose in bodies:
                placed = frame @ pose
                put_body(self._client, body, placed[:3, 3].tolist(), from_matrix(placed[:3, :3]))
        here = traced_pose(self._problem.primary, self._problem, frames)[:3, 3]
        if np.linalg.norm(here - self._last) > STEP * self._size:
            self._client.call("addUserDebugLine", self._last.tolist(), here.tolist(), PATH, LINE_PX)
            self._last = here


def look_from(client: Client, camera: Camera) -> None:
    """Have the window look as a camera does."""
    ahead = camera.axes[2]
    yaw, pitch = atan2(-ahead[0], ahead[1]), asin(ahead[2])
    client.call("resetDebugVisualizerCamera", camera.distance, degrees(yaw), degrees(pitch), camera.target.tolist())


def main() -> None:
    """Serve until the input ends or the window is closed."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    # PyBullet's window prints a lot; nobody reads it.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    client = WindowClient()
    try:
        serve(client, sys.stdin, answers)
    except pybullet.error:
        if client.call("isConnected"):
            raise
        # The window was closed in the middle of a command.
    client.close()


def serve(client: Client, messages: TextIO, answers: TextIO) -> None:
    """Do what the messages say, one line each; an answer says that the window is ready for the next."""
    scene: ShownScene | None = None
    print(READY, file=answers, flush=True)
    for line in messages:
        message: dict[str, Any] = json.loads(line)
        if not client.call("isConnected"):
            return
        if "problem" in message:
            scene = ShownScene(client, Problem.from_dict(message["problem"], message["name"]))
        elif scene is not None:
            scene.show(message["t"], message["q"])
        print(READY, file=answers, flush=True)
