"""The process that has PyBullet's window: reads what to show, a line of JSON each, and answers each line."""

from __future__ import annotations

import json
import os
import sys
from math import degrees, tan
from typing import Any, TextIO

import numpy as np

from pytest_lpb.environment.camera import VIEW_ANGLE, Camera
from pytest_lpb.environment.goal_marks import GoalMark, goal_marks, traced_pose
from pytest_lpb.environment.spatial_view import camera_for, start_frames
from pytest_lpb.environment.visuals import VisibleBodies
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.robot import SpatialRobot

READY = "ready"
WIDTH, HEIGHT = 960, 720  # [px]
GOAL = (0.0, 0.62, 0.45)
PATH = (0.835, 0.369, 0.0)
FRAME = ((0.8, 0.15, 0.15), (0.1, 0.55, 0.1), (0.15, 0.3, 0.8))  # x, y, z
OPACITY = 0.45
LINE_PX = 3
BACKGROUND = (0.9, 0.92, 0.94)
WINDOW_ROOM = 1.15  # of the distance that would show the same: nearer things look larger at a wide angle
STEP = 0.005  # of the camera's distance: what a path is longer by before it gets another line


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
        camera = camera_for(problem, client, self._bodies, (WIDTH, HEIGHT), np.empty((0, 3)))
        self._distance = camera.distance
        look_from(client, camera)
        self._goals = [self._ball(mark) for mark in goal_marks(problem, 0.0, frames)]
        self._axes: dict[tuple[int, int], int] = {}
        self._last = traced_pose(problem.primary, problem, frames)[:3, 3]
        client.call("configureDebugVisualizer", pybullet.COV_ENABLE_RENDERING, 1)

    def _ball(self, mark: GoalMark) -> int:
        """A goal's translucent ball; -1 for a goal that has none."""
        if mark.radius <= 0.0:
            return -1
        visual = self._client.call(
            "createVisualShape", pybullet.GEOM_SPHERE, radius=mark.radius, rgbaColor=(*GOAL, OPACITY)
        )
        body: int = self._client.call("createMultiBody", baseMass=0, baseVisualShapeIndex=visual)
        return body

    def show(self, t: float, q: list[float]) -> None:
        """Show the problem at a time [s] and joint positions q (dof,); the path goes on to there."""
        frames = self._robot.link_frames(q)
        self._bodies.place(t, frames)
        for index, mark in enumerate(goal_marks(self._problem, t, frames)):
            if self._goals[index] >= 0:
                self._client.call(
                    "resetBasePositionAndOrientation", self._goals[index], mark.position.tolist(), (0, 0, 0, 1)
                )
            if mark.rotation is not None:
                self._show_axes(index, mark.position, mark.rotation)
        here = traced_pose(self._problem.primary, self._problem, frames)[:3, 3]
        if np.linalg.norm(here - self._last) > STEP * self._distance:
            self._line(self._last, here, PATH)
            self._last = here

    def _show_axes(self, index: int, position: FloatArray, rotation: FloatArray) -> None:
        for axis, color in enumerate(FRAME):
            end = position + 0.05 * self._distance * rotation[:, axis]
            self._axes[index, axis] = self._line(position, end, color, self._axes.get((index, axis), -1))

    def _line(self, start: FloatArray, end: FloatArray, color: tuple[float, ...], replaced: int = -1) -> int:
        made: int = self._client.call(
            "addUserDebugLine", start.tolist(), end.tolist(), color, LINE_PX, replaceItemUniqueId=replaced
        )
        return made


def look_from(client: Client, camera: Camera) -> None:
    """Have the window look as a camera does, from as near as its own, wider angle of view lets it see the same."""
    ahead = camera.axes[2]
    yaw, pitch = np.arctan2(-ahead[0], ahead[1]), np.arcsin(ahead[2])
    projection = client.call("getDebugVisualizerCamera")[3]
    distance = WINDOW_ROOM * camera.distance * tan(0.5 * VIEW_ANGLE) * projection[5]
    client.call("resetDebugVisualizerCamera", distance, degrees(yaw), degrees(pitch), camera.target.tolist())


def main() -> None:
    """Serve until the input ends or the window is closed."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    # PyBullet's window prints a lot; nobody reads it.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    client = WindowClient()
    serve(client, sys.stdin, answers)
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
