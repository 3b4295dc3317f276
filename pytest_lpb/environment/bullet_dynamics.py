"""Simulated forces: motors follow velocities, or torques drive the joints, under gravity and contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite

import numpy as np

from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import pybullet
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.swept_bodies import polyline, polyline_rates
from pytest_lpb.problem.spatial.world import World

UNLIMITED_EFFORT = 1e5  # [N or N m] of a motor without a limit
MAX_LAG = 0.5  # [rad/s or m/s] by which motors may trail what was commanded before the command starts from them anew


class DynamicMotion:
    """Steps PyBullet's physics in `substeps` per step of the problem.

    Velocity and acceleration control set the targets of velocity motors, as strong as the robot's effort limits allow;
    under acceleration control the target is the velocity that all accelerations so far lead to. Under torque control
    the motors are off. A non-holonomic base is driven along the directions it can move in. Entries of q that move no
    joint, such as the steering angle of a car without steering joints, follow their commands exactly.
    """

    def __init__(self, problem: Problem, robot: SpatialRobot, world: World) -> None:
        self._robot = robot
        self._world = world
        self._client = world.client.id
        self._duration = problem.dt  # [s]
        self._substeps = problem.substeps
        self._dt = problem.dt / problem.substeps  # [s]
        self._gravity = problem.gravity  # [m/s^2]
        self._joints = [joint for joint, _ in world.planned]
        self._sources = [source for _, source in world.planned]
        self._loose = sorted(set(range(robot.dof)) - set(self._sources))
        efforts = world.joint_efforts()
        self._strengths = [effort if isfinite(effort) and effort > 0.0 else UNLIMITED_EFFORT for effort in efforts]
        self._drive = {
            "velocity": self._by_velocity,
            "acceleration": self._by_acceleration,
            "torque": self._by_torque,
        }[robot.control]

    def start(self, q: list[float], u: list[float]) -> tuple[list[float], list[float]]:
        """Put the robot into a state."""
        call = self._world.client.call
        # Each reset sets them again: PyBullet forgets gravity with some of them.
        call("setGravity", *self._gravity)
        call("setTimeStep", self._dt)
        velocity = self._robot.joint_velocity(q, u)
        self._world.set_q(q)
        for joint, source in self._world.planned:
            call("resetJointState", self._world.robot, joint, q[source], velocity[source])
        self._motors(velocity, strengths=[0.0] * len(self._joints) if self._robot.control == "torque" else None)
        self._q = list(q)
        self._commanded = list(u)
        self._paths: list[FloatArray] = []  # of the steps since: configurations (substeps + 1, dof)
        return q, u

    def advance(self, q: list[float], u: list[float], action: list[float]) -> tuple[list[float], list[float]]:
        """State after dt, as the physics has it."""
        self._q = list(q)
        self._passed = [self._q]
        self._drive(u, action)
        # A step leaves the links' frames where they were before it, until somebody asks for them to be computed.
        self._world.client.call("getLinkState", self._world.robot, 0, computeForwardKinematics=True)
        self._world.moved()
        position, velocity = self._measured()
        u = self._actuated(position, velocity, q, u, action)
        self._keep_path(position)
        return position, u

    def _keep_path(self, last: list[float]) -> None:
        """Keep where this step went, by substeps; entries of q that move no joint are as they are in the end."""
        path = np.array(self._passed)
        path[-1] = last
        self._paths.append(path)

    def rates(self, row: int, before: list[float], q: list[float], u: list[float]) -> list[float]:  # noqa: ARG002
        """Bounds of the rates of q on the way to a row, of straight lines between substeps."""
        rates: list[float] = polyline_rates(self._paths[row - 1], self._duration).tolist()
        return rates

    def path(self, row: int, q: list[float], u: list[float], action: list[float]) -> Callable[[float], Sequence[float]]:  # noqa: ARG002
        """Straight lines between substeps."""
        return polyline(self._paths[row - 1])

    def _by_velocity(self, u: list[float], action: list[float]) -> None:  # noqa: ARG002 - motors know no past
        for _ in range(self._substeps):
            self._motors(self._robot.joint_velocity(self._q, action))
            self._step()

    def _by_acceleration(self, u: list[float], action: list[float]) -> None:
        start = [c if abs(c - v) < MAX_LAG else v for c, v in zip(self._commanded, u, strict=True)]
        target = start
        for substep in range(1, self._substeps + 1):
            elapsed = substep * self._dt
            target = [v + a * elapsed for v, a in zip(start, action, strict=True)]
            self._motors(self._robot.joint_velocity(self._q, target))
            self._step()
        self._commanded = target

    def _by_torque(self, u: list[float], action: list[float]) -> None:  # noqa: ARG002 - as above
        for _ in range(self._substeps):
            # PyBullet forgets torques after each step.
            pybullet.setJointMotorControlArray(
                self._world.robot,
                self._joints,
                pybullet.TORQUE_CONTROL,
                forces=[action[source] for source in self._sources],
                physicsClientId=self._client,
            )
            self._step()

    def _motors(self, velocity: list[float], strengths: list[float] | None = None) -> None:
        pybullet.setJointMotorControlArray(
            self._world.robot,
            self._joints,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=[velocity[source] for source in self._sources],
            forces=strengths or self._strengths,
            physicsClientId=self._client,
        )

    def _step(self) -> None:
        for joint, source, multiplier, offset in self._world.followers:
            self._world.client.call("resetJointState", self._world.robot, joint, multiplier * self._q[source] + offset)
        pybullet.stepSimulation(physicsClientId=self._client)
        self._q, _ = self._measured()
        self._passed.append(self._q)

    def _measured(self) -> tuple[list[float], list[float]]:
        """Joint positions and velocities (dof,); entries without a joint as they were, and zero."""
        states = pybullet.getJointStates(self._world.robot, self._joints, physicsClientId=self._client)
        position, velocity = list(self._q), [0.0] * self._robot.dof
        for source, state in zip(self._sources, states, strict=True):
            position[source], velocity[source] = state[0], state[1]
        return position, velocity

    def _actuated(
        self, position: list[float], velocity: list[float], q: list[float], u: list[float], action: list[float]
    ) -> list[float]:
        """u with B u nearest to qd (the columns of B are orthogonal); commanded where no joint moves."""
        if self._loose:
            ideal, ideal_u = self._robot.integrate(q, u, action, self._duration)
            rates = self._robot.joint_velocity(ideal, ideal_u)
            for index in self._loose:
                position[index], velocity[index] = ideal[index], rates[index]
        if not self._robot.non_holonomic:
            return velocity
        columns = self._robot.action_map(position)
        actuated: list[float] = (columns.T @ np.array(velocity) / (columns * columns).sum(axis=0)).tolist()
        return actuated

    def release(self) -> None:
        """Close the world: its physics has a history."""
        self._world.close()
