"""Maps from the configuration to task spaces, differentiated: values, velocities, Jacobians, curvature terms."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi

from pytest_lpb.problem.robot import Robot
from pytest_lpb.symbolic.kinematics import Frames, input_map


@dataclass(frozen=True)
class Mapped:
    """A map x(q, t) from the configuration to a task space of m entries, where the state is now.

    With w the inputs (n,): x' = `velocity`, x'' = `jacobian` w' + `curvature` + `drift`.
    """

    value: Any  # (m, 1)
    velocity: Any  # (m, 1), that of references included
    jacobian: Any  # (m, n) per input
    curvature: Any  # (m, 1): of x'' what depends on velocities
    drift: Any  # (m, 1): of x'' what comes from accelerations of references

    def rows(self, rows: slice) -> Mapped:
        """Some of the entries."""
        return Mapped(
            self.value[rows],
            self.velocity[rows],
            self.jacobian[rows, :],
            self.curvature[rows],
            self.drift[rows],
        )


@dataclass(frozen=True)
class Reference:
    """Something that moves by itself, a target or an obstacle: symbols of its place, velocity and acceleration."""

    value: Any  # (r, 1)
    velocity: Any
    acceleration: Any


class State:
    """The symbolic state of a robot: q (dof,), inputs w (n,), with qd = B(q) w.

    For non-holonomic bases this is what non-holonomic fabrics are: every Jacobian is multiplied by B, and B' w is part
    of the curvature term (Spahn et al., arXiv:2205.08454, section V).
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.q = casadi.SX.sym("q", robot.dof)
        self.inputs = casadi.SX.sym("w", robot.n_actions)
        self.frames = Frames(robot, self.q)
        self._columns = input_map(robot, self.q)
        self.qd = self._columns @ self.inputs

    @property
    def size(self) -> int:
        """Number of inputs."""
        return int(self.inputs.numel())

    def mapped(self, value: Any, reference: Reference | None = None) -> Mapped:
        """A map of q, (m, 1), differentiated; `reference` is what moves besides the robot."""
        mapped = derivatives(value, (self.q, self.qd), reference)
        return replace(mapped, jacobian=mapped.jacobian @ self._columns)


def derivatives(value: Any, moving: tuple[Any, Any], reference: Reference | None = None) -> Mapped:
    """A map, differentiated: an expression (m, 1) in symbols whose velocities are given, and in a reference's value.

    Args:
        value: the expression.
        moving: symbols (k, 1) and expressions of their velocities; the Jacobian is by these symbols.
        reference: what else moves.
    """

    def rate(expression: Any) -> Any:
        own = casadi.jtimes(expression, *moving)
        return own if reference is None else own + casadi.jtimes(expression, reference.value, reference.velocity)

    velocity = rate(value)
    drift = casadi.SX.zeros(value.numel(), 1)
    if reference is not None:
        drift = casadi.jtimes(value, reference.value, reference.acceleration)
    return Mapped(value, velocity, casadi.jacobian(value, moving[0]), rate(velocity), drift)
