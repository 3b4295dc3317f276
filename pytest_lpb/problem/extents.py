"""How large obstacles are, whatever their shape: a box around each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pytest_lpb.problem.obstacle import Obstacle


def _of_mesh(obstacle: Any) -> tuple[float, ...]:
    from pytest_lpb.problem.spatial.meshes import mesh_vertices  # imports PyBullet

    x, y, z = (2.0 * abs(mesh_vertices(Path(obstacle.file), (obstacle.scale,) * 3)).max(axis=0)).tolist()
    return (x, y, z)


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
    return _EXTENTS[obstacle.shape](obstacle)
