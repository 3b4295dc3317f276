"""A robot and obstacles in a PyBullet client: placed, and asked for distances and frames.

A world is only geometry: nothing is simulated in it unless an engine steps it.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.bodies import NO_LINK, Body, create_part
from pytest_lpb.problem.spatial.client import Client, pybullet
from pytest_lpb.problem.spatial.convex.cores import Core, cores_of
from pytest_lpb.problem.spatial.layout import Layout, layout_of
from pytest_lpb.problem.spatial.loadable_meshes import loadable_model
from pytest_lpb.problem.spatial.mesh_files import check_mesh
from pytest_lpb.problem.spatial.near_contact import NEAR_M, Pose, exact_distance, measured_exactly
from pytest_lpb.problem.spatial.reach import reach_of_joints
from pytest_lpb.problem.spatial.robot import Frame, SpatialRobot
from pytest_lpb.problem.spatial.rotations import from_matrix, multiply, rotate
from pytest_lpb.problem.spatial.shapes import HULL_MARGIN_M, create_body, shape_key
from pytest_lpb.problem.spatial.urdf_writer import urdf_text
from pytest_lpb.problem.spatial.variants import driven_joints

DISTANCE = 8  # index of the distance in PyBullet's contact points

LOAD_FLAGS = (
    pybullet.URDF_USE_INERTIA_FROM_FILE
    | pybullet.URDF_IGNORE_VISUAL_SHAPES
    | pybullet.URDF_USE_IMPLICIT_CYLINDER  # else cylinders are prisms of 32 sides
)


class World:
    """One robot and any number of obstacles.

    Attributes:
        client, robot: PyBullet's client and the robot's id in it.
        planned: joints that are entries of q: (PyBullet's index, entry of q).
        followers: joints that mimic one of those: (PyBullet's index, entry of q, multiplier, offset).
        bodies: of the robot, whose distances are measured.
        reach: bounds (bodies, dof) of how far a unit of each entry of q carries a point of each body [m].
        obstacles, obstacle_margins, obstacle_radii: PyBullet's ids, [m], [m].
        obstacle_cores: their convex shapes, by PyBullet's id; none of surfaces.

    Args:
        robot: what is loaded; robots of the same `urdf` and locked joints can share a world one after the other.
        simulated: whether forces will move the robot: all of its shapes are on its links then.

    Raises ScenarioError when PyBullet cannot load the robot.
    """

    def __init__(self, robot: SpatialRobot, *, simulated: bool = False) -> None:
        layout = layout_of(robot, simulated=simulated)
        self.client = Client()
        self.obstacles: list[int] = []
        self.obstacle_margins: list[float] = []
        self.obstacle_radii: list[float] = []
        self.obstacle_cores: dict[int, tuple[Core, ...]] = {}
        self._keys: list[tuple[object, ...]] = []
        self._simulated = simulated
        self._moves = 0
        self._states: dict[int, Sequence[Sequence[float]]] = {}  # of links that carry bodies, since the last move
        self._model = layout.model
        try:
            self.robot = self._load(robot)
            self._index(robot, layout)
        except ScenarioError:
            self.client.close()
            raise

    def _load(self, robot: SpatialRobot) -> int:
        files = {shape.file for link in self._model.links for shape in link.collisions if shape.file is not None}
        for mesh in sorted(files):
            check_mesh(mesh)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "robot.urdf"
            model = loadable_model(self._model, file.parent)
            file.write_text(urdf_text(model, margin=HULL_MARGIN_M), encoding="utf-8")
            try:
                body: int = self.client.call("loadURDF", str(file), useFixedBase=True, flags=LOAD_FLAGS)
            except pybullet.error:
                raise ScenarioError(
                    f"PyBullet cannot load the robot {robot.name!r}; see whether its collision meshes are .obj, .stl "
                    "or .dae files that PyBullet reads"
                ) from None
        return body

    def _index(self, robot: SpatialRobot, layout: Layout) -> None:
        call, body = self.client.call, self.robot
        links: dict[str, int] = {}
        joints: dict[str, int] = {}
        for index in range(call("getNumJoints", body)):
            information = call("getJointInfo", body, index)
            joints[information[1].decode()] = index
            links[information[12].decode()] = index
            call("changeDynamics", body, index, linearDamping=0.0, angularDamping=0.0)
        places = [layout.places[name] for name in robot.link_names]
        self._links = [
            (links[host], None if host == name else pose)
            for name, (host, pose) in zip(robot.link_names, places, strict=True)
        ]
        planned, followers = driven_joints(robot)
        self.planned = [(joints[name], source) for name, source in planned]
        self.followers = [(joints[name], source, multiplier, offset) for name, source, multiplier, offset in followers]
        self._joints = [joint for joint, *_ in (*self.planned, *self.followers)]
        if self._simulated:
            self._check_meshes(links)
        self.bodies = [create_part(self.client, body, part, links[part.host]) for part in layout.parts]
        self._carries = any(part.carrier is not None for part in self.bodies)
        for part in self.bodies:
            if self._simulated and part.carrier is not None:
                call("setCollisionFilterGroupMask", part.id, NO_LINK, 0, 0)  # measured, but in nobody's way
        self.reach = reach_of_joints(robot, self.bodies)

    def _check_meshes(self, links: Mapping[str, int]) -> None:
        """PyBullet loads a robot with a mesh that it cannot read, as a point. Raises ScenarioError then."""
        for link in self._model.links:
            for shape in link.collisions:
                if shape.file is not None and not self.client.call("getMeshData", self.robot, links[link.name])[0]:
                    raise ScenarioError(
                        f"PyBullet cannot read {shape.file}, the collision geometry of link {link.name!r}; "
                        "meshes are .obj, .stl or .dae files of triangles"
                    )

    def set_q(self, q: Sequence[float]) -> None:
        """Put the robot's joints into positions (dof,), at rest."""
        positions = [[q[source]] for _, source in self.planned]
        if self.followers:
            positions += [[multiplier * q[source] + offset] for _, source, multiplier, offset in self.followers]
        pybullet.resetJointStatesMultiDof(self.robot, self._joints, positions, physicsClientId=self.client.id)
        if self._carries:
            self.moved()

    def moved(self) -> None:
        """The robot is somewhere else: bodies of their own have to follow before they are measured."""
        self._moves += 1
        self._states.clear()

    def bring(self, body: Body) -> None:
        """Put a body of its own where the link that carries it is."""
        if body.carrier is None or body.move == self._moves:
            return
        state = self._states.get(body.carrier)
        if state is None:
            state = pybullet.getLinkState(self.robot, body.carrier, physicsClientId=self.client.id)
            self._states[body.carrier] = state
        pybullet.resetBasePositionAndOrientation(body.id, state[0], state[1], physicsClientId=self.client.id)
        body.move = self._moves

    def frame(self, link: int) -> Frame:
        """Frame of a link, by its index in the robot's `link_names`, in the world."""
        # PyBullet rounds the frame it gives to single precision, but not the pose of the centre of mass.
        index, pose = self._links[link]
        state = pybullet.getLinkState(self.robot, index, physicsClientId=self.client.id)
        position, (x, y, z, w), offset, (ix, iy, iz, iw) = state[:4]
        turn = multiply((w, x, y, z), (iw, -ix, -iy, -iz))
        dx, dy, dz = rotate(turn, offset)
        frame = (position[0] - dx, position[1] - dy, position[2] - dz, *turn)
        return frame if pose is None else _placed(pose, frame)

    def joint_efforts(self) -> list[float]:
        """Largest forces or torques of the planned joints, as the URDF has them [N or N m]; inf or 0: none given."""
        efforts = {joint.name: joint.effort for joint in self._model.joints}
        call = self.client.call
        return [efforts[call("getJointInfo", self.robot, joint)[1].decode()] for joint, _ in self.planned]

    def overlap(self, first: str, second: str) -> bool:
        """Whether the collision geometry of two of the robot's links overlaps."""
        return any(
            self._overlap(one, other)
            for one in self.bodies
            if one.name == first
            for other in self.bodies
            if other.name == second
        )

    def _overlap(self, one: Body, other: Body) -> bool:
        self.bring(one)
        self.bring(other)
        points = self.client.call("getClosestPoints", one.id, other.id, NEAR_M, one.link, other.link)
        if not points:
            return False
        distance: float = min(point[DISTANCE] for point in points) + one.margin + other.margin
        return (distance if distance < -NEAR_M else self.exact_distance(one, other, distance)) < 0.0

    def exact_distance(self, one: Body, other: Body | int, measured: float) -> float:
        """Signed distance [m] of a body of the robot from another one, or from an obstacle by PyBullet's id.

        It is what Bullet has `measured` where that is exact.
        """
        cores = self.obstacle_cores[other] if isinstance(other, int) else other.cores
        if measured_exactly(one.cores, cores):
            return measured
        return exact_distance(one.cores, cores, (self._pose(one), self._pose(other)))

    def _pose(self, body: Body | int) -> Pose:
        """Where the frame of a body's cores is."""
        if isinstance(body, int):
            pose: Pose = pybullet.getBasePositionAndOrientation(body, physicsClientId=self.client.id)
            return pose
        link = body.link if body.carrier is None else body.carrier
        state = pybullet.getLinkState(self.robot, link, physicsClientId=self.client.id)
        return state[0], state[1]

    def set_obstacles(self, obstacles: Sequence[Obstacle]) -> None:
        """Have these obstacles, at the origin; bodies that are there already are kept."""
        keys: list[tuple[object, ...]] = [shape_key(obstacle.entry) for obstacle in obstacles]
        kept = 0
        while kept < min(len(keys), len(self._keys)) and keys[kept] == self._keys[kept]:
            kept += 1
        for body in self.obstacles[kept:]:
            self.client.call("removeBody", body)
            del self.obstacle_cores[body]
        for present in (self.obstacles, self.obstacle_margins, self.obstacle_radii, self._keys):
            del present[kept:]
        for obstacle, key in zip(obstacles[kept:], keys[kept:], strict=True):
            body, margin, radius = create_body(self.client, obstacle.entry)
            self.obstacles.append(body)
            self.obstacle_margins.append(margin)
            self.obstacle_radii.append(radius)
            self.obstacle_cores[body] = cores_of(obstacle.entry)
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


def _placed(pose: FloatArray, frame: Frame) -> Frame:
    """The frame of a pose (4, 4) in a frame."""
    x, y, z, *turn = frame
    dx, dy, dz = rotate(turn, pose[:3, 3].tolist())
    return (x + dx, y + dy, z + dz, *multiply(turn, from_matrix(pose[:3, :3])))
