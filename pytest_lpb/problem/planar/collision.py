"""Clearance of a planar robot: signed distances of its bodies to obstacles and to each other."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, inf, nan

import numpy as np

from pytest_lpb.problem.collision import Clearance, ClosedAtTheEnd
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.planar.geometry import segment_to_segment
from pytest_lpb.problem.planar.robot import Frame, PlanarRobot
from pytest_lpb.problem.planar.shapes import PlacedShape, planar_shape

CONTACT_SLACK_M = 1e-9  # [m] depth from which bodies collide: touching within rounding is none

Capsule = tuple[float, float, float, float, float]  # ax, ay, bx, by, radius [m]


class PlanarCollision:
    """Measures clearances of one problem; shapes are placed by `place`, then asked as often as needed.

    Attributes:
        shapes, obstacle_names: of the obstacles.
        placed, body_names: link and capsule of each of the robot's bodies, in the link's frame.
        pairs: indices of the robot's own bodies that must not touch.
    """

    def __init__(self, robot: PlanarRobot, obstacles: Sequence[Obstacle]) -> None:
        self.shapes: list[PlacedShape] = [planar_shape(obstacle.entry) for obstacle in obstacles]
        self.obstacle_names = [obstacle.name for obstacle in obstacles]
        bodies = robot.collision_bodies
        self.body_names = [body.name for body in bodies for _ in body.capsules]
        self.placed = [(robot.link_index(body.link), capsule) for body in bodies for capsule in body.capsules]
        owners: dict[str, list[int]] = {body.name: [] for body in bodies}
        for index, name in enumerate(self.body_names):
            owners[name].append(index)
        self.pairs = [
            (i, j) for first, second in robot.self_collision_pairs for i in owners[first] for j in owners[second]
        ]

    def capsules(self, frames: Sequence[Frame]) -> list[Capsule]:
        """The robot's bodies in the world, one capsule each."""
        placed = []
        for link, (ax, ay, bx, by, radius) in self.placed:
            x, y, c, s = frames[link]
            start_x, start_y = x + c * ax - s * ay, y + s * ax + c * ay
            if ax == bx and ay == by:
                placed.append((start_x, start_y, start_x, start_y, radius))
            else:
                placed.append((start_x, start_y, x + c * bx - s * by, y + s * bx + c * by, radius))
        return placed

    def clearance(self, capsules: Sequence[Capsule]) -> Clearance:
        """Signed distance to the nearest obstacle [m] with the names of body and obstacle; NaN without obstacles."""
        nearest, nearest_body, nearest_obstacle = inf, -1, -1
        for body, (ax, ay, bx, by, radius) in enumerate(capsules):
            middle_x, middle_y = 0.5 * (ax + bx), 0.5 * (ay + by)
            reach = radius + 0.5 * hypot(bx - ax, by - ay)
            for obstacle, shape in enumerate(self.shapes):
                # The discs around both bound the distance from below: most pairs need no more than this.
                bound = hypot(shape.x - middle_x, shape.y - middle_y) - shape.circumradius - reach
                if bound < nearest:
                    distance = shape.distance_to_segment(ax, ay, bx, by) - radius
                    if distance < nearest:
                        nearest, nearest_body, nearest_obstacle = distance, body, obstacle
        if nearest_body < 0:
            return nan, "", ""
        return nearest, self.body_names[nearest_body], self.obstacle_names[nearest_obstacle]

    def self_clearance(self, capsules: Sequence[Capsule]) -> Clearance:
        """Signed distance between the nearest pair of the robot's own bodies [m]; NaN without pairs."""
        if not self.pairs:
            return nan, "", ""
        nearest, pair = inf, self.pairs[0]
        for candidate in self.pairs:
            ax, ay, bx, by, first = capsules[candidate[0]]
            cx, cy, dx, dy, second = capsules[candidate[1]]
            distance = segment_to_segment(ax, ay, bx, by, cx, cy, dx, dy) - first - second
            if distance < nearest:
                nearest, pair = distance, candidate
        return nearest, self.body_names[pair[0]], self.body_names[pair[1]]

    def distance(self, capsule: Capsule, obstacle: int) -> float:
        """Signed distance of one body to one obstacle [m]."""
        ax, ay, bx, by, radius = capsule
        return self.shapes[obstacle].distance_to_segment(ax, ay, bx, by) - radius

    def disc_distance(self, capsule: Capsule, obstacle: int) -> float:
        """Lower bound of that distance: between the discs around both [m]."""
        ax, ay, bx, by, radius = capsule
        shape = self.shapes[obstacle]
        apart = hypot(shape.x - 0.5 * (ax + bx), shape.y - 0.5 * (ay + by))
        return apart - shape.circumradius - radius - 0.5 * hypot(bx - ax, by - ay)

    def pair_distance(self, pair: int, capsules: Sequence[Capsule]) -> float:
        """Signed distance between a pair of the robot's own bodies [m]."""
        ax, ay, bx, by, first = capsules[self.pairs[pair][0]]
        cx, cy, dx, dy, second = capsules[self.pairs[pair][1]]
        return segment_to_segment(ax, ay, bx, by, cx, cy, dx, dy) - first - second


class PlanarSpace(ClosedAtTheEnd):
    """Clearances of a planar robot at single configurations, with obstacles where they are at t = 0.

    Args:
        robot: the robot.
        obstacles: those that count.
    """

    contact_slack_m = CONTACT_SLACK_M

    def __init__(self, robot: PlanarRobot, obstacles: Sequence[Obstacle]) -> None:
        self._robot = robot
        self._collision = PlanarCollision(robot, obstacles)
        for shape, obstacle in zip(self._collision.shapes, obstacles, strict=True):
            positions, angles = obstacle.poses(np.zeros(1))
            shape.place(float(positions[0, 0]), float(positions[0, 1]), float(angles[0]))

    def clearance(self, q: Sequence[float]) -> Clearance:
        """Signed distance [m] to the nearest obstacle with body and obstacle; NaN without obstacles."""
        return self._collision.clearance(self._collision.capsules(self._robot.frames(q)))

    def self_clearance(self, q: Sequence[float]) -> Clearance:
        """Signed distance [m] between the robot's own bodies; NaN without pairs."""
        return self._collision.self_clearance(self._collision.capsules(self._robot.frames(q)))

    def clearance_of(self, obstacle: Obstacle, q: Sequence[float]) -> float:
        """Signed distance [m] to one further obstacle."""
        return PlanarSpace(self._robot, [obstacle]).clearance(q)[0]
