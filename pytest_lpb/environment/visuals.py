"""The bodies of a spatial problem as PyBullet shows them: shapes to look at, without any contact.

Every shape is a body of its own, placed by our own kinematics: nothing here can differ from what a trial recorded.
Round shapes are meshes made here, since PyBullet's own are coarse, and its capsules have pointed ends.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.loadable_meshes import loadable
from pytest_lpb.problem.spatial.mesh_files import check_mesh, is_sound
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.rotations import quaternions_of
from pytest_lpb.problem.spatial.solids import geometry_of
from pytest_lpb.problem.spatial.urdf import Geometry

AROUND = 28  # corners of a round shape
ARC = 8  # steps from a pole to the equator
Color = tuple[float, float, float, float]
ROBOT: Color = (0.0, 0.447, 0.698, 1.0)  # of collision shapes that stand in for a link without visuals
OBSTACLE: Color = (0.5, 0.5, 0.5, 1.0)

# Of the outline that is turned about z: radius, height, and the surface's normal outwards and up.
Profile = list[tuple[float, float, float, float]]


def _turned(profile: Profile) -> dict[str, Any]:
    """Keywords of a mesh made by turning an outline about z, from its lower end to its upper."""
    outline = np.array(profile)
    angles = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles), np.ones(AROUND)])
    vertices = (outline[:, None, [0, 0, 1]] * circle).reshape(-1, 3)
    normals = (outline[:, None, [2, 2, 3]] * circle).reshape(-1, 3)
    here = np.arange(len(profile) - 1)[:, None] * AROUND + np.arange(AROUND)
    beside = here - np.arange(AROUND) + (np.arange(AROUND) + 1) % AROUND
    triangles = [here, beside, here + AROUND, beside, beside + AROUND, here + AROUND]
    return {
        "shapeType": pybullet.GEOM_MESH,
        "vertices": vertices.tolist(),
        "normals": normals.tolist(),
        "indices": np.stack(triangles, axis=-1).ravel().tolist(),
    }


def _cap(radius: float, height: float, upwards: float) -> Profile:
    """A quarter of a circle around (0, height), from its lower to its upper end."""
    angles = np.linspace(0.0, 0.5 * np.pi, ARC + 1) - (0.0 if upwards > 0 else 0.5 * np.pi)
    return [(radius * c, height + radius * s, c, s) for c, s in zip(np.cos(angles), np.sin(angles), strict=True)]


def _capsule(shape: Geometry) -> dict[str, Any]:
    radius, length = shape.size
    return _turned(_cap(radius, -0.5 * length, -1.0) + _cap(radius, 0.5 * length, 1.0))


def _cylinder(shape: Geometry) -> dict[str, Any]:
    radius, half = shape.size[0], 0.5 * shape.size[1]
    bottom: Profile = [(0.0, -half, 0.0, -1.0), (radius, -half, 0.0, -1.0)]
    wall: Profile = [(radius, -half, 1.0, 0.0), (radius, half, 1.0, 0.0)]
    top: Profile = [(radius, half, 0.0, 1.0), (0.0, half, 0.0, 1.0)]
    return _turned(bottom + wall + top)


def _sphere(shape: Geometry) -> dict[str, Any]:
    return _capsule(Geometry("capsule", (shape.size[0], 0.0)))


def _box(shape: Geometry) -> dict[str, Any]:
    return {"shapeType": pybullet.GEOM_BOX, "halfExtents": [0.5 * length for length in shape.size]}


def _mesh(shape: Geometry) -> dict[str, Any]:
    assert shape.file is not None
    check_mesh(shape.file)
    return {"shapeType": pybullet.GEOM_MESH, "fileName": shape.file, "meshScale": list(shape.size)}


_VISUALS: dict[str, Callable[[Geometry], dict[str, Any]]] = {
    "box": _box,
    "sphere": _sphere,
    "cylinder": _cylinder,
    "capsule": _capsule,
    "mesh": _mesh,
}


def add_body(client: Client, shape: Geometry, color: Color | None) -> int:
    """A body to look at: PyBullet's id. Without a colour it has that of its mesh's file."""
    keywords = _VISUALS[shape.kind](shape) | ({} if color is None else {"rgbaColor": color})
    with tempfile.TemporaryDirectory() as folder:
        if "fileName" in keywords:
            keywords["fileName"] = str(loadable(keywords["fileName"], Path(folder)))
        visual = client.call("createVisualShape", **keywords)
    body: int = client.call("createMultiBody", baseMass=0, baseVisualShapeIndex=visual)
    return body


def put_body(client: Client, body: int, position: Sequence[float], turn: Sequence[float]) -> None:
    """Place a body at a position [m] with an orientation wxyz."""
    w, x, y, z = turn
    client.call("resetBasePositionAndOrientation", body, position, (x, y, z, w))


class VisibleBodies:
    """A robot and obstacles in a client, to be looked at.

    Args:
        client: where they are made; nothing else is in it.
        problem: a spatial problem.
    """

    def __init__(self, client: Client, problem: Problem) -> None:
        assert isinstance(problem.robot, SpatialRobot), f"{problem.robot.name} is no spatial robot"
        self._client = client
        self._problem = problem
        shapes = list(_shapes_of(problem.robot))
        self.robot_ids = [add_body(client, shape, color) for _, shape, color in shapes]
        self._links = [link for link, *_ in shapes]
        self._origins = np.array([shape.origin for _, shape, _ in shapes]).reshape(-1, 4, 4)
        self._obstacles = [add_body(client, geometry_of(obstacle), OBSTACLE) for obstacle in problem.obstacles]

    def place(self, t: float, frames: FloatArray) -> None:
        """Show the robot with its links at poses (links, 4, 4), and the obstacles as they are at a time [s]."""
        poses = frames[self._links] @ self._origins
        turns = quaternions_of(poses[:, :3, :3]).tolist()
        for body, position, turn in zip(self.robot_ids, poses[:, :3, 3].tolist(), turns, strict=True):
            put_body(self._client, body, position, turn)
        times = np.array([t])
        for body, obstacle in zip(self._obstacles, self._problem.obstacles, strict=True):
            position, turn = (values[0].tolist() for values in obstacle.poses(times))
            put_body(self._client, body, position, turn)


def _shapes_of(robot: SpatialRobot) -> Iterator[tuple[int, Geometry, Color | None]]:
    """What is seen of a robot: index of the link, shape, and its colour where the file of a mesh does not say it."""
    for index, name in enumerate(robot.link_names):
        link = robot.urdf.link(name)
        visuals = [shape for shape in link.visuals if shape.file is None or is_sound(shape.file)]
        color = None if visuals else ROBOT
        for shape in visuals or link.collisions:
            yield index, shape, shape.color or color
