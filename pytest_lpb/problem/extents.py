"""How large obstacles are, whatever their shape: a box around each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.planar.shapes import outline_of, planar_shape
from pytest_lpb.problem.registries import registered_vertices
from pytest_lpb.problem.robot import FloatArray


def _of_mesh(obstacle: Any) -> tuple[float, ...]:
    from pytest_lpb.problem.spatial.meshes import mesh_vertices  # imports PyBullet

    return _around(mesh_vertices(Path(obstacle.file), (obstacle.scale,) * 3))


_EXTENTS: dict[str, Callable[[Any], tuple[float, ...]]] = {
    "circle": lambda obstacle: (2.0 * obstacle.radius,) * 2,
    "rectangle": lambda obstacle: obstacle.size,
    "sphere": lambda obstacle: (2.0 * obstacle.radius,) * 3,
    "box": lambda obstacle: obstacle.size,
    "cylinder": lambda obstacle: (2.0 * obstacle.radius, 2.0 * obstacle.radius, obstacle.length),
    "capsule": lambda obstacle: (*(2.0 * obstacle.radius,) * 2, obstacle.length + 2.0 * obstacle.radius),
    "mesh": _of_mesh,
}


def extents_of(obstacle: Obstacle) -> tuple[float, ...]:
    """Full side lengths (2 or 3) [m] of the smallest box that holds an obstacle, centred at its position, and turned
    as it is.

    Raises ScenarioError for a mesh that cannot be read.
    """
    known = _EXTENTS.get(obstacle.shape)
    if known is not None:
        return known(obstacle)
    if obstacle.motion.size == 3:
        return _around(registered_vertices(obstacle.entry))
    outline = outline_of(planar_shape(obstacle.entry))
    return (2.0 * outline,) * 2 if isinstance(outline, float) else _around(np.array(outline))


def _around(points: FloatArray) -> tuple[float, ...]:
    return tuple((2.0 * abs(points).max(axis=0)).tolist())
