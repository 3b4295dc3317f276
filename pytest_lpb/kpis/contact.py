"""Round bodies of robots, and when they meet round obstacles: discs in the plane, balls and cylinders in space."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pytest_lpb.kpis.derived import measured, norms
from pytest_lpb.trajectory import FloatArray, Trajectory

AT_REST = 1e-9  # [m/s] closing speeds up to this are rounding errors, not an approach
UPRIGHT = 1e-9  # by how much the cosine of an upright axis may differ from one

# Joints of bases that carry nothing: a robot with other revolute joints is neither point nor base.
BASES = (("x", "y", "theta"), ("x", "y", "theta", "delta"))


@dataclass(frozen=True)
class RoundBody:
    """The only body of a point or base, along a trial.

    Attributes:
        position: of its centre in the world, (N + 1, 2 or 3) [m].
        velocity: of its centre, (N + 1, 2 or 3) [m/s].
        radius: [m].
        half_height: of an upright cylinder [m]; None: a disc or a ball.
    """

    position: FloatArray
    velocity: FloatArray
    radius: float
    half_height: float | None = None

    def times_to(self, position: FloatArray, velocity: FloatArray, radius: float) -> FloatArray:
        """Time to contact with a disc or ball at each row's velocities, (N + 1,) [s]; NaN where there is none.

        A cylinder meets the section of the ball that its nearest height cuts out in that row.

        Args:
            position: of the centre, (N + 1, 2 or 3) [m].
            velocity: (N + 1, 2 or 3) [m/s].
            radius: [m].
        """
        offset, relative = measured(position - self.position), measured(velocity - self.velocity)
        if self.half_height is None:
            return time_to_contact(offset, relative, self.radius + radius)
        beyond = np.maximum(np.abs(offset[:, 2]) - self.half_height, 0.0)
        section = np.sqrt(np.maximum(radius * radius - beyond * beyond, 0.0))
        times = time_to_contact(offset[:, :2], relative[:, :2], self.radius + section)
        return np.where(beyond <= radius, times, np.nan)


def round_body(trajectory: Trajectory) -> RoundBody | None:
    """The body of a point or base; None for robots that are not, and for bodies that are not round."""
    return _BODIES[trajectory.problem.dimension](trajectory)


def _disc(trajectory: Trajectory) -> RoundBody | None:
    robot = trajectory.problem.robot
    if robot.model != "point" and robot.base == "fixed":
        return None
    return RoundBody(trajectory.q[:, :2], trajectory.qd[:, :2], robot.body_radius)


def _ball_or_cylinder(trajectory: Trajectory) -> RoundBody | None:
    robot: Any = trajectory.problem.robot  # one in space has a URDF model
    on_base = robot.base != "fixed" and robot.joint_names in BASES
    shapes = [(link.name, shape) for link in robot.urdf.links for shape in link.collisions]
    if len(shapes) != 1 or not (on_base or "revolute" not in robot.joint_types):
        return None
    ((link, shape),) = shapes
    axis = (robot.forward_kinematics(np.zeros(robot.dof), link) @ shape.origin)[2, 2]  # neither kind tilts its body
    if shape.kind not in _HALF_HEIGHTS or (shape.kind == "cylinder" and abs(abs(axis) - 1.0) > UPRIGHT):
        return None
    q, qd = measured(trajectory.q), measured(trajectory.qd)
    centre = (robot.link_frames_along(q)[:, robot.link_index(link)] @ shape.origin)[:, :3, 3]
    velocity = _carried(q, qd, centre) if on_base else qd @ robot.jacobian(np.zeros(robot.dof), link)[:3].T
    return RoundBody(centre, velocity, shape.size[0], _HALF_HEIGHTS[shape.kind](shape.size))


def _carried(q: FloatArray, qd: FloatArray, centre: FloatArray) -> FloatArray:
    """Velocities (N, 3) [m/s] of points `centre` (N, 3) [m] of bases that move by q = (x, y, theta, ..)."""
    velocity = np.zeros_like(centre)
    velocity[:, 0] = qd[:, 0] - qd[:, 2] * (centre[:, 1] - q[:, 1])
    velocity[:, 1] = qd[:, 1] + qd[:, 2] * (centre[:, 0] - q[:, 0])
    return velocity


_BODIES: dict[int, Callable[[Trajectory], RoundBody | None]] = {2: _disc, 3: _ball_or_cylinder}

# Round kinds of collision geometry, and half their height [m] by their size; None: a ball.
_HALF_HEIGHTS: dict[str, Callable[[tuple[float, ...]], float | None]] = {
    "sphere": lambda _: None,
    "cylinder": lambda size: 0.5 * size[1],
}


def time_to_contact(offset: FloatArray, velocity: FloatArray, radius: float | FloatArray) -> FloatArray:
    """Smallest t >= 0 with |offset + velocity t| <= radius, for each row; NaN where there is none.

    Args:
        offset: centre of one disc or ball seen from the other's, (N, m) [m].
        velocity: of the one relative to the other, (N, m) [m/s].
        radius: sum of both radii, one for all rows or (N,) [m].

    Returns:
        Times, (N,) [s]; 0 where they touch or overlap.
    """
    gap = np.einsum("ij,ij->i", offset, offset) - radius * radius
    closing = -np.einsum("ij,ij->i", offset, velocity)
    discriminant = closing * closing - np.einsum("ij,ij->i", velocity, velocity) * gap
    times = np.full(len(offset), np.nan)
    meets = (gap > 0.0) & (closing > AT_REST * norms(offset)) & (discriminant >= 0.0)
    # The smaller root as gap / (closing + root): no cancellation when they are slow or far apart.
    times[meets] = gap[meets] / (closing[meets] + np.sqrt(discriminant[meets]))
    times[gap <= 0.0] = 0.0
    return times
