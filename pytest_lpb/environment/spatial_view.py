"""From where a spatial problem is looked at: what must be seen, and the side from which most of it is."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from itertools import product
from math import radians

import numpy as np

from pytest_lpb.environment.camera import VIEW_ANGLE, Camera, direction, framing
from pytest_lpb.environment.goal_marks import goal_marks
from pytest_lpb.environment.visuals import VisibleBodies
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import Client
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.solids import geometry_of, pose_from, solid_of

ELEVATION = radians(24.0)
# From the side first, x to the right; behind the robot next, since obstacles tend to stand in front of it.
AZIMUTHS = tuple(radians(angle) for angle in (-60.0, -100.0, -140.0, -20.0, 60.0, 100.0, 140.0, 20.0))
PREFERENCE = 0.03  # of what is seen, by which a later side must be better
TRIED_PX = (160, 120)  # pictures that are only counted
TIMES = 25  # at which moving things are held in the picture
LEAST_M = 0.15  # [m] around every place that is seen
OBSTACLES_WITHIN, PATHS_WITHIN = 0.3, 1.0  # of the size of robot and goal, around them: what else is seen
ROOM = 1.06  # of the distance that just holds everything
CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
GOAL_SAMPLES = 24  # points on a goal's ball, of which some may be hidden


def camera_for(
    problem: Problem,
    client: Client,
    bodies: VisibleBodies,
    size: tuple[int, int],
    around: FloatArray | None = None,
    angle: float = VIEW_ANGLE,
) -> Camera:
    """The camera for a problem whose bodies are in a client, placed as at the start.

    Args:
        problem: a spatial one.
        client, bodies: what is looked at.
        size: of the picture, width and height [px].
        around: places (N, 3) [m] to be seen besides.
        angle: of view, from the lower to the upper edge [rad].
    """
    points = _places(problem, np.empty((0, 3)) if around is None else around)
    targets = _goal_samples(problem)
    seen = []
    for azimuth in AZIMUTHS:
        camera = framing(points, direction(azimuth, ELEVATION), TRIED_PX, angle)
        _, depth, ids = camera.take(client)
        robot = np.count_nonzero(np.isin(ids, bodies.robot_ids))
        seen.append((robot, _share_seen(camera, targets, depth)))
    most = max(robot for robot, _ in seen) or 1
    scores = [robot / most + goal - PREFERENCE * rank for rank, (robot, goal) in enumerate(seen)]
    best = framing(points, direction(AZIMUTHS[int(np.argmax(scores))], ELEVATION), size, angle)
    return Camera(best.target + ROOM * (best.eye - best.target), best.target, *size, angle)


def start_frames(problem: Problem) -> FloatArray:
    """Poses (links, 4, 4) of the robot's links at the start."""
    robot = problem.robot
    assert isinstance(robot, SpatialRobot)
    return robot.link_frames(problem.start_q)


def _places(problem: Problem, around: FloatArray) -> FloatArray:
    """Corners (N, 3) [m] of what must be in the picture."""
    times = np.linspace(0.0, problem.duration, TIMES)
    frames = start_frames(problem)
    goals = [mark for t in times for mark in goal_marks(problem, float(t), frames)]
    margin = max(problem.robot.body_radius, LEAST_M)
    parts = [_boxes(frames[:, :3, 3], margin), _robot_corners(problem, frames)]
    parts += [_boxes(mark.position[None], max(mark.radius, 0.5 * LEAST_M)) for mark in goals]
    inner = np.concatenate(parts)
    low, high = inner.min(axis=0), inner.max(axis=0)
    size = float(np.linalg.norm(high - low))
    # A floor or a wall may go on for metres, and a path run far away: what is far from robot and goal need not be seen.
    corners = np.clip(_obstacle_corners(problem, times), low - OBSTACLES_WITHIN * size, high + OBSTACLES_WITHIN * size)
    path = np.clip(_boxes(around, margin), low - PATHS_WITHIN * size, high + PATHS_WITHIN * size)
    return np.concatenate([inner, corners, path])


def _boxes(points: FloatArray, margin: float) -> FloatArray:
    """Corners of cubes around points (N, 3) [m]."""
    return (points[:, None] + margin * CUBE).reshape(-1, 3)


def _robot_corners(problem: Problem, frames: FloatArray) -> FloatArray:
    """Points (N, 3) [m] around the collision geometry of the links at poses (links, 4, 4)."""
    robot = problem.robot
    assert isinstance(robot, SpatialRobot)
    corners = [np.empty((0, 3))]
    for frame, name in zip(frames, robot.link_names, strict=True):
        for shape in robot.urdf.link(name).collisions:
            with suppress(ScenarioError, OSError):  # meshes that cannot be read are not seen either
                solid = solid_of(shape).placed(frame)
                corners.append(_boxes(solid.points, solid.radius))
    return np.concatenate(corners)


def _obstacle_corners(problem: Problem, times: FloatArray) -> FloatArray:
    corners = [np.empty((0, 3))]
    for obstacle in problem.obstacles:
        try:
            solid = solid_of(geometry_of(obstacle))
        except (ScenarioError, OSError):
            continue  # as above
        positions, turns = obstacle.poses(times if obstacle.moving else times[:1])
        for position, turn in zip(positions, turns, strict=True):
            corners.append(_boxes(solid.placed(pose_from(position, turn)).points, solid.radius))
    return np.concatenate(corners)


def _goal_samples(problem: Problem) -> FloatArray:
    """Points (N, 3) [m] on the balls of the goals at the start."""
    shares = (np.arange(GOAL_SAMPLES) + 0.5) / GOAL_SAMPLES
    turn, height = np.pi * (1.0 + 5.0**0.5) * np.arange(GOAL_SAMPLES), 1.0 - 2.0 * shares
    ball = np.column_stack([np.cos(turn) * np.sqrt(1 - height**2), np.sin(turn) * np.sqrt(1 - height**2), height])
    marks: Sequence[FloatArray] = [
        mark.position + max(mark.radius, 0.02) * ball for mark in goal_marks(problem, 0.0, start_frames(problem))
    ]
    return np.concatenate([np.empty((0, 3)), *marks])


def _share_seen(camera: Camera, points: FloatArray, depth: FloatArray) -> float:
    """Share of points (N, 3) that nothing hides."""
    places, away = camera.project(points)
    inside = (places >= 0).all(axis=1) & (places < (camera.width, camera.height)).all(axis=1)
    columns, rows = places[inside].astype(int).T
    return float(np.count_nonzero(away[inside] < depth[rows, columns]) / max(len(points), 1))
