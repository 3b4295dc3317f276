"""Rotations: quaternions wxyz as tuples of floats for the trial loop, matrices (3, 3) for kinematics."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, hypot, sin, sqrt

import numpy as np

from pytest_lpb.motion.directions import LONGEST, SHORTEST, rescaled
from pytest_lpb.problem.robot import FloatArray

Quaternion = tuple[float, float, float, float]  # w, x, y, z
Vector = tuple[float, float, float]

SMALL_ANGLE = 1e-8  # [rad] below this a rotation vector is twice the quaternion's vector part


def multiply(p: Sequence[float], q: Sequence[float]) -> Quaternion:
    """The rotation q followed by p."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    return (
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    )


def inverse(q: Sequence[float]) -> Quaternion:
    """The inverse of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q: Sequence[float], v: Sequence[float]) -> Vector:
    """A vector turned by a unit quaternion."""
    w, x, y, z = q
    vx, vy, vz = v
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return (
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


def normalised(q: Sequence[float]) -> Quaternion:
    """A quaternion of length one. Raises ZeroDivisionError for zeros."""
    w, x, y, z = q
    length = sqrt(w * w + x * x + y * y + z * z)
    if not SHORTEST < length < LONGEST:
        w, x, y, z = rescaled(q)
        length = sqrt(w * w + x * x + y * y + z * z)
    return (w / length, x / length, y / length, z / length)


def rotation_vector(q: Sequence[float]) -> Vector:
    """Axis times angle [rad], the angle in [0, pi], of a unit quaternion (its logarithm)."""
    w, x, y, z = q if q[0] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
    length = sqrt(x * x + y * y + z * z)
    factor = 2.0 if length < SMALL_ANGLE else 2.0 * atan2(length, w) / length
    return (factor * x, factor * y, factor * z)


def angle_between(p: Sequence[float], q: Sequence[float]) -> float:
    """Geodesic distance [rad] of two unit quaternions, in [0, pi]; accurate near 0 and near pi."""
    w, x, y, z = multiply(p, inverse(q))
    return 2.0 * atan2(sqrt(x * x + y * y + z * z), abs(w))


def from_axis_angle(axis: Sequence[float], angle: float) -> Quaternion:
    """The unit quaternion of a turn by `angle` [rad] about an axis of any length but zero."""
    x, y, z = axis
    length = hypot(x, y, z)
    if not SHORTEST < length < LONGEST:
        x, y, z = rescaled(axis)
        length = hypot(x, y, z)
    factor = sin(0.5 * angle) / length
    return (cos(0.5 * angle), factor * x, factor * y, factor * z)


def from_matrix(matrix: FloatArray) -> Quaternion:
    """The unit quaternion (w >= 0) of a rotation matrix (3, 3): the largest component first (Shepperd, 1978)."""
    q = quaternions_of(np.asarray(matrix)[None])[0].tolist()
    return (q[0], q[1], q[2], q[3])


def quaternions_of(matrices: FloatArray) -> FloatArray:
    """Unit quaternions (N, 4), w >= 0, of rotation matrices (N, 3, 3)."""
    m = matrices
    squares = np.stack(
        [
            1.0 + m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2],
            1.0 + m[:, 0, 0] - m[:, 1, 1] - m[:, 2, 2],
            1.0 - m[:, 0, 0] + m[:, 1, 1] - m[:, 2, 2],
            1.0 - m[:, 0, 0] - m[:, 1, 1] + m[:, 2, 2],
        ],
        axis=1,
    )  # four times each component's square
    wx, wy, wz = m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]
    xy, xz, yz = m[:, 0, 1] + m[:, 1, 0], m[:, 0, 2] + m[:, 2, 0], m[:, 1, 2] + m[:, 2, 1]
    candidates = np.stack(
        [
            np.stack([squares[:, 0], wx, wy, wz], axis=1),
            np.stack([wx, squares[:, 1], xy, xz], axis=1),
            np.stack([wy, xy, squares[:, 2], yz], axis=1),
            np.stack([wz, xz, yz, squares[:, 3]], axis=1),
        ],
        axis=1,
    )
    chosen = candidates[np.arange(len(m)), squares.argmax(axis=1)]
    chosen /= np.linalg.norm(chosen, axis=1, keepdims=True)
    signed: FloatArray = np.where(chosen[:, :1] < 0.0, -chosen, chosen)
    return signed


def matrix_of(q: Sequence[float]) -> FloatArray:
    """Rotation matrix (3, 3) of a unit quaternion."""
    w, x, y, z = q
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def matrix_of_rpy(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Rotation matrix (3, 3) of turns about the fixed axes x, y, z in this order, as URDF has them [rad]."""
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rpy_of_matrix(matrix: FloatArray) -> Vector:
    """Roll, pitch, yaw [rad] of a rotation matrix (3, 3), as `matrix_of_rpy` takes them."""
    horizontal = hypot(matrix[0, 0], matrix[1, 0])
    pitch = atan2(-matrix[2, 0], horizontal)
    if horizontal < SMALL_ANGLE:  # pitch of ±pi/2: roll and yaw turn about the same axis
        return (atan2(-matrix[1, 2], matrix[1, 1]), pitch, 0.0)
    return (atan2(matrix[2, 1], matrix[2, 2]), pitch, atan2(matrix[1, 0], matrix[0, 0]))


def turned(axis: Sequence[float] | FloatArray, angles: FloatArray) -> FloatArray:
    """Rotation matrices (N, 3, 3) of turns by angles (N,) [rad] about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result: FloatArray = (
        np.eye(3) + np.sin(angles)[:, None, None] * cross + (1.0 - np.cos(angles))[:, None, None] * (cross @ cross)
    )
    return result
