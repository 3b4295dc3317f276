"""A robot and obstacles in a PyBullet client: placed, and asked for distances and frames.

A world is only geometry: nothing is simulated in it unless an engine steps it.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.loadable_meshes import loadable_model
from pytest_lpb.problem.spatial.mesh_files import check_mesh
from pytest_lpb.problem.spatial.reach import reach_of_joints
from pytest_lpb.problem.spatial.robot import Frame, SpatialRobot
from pytest_lpb.problem.spatial.rotations import multiply, rotate
from pytest_lpb.problem.spatial.shapes import (
    EXACT_GEOMETRIES,
    HULL_MARGIN_M,
    create_body,
    farthest_corner,
    shape_key,
)
from pytest_lpb.problem.spatial.urdf_writer import urdf_text
from pytest_lpb.problem.spatial.variants import driven_joints, one_shape_per_link, with_locked_joints

LOAD_FLAGS = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_IGNORE_VISUAL_SHAPES


@dataclass(frozen=True)
class Body:
    """A part of the robot whose distance is measured: one shape."""

    name: str  # of the robot's link
    link: int  # PyBullet's index
    margin: float  # [m] to add to distances
    radius: float  # [m] of a ball around the link's frame that holds the shape


class World:
    """One robot and any number of obstacles.

    Attributes:
        client, robot: PyBullet's client and the robot's id in it.
        planned: joints that are entries of q: (PyBullet's index, entry of q).
        followers: joints that mimic one of those: (PyBullet's index, entry of q, multiplier, offset).
        bodies: of the robot, whose distances are measured.
        reach: bounds (bodies, dof) of how far a unit of each entry of q carries a point of each body [m].
        obstacles, obstacle_margins, obstacle_radii: PyBullet's ids, [m], [m].

    Args:
        robot: what is loaded; robots of the same `urdf` and locked joints can share a world one after the other.

    Raises ScenarioError when PyBullet cannot load the robot.
    """

    def __init__(self, robot: SpatialRobot) -> None:
        self.client = Client()
        self.obstacles: list[int] = []
        self.obstacle_margins: list[float] = []
        self.obstacle_radii: list[float] = []
        self._keys: list[tuple[object, ...]] = []
        self.robot = self._load(robot)
        self._index_links(robot)

    def _load(self, robot: SpatialRobot) -> int:
        model, self._owners = one_shape_per_link(with_locked_joints(robot.urdf, robot.locked))
        self._model = model
        for link in model.links:
            for shape in link.collisions:
                if shape.file is not None:
                    check_mesh(shape.file)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "robot.urdf"
            file.write_text(urdf_text(loadable_model(model, file.parent), margin=HULL_MARGIN_M), encoding="utf-8")
            try:
                body: int = self.client.call("loadURDF", str(file), useFixedBase=True, flags=LOAD_FLAGS)
            except pybullet.error:
                self.client.close()
                raise ScenarioError(
                    f"PyBullet cannot load the robot {robot.name!r}; see whether its collision meshes are .obj, .stl "
                    "or .dae files that PyBullet reads"
                ) from None
        return body

    def _index_links(self, robot: SpatialRobot) -> None:
        call, body = self.client.call, self.robot
        links: dict[str, int] = {}
        joints: dict[str, int] = {}
        for index in range(call("getNumJoints", body)):
            information = call("getJointInfo", body, index)
            joints[information[1].decode()] = index
            links[information[12].decode()] = index
            call("changeDynamics", body, index, linearDamping=0.0, angularDamping=0.0)
        self.links = [links[name] for name in robot.link_names]
        planned, followers = driven_joints(robot)
        self.planned = [(joints[name], source) for name, source in planned]
        self.followers = [(joints[name], source, multiplier, offset) for name, source, multiplier, offset in followers]
        self._joints = [joint for joint, *_ in (*self.planned, *self.followers)]
        self.bodies = [
            Body(
                self._owners[link.name],
                links[link.name],
                0.0 if link.collisions[0].kind in EXACT_GEOMETRIES else HULL_MARGIN_M,
                farthest_corner(
                    call("getAABB", body, links[link.name]), call("getLinkState", body, links[link.name])[4]
                ),
            )
            for link in self._model.links
            if link.collisions
        ]
        self._check_bodies()
        self.reach = reach_of_joints(robot, self.bodies)

    def _check_bodies(self) -> None:
        """PyBullet loads a robot with a mesh that it cannot read, as a point. Raises ScenarioError then."""
        shapes = {link.name: link.collisions[0] for link in self._model.links if link.collisions}
        for body, shape in zip(self.bodies, shapes.values(), strict=True):
            present = self.client.call("getCollisionShapeData", self.robot, body.link)
            if present and (shape.file is None or self.client.call("getMeshData", self.robot, body.link)[0]):
                continue
            self.client.close()
            raise ScenarioError(
                f"PyBullet cannot read {shape.file or shape.kind}, the collision geometry of link {body.name!r}; "
                "meshes are .obj, .stl or .dae files of triangles"
            )

    def set_q(self, q: Sequence[float]) -> None:
        """Put the robot's joints into positions (dof,), at rest."""
        positions = [[q[source]] for _, source in self.planned]
        if self.followers:
            positions += [[multiplier * q[source] + offset] for _, source, multiplier, offset in self.followers]
        pybullet.resetJointStatesMultiDof(self.robot, self._joints, positions, physicsClientId=self.client.id)

    def frame(self, link: int) -> Frame:
        """Frame of a link, by its index in the robot's `link_names`, in the world."""
        # PyBullet rounds the frame it gives to single precision, but not the pose of the centre of mass.
        state = pybullet.getLinkState(self.robot, self.links[link], physicsClientId=self.client.id)
        position, (x, y, z, w), offset, (ix, iy, iz, iw) = state[:4]
        turn = multiply((w, x, y, z), (iw, -ix, -iy, -iz))
        dx, dy, dz = rotate(turn, offset)
        return (position[0] - dx, position[1] - dy, position[2] - dz, *turn)

    def joint_efforts(self) -> list[float]:
        """Largest forces or torques of the planned joints, as the URDF has them [N or N m]; inf or 0: none given."""
        efforts = {joint.name: joint.effort for joint in self._model.joints}
        call = self.client.call
        return [efforts[call("getJointInfo", self.robot, joint)[1].decode()] for joint, _ in self.planned]

    def overlap(self, first: str, second: str) -> bool:
        """Whether the collision geometry of two of the robot's links overlaps."""
        return any(
            point[8] + one.margin + other.margin < 0.0
            for one in self.bodies
            if one.name == first
            for other in self.bodies
            if other.name == second
            for point in self.client.call("getClosestPoints", self.robot, self.robot, 0.0, one.link, other.link)
        )

    def set_obstacles(self, obstacles: Sequence[Obstacle]) -> None:
        """Have these obstacles, at the origin; bodies that are there already are kept."""
        keys: list[tuple[object, ...]] = [shape_key(obstacle.entry) for obstacle in obstacles]
        kept = 0
        while kept < min(len(keys), len(self._keys)) and keys[kept] == self._keys[kept]:
            kept += 1
        for body in self.obstacles[kept:]:
            self.client.call("removeBody", body)
        for present in (self.obstacles, self.obstacle_margins, self.obstacle_radii, self._keys):
            del present[kept:]
        for obstacle, key in zip(obstacles[kept:], keys[kept:], strict=True):
            body, margin, radius = create_body(self.client, obstacle.entry)
            self.obstacles.append(body)
            self.obstacle_margins.append(margin)
            self.obstacle_radii.append(radius)
            self._keys.append(key)

    def place(self, index: int, position: Sequence[float], orientation: Sequence[float]) -> None:
        """Move an obstacle: position [m], orientation wxyz."""
        w, x, y, z = orientation
        pybullet.resetBasePositionAndOrientation(
            self.obstacles[index], position, (x, y, z, w), physicsClientId=self.client.id
        )

    def close(self) -> None:
        """Free the client."""
        self.client.close()
