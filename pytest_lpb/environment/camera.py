"""A camera that holds given places, and pictures taken with PyBullet's software renderer: no display is needed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import cos, degrees, radians, sin, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.motion.directions import unit
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import Client, pybullet

Image = NDArray[np.uint8]  # (height, width, 3)

VIEW_ANGLE = radians(40.0)  # [rad]
NEAREST, FARTHEST = 0.02, 20.0  # of what is seen, in distances of the camera from what it looks at
CLOSEST = 0.1  # of that distance: nothing that must be seen is nearer to the eye
LIGHT_FROM = np.array([-0.5, 0.9, -1.0])  # right, up and ahead of the camera: whatever it looks at is lit
LIGHT = {
    "lightAmbientCoeff": 0.6,
    "lightDiffuseCoeff": 0.4,
    "lightSpecularCoeff": 0.0,
}


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera that stands upright.

    Attributes:
        eye, target: where it stands and looks, (3,) [m].
        width, height: of its pictures [px].
        angle: of view, from the lower to the upper edge [rad].
    """

    eye: FloatArray
    target: FloatArray
    width: int
    height: int
    angle: float = VIEW_ANGLE

    @property
    def distance(self) -> float:
        """From the eye to the target [m]."""
        return float(np.linalg.norm(self.target - self.eye))

    @cached_property
    def axes(self) -> FloatArray:
        """Unit vectors to the right, up and ahead in the world, the rows of (3, 3)."""
        ahead = unit(self.target - self.eye, np.float64(self.distance))
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right = unit(right, np.linalg.norm(right))  # straight up and down, the first axis is to the right
        return np.stack([right, np.cross(right, ahead), ahead])

    @property
    def focal_length(self) -> float:
        """[px]: size in the picture of what is as large as it is far away."""
        return 0.5 * self.height / tan(0.5 * self.angle)

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Places of points (N, 3) [m]: column and row (N, 2) [px], and depth (N,) [m], NaN behind the camera."""
        right, up, depth = self.axes @ (points - self.eye).T
        depth = np.where(depth > NEAREST * self.distance, depth, np.nan)
        columns = 0.5 * self.width + self.focal_length * right / depth
        rows = 0.5 * self.height - self.focal_length * up / depth
        return np.column_stack([columns, rows]), depth

    @cached_property
    def rays(self) -> FloatArray:
        """Directions of all pixels in the world, of length one along the camera's axis: (height, width, 3)."""
        right = (np.arange(self.width) + 0.5 - 0.5 * self.width) / self.focal_length
        up = (0.5 * self.height - np.arange(self.height) - 0.5) / self.focal_length
        x, y, ahead = self.axes
        return np.asarray(up[:, None, None] * y + right[None, :, None] * x + ahead)

    def take(self, client: Client) -> tuple[Image, FloatArray, NDArray[np.int32]]:
        """A picture (height, width, 3), depth [m] (inf where nothing is), and ids of bodies (-1 where none is)."""
        near, far = NEAREST * self.distance, FARTHEST * self.distance
        aspect = self.width / self.height
        view = pybullet.computeViewMatrix(self.eye.tolist(), self.target.tolist(), (0.0, 0.0, 1.0))
        projection = pybullet.computeProjectionMatrixFOV(degrees(self.angle), aspect, near, far)
        light = LIGHT | {"lightDirection": (LIGHT_FROM @ self.axes).tolist()}
        renderer: dict[str, Any] = {"renderer": pybullet.ER_TINY_RENDERER, **light}
        taken = client.call("getCameraImage", self.width, self.height, view, projection, **renderer)
        size = (self.height, self.width)
        colors, depths, bodies = (np.asarray(values).reshape(*size, -1) for values in taken[2:])
        depth = far * near / (far - (far - near) * depths[..., 0].astype(np.float64))
        depth[bodies[..., 0] < 0] = np.inf
        return np.ascontiguousarray(colors[..., :3], dtype=np.uint8), depth, bodies[..., 0]


def direction(azimuth: float, elevation: float) -> FloatArray:
    """Unit vector (3,) towards an azimuth from the x axis and an elevation above the ground [rad]."""
    return np.array([cos(azimuth) * cos(elevation), sin(azimuth) * cos(elevation), sin(elevation)])


def framing(points: FloatArray, towards_eye: FloatArray, size: tuple[int, int], angle: float = VIEW_ANGLE) -> Camera:
    """The nearest camera in a direction that has all points (N, 3) [m] in its picture.

    Each edge of the picture bounds the eye by the plane through the outermost point: what is left is a closed form.
    """
    width, height = size
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    axes = Camera(centre + towards_eye, centre, width, height).axes
    across, up, ahead = axes @ (points - centre).T
    slope = tan(0.5 * angle)
    shift = np.zeros(3)
    distance = -float(ahead.min()) / (1.0 - CLOSEST)
    for index, (values, edge) in enumerate(((across, slope * width / height), (up, slope))):
        highest, lowest = (values - edge * ahead).max(), (values + edge * ahead).min()
        shift[index] = 0.5 * (highest + lowest)
        distance = max(distance, 0.5 * float(highest - lowest) / edge)
    target = centre + shift @ axes
    return Camera(target + distance * towards_eye, target, width, height, angle)
