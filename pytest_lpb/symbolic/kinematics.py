"""Link frames and input maps of all robots, in the plane and in space, as CasADi expressions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import casadi

from pytest_lpb.problem.planar.robot import PlanarRobot
from pytest_lpb.problem.robot import Robot
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.symbolic import casadi_kinematics

Frame = tuple[Any, Any]  # position (d, 1) [m] and rotation (d, d), in the world


def _planar_frame(robot: Robot, q: Any, link: str) -> Frame:
    assert isinstance(robot, PlanarRobot)
    x, y, c, s = robot.frames(casadi.vertsplit(q), casadi.cos, casadi.sin)[robot.link_index(link)]
    turn = casadi.vertcat(casadi.horzcat(c, -s), casadi.horzcat(s, c))
    return casadi.SX(casadi.vertcat(x, y)), casadi.SX(turn)


def _spatial_frame(robot: Robot, q: Any, link: str) -> Frame:
    assert isinstance(robot, SpatialRobot)
    return casadi_kinematics(robot, q, link)


_FRAMES: Mapping[int, Callable[[Robot, Any, str], Frame]] = {2: _planar_frame, 3: _spatial_frame}  # by dimension


class Frames:
    """Frames of a robot's links at symbolic q, each composed once.

    Args:
        robot: any robot.
        q: casadi.SX (dof, 1).
    """

    def __init__(self, robot: Robot, q: Any) -> None:
        self.robot = robot
        self.q = q
        self._known: dict[str, Frame] = {}

    def of(self, link: str) -> Frame:
        """Position (d, 1) [m] and rotation (d, d) of a link's frame in the world. Raises ValueError: unknown link."""
        if link not in self._known:
            self._known[link] = _FRAMES[self.robot.dimension](self.robot, self.q, link)
        return self._known[link]

    def point(self, link: str, local: Any) -> Any:
        """Position (d, 1) [m] in the world of a point (d,) [m] in a link's frame."""
        position, rotation = self.of(link)
        return position + rotation @ casadi.DM(list(local))


def input_map(robot: Robot, q: Any) -> Any:
    """B with qd = B w, (dof, inputs), w as `planner.actuation` has it: of a car (v, turn rate), never the steering."""
    if not robot.non_holonomic:
        return casadi.SX.eye(robot.dof)
    arm = robot.n_actions - 2
    columns = casadi.SX(robot.dof, robot.n_actions)
    columns[0, 0], columns[1, 0], columns[2, 1] = casadi.cos(q[2]), casadi.sin(q[2]), 1.0
    for joint in range(arm):
        columns[robot.dof - arm + joint, 2 + joint] = 1.0
    return columns


def turn_of_quaternion(quaternion: Any) -> Any:
    """Rotation matrix (3, 3) of a quaternion wxyz (4, 1), of unit length."""
    w, x, y, z = casadi.vertsplit(quaternion)
    return casadi.vertcat(
        casadi.horzcat(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        casadi.horzcat(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        casadi.horzcat(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def turn_of_angle(angle: Any) -> Any:
    """Rotation matrix (2, 2) of an angle (1, 1) [rad]."""
    c, s = casadi.cos(angle), casadi.sin(angle)
    return casadi.vertcat(casadi.horzcat(c, -s), casadi.horzcat(s, c))


# Rotation matrices of orientations as observations have them, by dimension.
TURNS: Mapping[int, Callable[[Any], Any]] = {2: turn_of_angle, 3: turn_of_quaternion}


def velocity_map(robot: Robot, q: Any) -> Any:
    """B with qd = B u, (dof, n_actions): `robot.action_map` as an expression."""
    columns = input_map(robot, q)
    if robot.base != "bicycle":
        return columns
    # u = (v, rate of the steering angle) where `input_map` has (v, turn rate).
    columns[2, 1], columns[3, 1] = 0.0, 1.0
    columns[2, 0] = casadi.tan(q[3]) / float(robot.entry["wheel_base"])
    return columns
