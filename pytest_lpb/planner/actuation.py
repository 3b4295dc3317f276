"""How planners speak to bases: as inputs they can reason about, and back as the robot's actions.

Every base is given inputs w of which a Jacobian per qd can be mapped to a Jacobian per w.
"""

from __future__ import annotations

from collections.abc import Callable
from math import atan, cos, inf, isfinite, sin, sqrt, tan

import numpy as np

from pytest_lpb.planner.base import FloatArray, Observation
from pytest_lpb.problem.robot import Robot

STEERING_HORIZON_S = 0.3  # [s] within which a car is to turn as asked
STEERING_GAIN = 6.0  # [1/s] of the steering angle's error
STEERING_RATE_GAIN = 15.0  # [1/s] of the steering rate's error
STEEPEST = 0.6  # [rad] of a car whose steering has no limits
TURNING_SHARE = 0.95  # of the steering range that is used


class Actuation:
    """A robot whose inputs are its joint velocities.

    Args:
        robot: the robot.
        control: acceleration or velocity.
        period: of the planner [s].
        lookahead: distance ahead of a non-holonomic base at which it is steered [m].
    """

    direct = True  # inputs are qd

    def __init__(self, robot: Robot, control: str, period: float, lookahead: float) -> None:
        self._robot = robot
        self._velocity_control = control == "velocity"
        self._period = period
        self.lookahead = lookahead  # [m]

    def per_input(self, jacobian: FloatArray, q: FloatArray, lookahead: float | None = None) -> FloatArray:  # noqa: ARG002
        """A Jacobian's columns per input, (.., m, dof) to (.., m, inputs); `lookahead` [m] by default the robot's."""
        return jacobian

    def input_map(self, q: FloatArray) -> FloatArray | None:  # noqa: ARG002
        """B with qd = B w, (dof, inputs); None: the identity."""
        return None

    def inputs(self, observation: Observation) -> FloatArray:
        """The inputs w that the robot has now."""
        return observation["u"]

    def command(self, action: FloatArray, observation: Observation) -> FloatArray:  # noqa: ARG002
        """The robot's action from that of the inputs: dw/dt under acceleration control, else w."""
        return action

    def lookahead_at(self, error: FloatArray) -> float | None:  # noqa: ARG002
        """The lookahead [m] that steers to a goal this far away; None: the robot's own."""
        return None


class DifferentialDriveActuation(Actuation):
    """A base that cannot move sideways at once: inputs (v, w, arm..).

    A point `lookahead` ahead of it can, so its Jacobian stands in for the base's (input-output linearisation:
    Siciliano et al., "Robotics", 2009, section 11.6.1). With an arm on the base there is no need: the arm evades.
    """

    direct = False

    def __init__(self, robot: Robot, control: str, period: float, lookahead: float) -> None:
        super().__init__(robot, control, period, lookahead)
        self._arm = robot.n_actions > 2

    def per_input(self, jacobian: FloatArray, q: FloatArray, lookahead: float | None = None) -> FloatArray:
        """A Jacobian's columns per input, (.., m, dof) to (.., m, inputs)."""
        mapped: FloatArray = jacobian @ self.input_map(q)
        theta, ahead = float(q[2]), self.lookahead if lookahead is None else lookahead
        if not self._arm:
            mapped[..., 1] += jacobian[..., :2] @ np.array([-ahead * sin(theta), ahead * cos(theta)])
        return mapped

    def input_map(self, q: FloatArray) -> FloatArray:
        """B with qd = B w, (dof, inputs)."""
        return self._robot.action_map(q)

    def lookahead_at(self, error: FloatArray) -> float:
        """The lookahead [m] that steers to a goal this far away.

        A fixed one would let the base come to rest with the goal beside it: its bearing then grows to a right angle.
        Half the distance left keeps it facing the goal; a sixth of the lookahead bounds the turn rate.
        """
        distance = sqrt(float(error @ error))
        return min(max(0.5 * distance, self.lookahead / 6.0), self.lookahead)


class CarActuation(DifferentialDriveActuation):
    """A car as a base that turns: inputs (v, w, arm..); the steering angle follows atan(w wheel_base / v).

    A car turns only while it moves: it is given the least speed at which its steering can turn it as asked.
    """

    def __init__(self, robot: Robot, control: str, period: float, lookahead: float) -> None:
        super().__init__(robot, control, period, lookahead)
        self._wheel_base = float(robot.entry["wheel_base"])  # [m]
        steepest = float(np.abs(robot.limits.position[3]).min())
        self._steepest = TURNING_SHARE * (steepest if isfinite(steepest) else STEEPEST)
        fastest = float(robot.limits.velocity[0, 1])
        self._fastest = fastest if isfinite(fastest) else inf

    def input_map(self, q: FloatArray) -> FloatArray:
        """B with qd = B w: as a differential drive's; the steering angle is none of the inputs' business."""
        theta = float(q[2])
        columns = np.zeros((self._robot.dof, self._robot.n_actions))
        columns[:3, :2] = ((cos(theta), 0.0), (sin(theta), 0.0), (0.0, 1.0))
        columns[4:, 2:] = np.eye(self._robot.dof - 4)
        return columns

    def inputs(self, observation: Observation) -> FloatArray:
        """(v, v tan(delta) / wheel_base, arm..)."""
        w = observation["u"].copy()
        w[1] = w[0] * tan(float(observation["q"][3])) / self._wheel_base
        return w

    def command(self, action: FloatArray, observation: Observation) -> FloatArray:
        """(v or its rate, the steering angle's rate or its rate, arm..)."""
        u = observation["u"]
        delta = float(observation["q"][3])
        wanted = action if self._velocity_control else self.inputs(observation) + STEERING_HORIZON_S * action
        speed, turn = float(wanted[0]), float(wanted[1])
        least = min(abs(turn) * self._wheel_base / tan(self._steepest), self._fastest)
        if abs(speed) < least:
            speed = -least if speed < 0.0 and float(u[0]) < 0.0 else least
        aim = atan(turn * self._wheel_base / speed) if speed else 0.0
        rate = STEERING_GAIN * (min(max(aim, -self._steepest), self._steepest) - delta)
        result = action.copy()
        if self._velocity_control:
            result[:2] = speed, rate
        else:
            result[:2] = (speed - float(u[0])) / STEERING_HORIZON_S, STEERING_RATE_GAIN * (rate - float(u[1]))
        return result


# One entry per base.
ACTUATIONS: dict[str, Callable[[Robot, str, float, float], Actuation]] = {
    "fixed": Actuation,
    "holonomic": Actuation,
    "differential_drive": DifferentialDriveActuation,
    "bicycle": CarActuation,
}


def actuation_of(robot: Robot, control: str, period: float, lookahead: float) -> Actuation:
    """The actuation of a robot's base."""
    return ACTUATIONS[robot.base](robot, control, period, lookahead)
