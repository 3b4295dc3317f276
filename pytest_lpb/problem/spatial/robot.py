"""Robots in space: URDF robots, fixed or on a moving base. Poses are in the world frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pytest_lpb.errors import LpbError
from pytest_lpb.problem.hashing import canonical_json
from pytest_lpb.problem.planar.robot import integrate_holonomic
from pytest_lpb.problem.robot import CollisionBody, FloatArray, Robot
from pytest_lpb.problem.spatial.assets import assets_digest
from pytest_lpb.problem.spatial.base import BASES
from pytest_lpb.problem.spatial.composition import composed, model_of
from pytest_lpb.problem.spatial.groups import RigidGroups
from pytest_lpb.problem.spatial.rotations import quaternions_of
from pytest_lpb.problem.spatial.urdf import Joint

if TYPE_CHECKING:
    from pytest_lpb.problem.collision import CollisionSpace
    from pytest_lpb.problem.obstacle import Obstacle

Frame = tuple[float, float, float, float, float, float, float]  # x, y, z [m], quaternion w, x, y, z

STEERING = 3  # index in q of the steering angle of a base that has one

Pairs = tuple[tuple[str, str], ...]
_default_pairs: dict[str, tuple[Pairs, Pairs]] = {}  # by robot: pairs checked, pairs left out


class SpatialRobot(Robot):
    """A robot of a URDF file, of a known name, or generated, on one of the bases.

    Attributes (besides those of `Robot`):
        urdf: links and joints of the whole robot, its base's included; the root is the world.
        tree: kinematics of all these links.
        locked: positions of joints that could move but are not planned [rad or m].
        moving_base: the base's part of motion.
    """

    dimension: ClassVar[int] = 3

    def __init__(self, entry: Mapping[str, Any]) -> None:
        self._composition = composed(entry)
        self.urdf = self._composition.urdf
        self.tree = self._composition.tree
        self.locked: Mapping[str, float] = entry["locked_joints"]
        self.moving_base = BASES[entry["base"]](entry["control"], float(entry.get("wheel_base") or 0.0))
        self._base_joints = len(self.moving_base.joints)
        self._base_actions = len(self.moving_base.actions)
        super().__init__(entry)
        self.base_pose = self._composition.base_pose
        self.urdf_path = None if self.urdf.path is None else str(self.urdf.path)
        self._rows = np.array(self._composition.link_rows, dtype=np.intp)

    def _joints(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        return self._composition.joints, self._composition.kinds

    def _links(self) -> tuple[str, ...]:
        return self._composition.links

    def _count_actions(self) -> int:
        return self._base_actions + self.dof - self._base_joints

    @property
    def action_kinds(self) -> tuple[str, ...]:
        """What each entry of u is the rate of: prismatic [m] or revolute [rad]."""
        return (*self.moving_base.action_kinds, *self.joint_types[self._base_joints :])

    @property
    def action_names(self) -> tuple[str, ...]:
        """What each entry of u moves: what the base is steered by, then joints."""
        return (*self.moving_base.actions, *self.joint_names[self._base_joints :])

    @property
    def headings(self) -> tuple[int, ...]:
        """Index in q of the heading of a moving base."""
        return (2,) if self._base_joints else ()

    @cached_property
    def reach(self) -> float:
        """Bound of the distance of a link's frame from the robot's root [m]; inf for a robot that moves about."""
        length = {self.urdf.root: 0.0}
        for joint in self.urdf.joints:
            fixed = joint.name == "lpb_mount"
            slide = self.farthest(joint) if joint.kind == "prismatic" else 0.0
            step = 0.0 if fixed else float(np.linalg.norm(joint.origin[:3, 3]))
            length[joint.child] = length[joint.parent] + step + slide
        return max(length[name] for name in self.link_names)

    def farthest(self, joint: Joint) -> float:
        """Largest distance from zero [rad or m] of a joint of `urdf` within the limits of the planned joints."""
        source, multiplier, offset = joint.mimic or (joint.name, 1.0, 0.0)
        if multiplier == 0.0 or source not in self.joint_names:
            return abs(multiplier * self.locked.get(source, 0.0) + offset)
        lower, upper = self.limits.position[self.joint_names.index(source)].tolist()
        return float(max(abs(multiplier * lower + offset), abs(multiplier * upper + offset)))

    def forward_kinematics(self, q: ArrayLike, link: str) -> FloatArray:
        """Pose of a link's frame in the world at q (dof,): (4, 4). Raises ValueError: unknown link."""
        return self.tree.frame(np.asarray(q, dtype=float), self._composition.link_rows[self.link_index(link)])

    def jacobian(self, q: ArrayLike, link: str) -> FloatArray:
        """Velocity of a link's frame per qd, (6, dof); linear rows first, world axes."""
        return self.frame_and_jacobian(q, link)[1]

    def frame_and_jacobian(self, q: ArrayLike, link: str) -> tuple[FloatArray, FloatArray]:
        """Pose (4, 4) and Jacobian (6, dof) of a link's frame, for the price of one."""
        row = self._composition.link_rows[self.link_index(link)]
        return self.tree.frame_and_jacobian(np.asarray(q, dtype=float), row)

    def link_frames(self, q: ArrayLike) -> FloatArray:
        """Poses of all links at q (dof,): (links, 4, 4), in the order of `link_names`."""
        frames: FloatArray = self.link_frames_along(np.asarray(q, dtype=float)[None])[0]
        return frames

    def link_frames_along(self, q: FloatArray) -> FloatArray:
        """Poses of all links along a trajectory q (N, dof): (N, links, 4, 4)."""
        return self.tree.frames_along(q)[:, self._rows]

    def frames_and_jacobians(self, q: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Poses (links, 4, 4) and Jacobians (links, 6, dof) of all links at q (dof,)."""
        frames = self.tree.frames_along(np.asarray(q, dtype=float)[None])[0]
        return frames[self._rows], self.tree.jacobians(frames)[self._rows]

    def link_positions(self, q: FloatArray) -> FloatArray:
        """Positions of all link frames along a trajectory q (N, dof): (N, links, 3) [m]."""
        return self.link_frames_along(q)[:, :, :3, 3]

    def frames(self, q: Sequence[float]) -> Sequence[tuple[float, ...]]:
        """Frames (x, y, z, quaternion wxyz) of all links at q."""
        return self.frames_of(np.array(q, dtype=float)[None])[0]

    def frames_of(self, configurations: FloatArray) -> list[Sequence[tuple[float, ...]]]:
        """Frames as `frames` gives them, at each of several q (N, dof)."""
        poses = self.link_frames_along(configurations)
        count, links = poses.shape[:2]
        turns = quaternions_of(poses[:, :, :3, :3].reshape(-1, 3, 3)).reshape(count, links, 4)
        rows = np.concatenate([poses[:, :, :3, 3], turns], axis=2).tolist()
        return [[tuple(frame) for frame in row] for row in rows]

    def action_map(self, q: ArrayLike) -> FloatArray:
        """B with qd = B u, (dof, n_actions)."""
        if not self._base_joints:
            return np.eye(self.dof)
        rows, columns = self._base_joints, self._base_actions
        result = np.zeros((self.dof, self.n_actions))
        result[:rows, :columns] = self.moving_base.action_map(np.asarray(q, dtype=float).tolist())
        result[rows:, columns:] = np.eye(self.dof - rows)
        return result

    def joint_velocity(self, q: Sequence[float], u: list[float]) -> list[float]:
        """qd at q under the actuated velocity u."""
        if not self._base_joints:
            return u
        actions = self._base_actions
        return self.moving_base.joint_velocity(q, u[:actions]) + u[actions:]

    def integrate(
        self, q: list[float], u: list[float], action: list[float], dt: float
    ) -> tuple[list[float], list[float]]:
        """State (q, u) after dt [s] under the constant action, exact.

        Raises LpbError under torque control, whose motion only a simulation of forces can tell.
        """
        if self.control == "torque":
            raise LpbError("torques have no motion in closed form; simulate them with dynamics: true")
        joints, actions = self._base_joints, self._base_actions
        if not joints:
            return integrate_holonomic(self.control, q, u, action, dt)
        base_q, base_u = self.moving_base.integrate(q[:joints], u[:actions], action[:actions], dt)
        arm_q, arm_u = integrate_holonomic(self.control, q[joints:], u[actions:], action[actions:], dt)
        return base_q + arm_q, base_u + arm_u

    @property
    def steers(self) -> bool:
        """Whether its base has a steering angle."""
        return self._base_joints > STEERING

    def peak_rates(self, q: Sequence[float], before: list[float], after: list[float], dt: float) -> list[float]:
        """Bounds (dof,) of the rates of q during a step in which u changes linearly between two values.

        Args:
            q: at the end of the step (dof,).
            before, after: values of u (n_actions,).
            dt: length of the step [s].

        With the bounds of `reach_of_joints` they bound the speed of every point of the robot. The speed of a base
        stands at x, and zero at y.
        """
        joints, actions = self._base_joints, self._base_actions
        if not joints:
            return [max(abs(first), abs(last)) for first, last in zip(before, after, strict=True)]
        steepest = 0.0
        if self.steers:  # it comes from the angle before to that at the end
            steepest = abs(q[STEERING]) + max(abs(before[actions - 1]), abs(after[actions - 1])) * dt
        rates = self.moving_base.peak_rates(before[:actions], after[:actions], steepest)
        arm = zip(before[actions:], after[actions:], strict=True)
        return rates + [max(abs(first), abs(last)) for first, last in arm]

    @cached_property
    def body_names(self) -> tuple[str, ...]:
        """Links that have collision geometry."""
        own = set(self.link_names)
        return tuple(link.name for link in self.urdf.links if link.collisions and link.name in own)

    def _geometry(self) -> tuple[CollisionBody, ...]:
        from pytest_lpb.problem.spatial.meshes import capsule_of

        return tuple(
            CollisionBody(name, name, tuple(capsule_of(shape) for shape in self.urdf.link(name).collisions))
            for name in self.body_names
        )

    def _collision_bodies(self) -> tuple[CollisionBody, ...]:
        return self._geometry()  # spheres in place of the geometry are in the URDF model already

    def _adjacent(self, first: str, second: str) -> bool:
        return RigidGroups(self.urdf, self.joint_names).adjacent(first, second)

    def _default_pairs(self) -> Pairs:
        return self._chosen_pairs()[0]

    @property
    def left_out_pairs(self) -> Pairs:
        """Pairs of bodies that could be checked for collisions, but always overlap; empty where pairs are listed."""
        given = self.entry.get("self_collision_pairs")
        return () if given is not None and not isinstance(given, Mapping) else self._chosen_pairs()[1]

    def _chosen_pairs(self) -> tuple[Pairs, Pairs]:
        """Default pairs, and those left out; found once per robot and process, since it takes a simulated world."""
        beside = ("name", "control", "self_collision_pairs")  # which the default does not depend on
        parts = {name: value for name, value in self.entry.items() if name not in beside}
        key = canonical_json([parts, self._files_digest()])
        if key not in _default_pairs:
            from pytest_lpb.problem.spatial.space import always_overlapping

            groups = RigidGroups(self.urdf, self.joint_names)
            names = self.body_names
            candidates = [
                (first, second)
                for index, first in enumerate(names)
                for second in names[index + 1 :]
                if not groups.adjacent(first, second)
            ]
            left_out = tuple(always_overlapping(self, candidates))
            _default_pairs[key] = tuple(pair for pair in candidates if pair not in left_out), left_out
        return _default_pairs[key]

    def _files_digest(self) -> str | None:
        return None if self.urdf.path is None else assets_digest(self.urdf.path)

    @property
    def notes(self) -> list[str]:
        """How the URDF was read where there are several ways, and what of it is not there and not needed."""
        from pytest_lpb.problem.spatial.robot_files import replaced_faults, visual_faults

        found = [*self.urdf.notes, *visual_faults(self.urdf)]
        if self.entry.get("collision", "geometry") != "geometry":
            found += replaced_faults(model_of(self.entry))
        return found

    @property
    def warnings(self) -> list[str]:
        """What is probably not meant."""
        found = list(self.urdf.warnings)
        if not self.body_names:
            found.append(
                f"the robot {self.name!r} has no collision geometry, so it never collides; give it some in its URDF, "
                "or in the scenario: collision: {spheres: ..} or {link_spheres: r}"
            )
        return found

    def hashed(self) -> dict[str, Any]:
        """What identifies the robot wherever its files lie: its entry, with a digest of the files for their place."""
        digest = self._files_digest()
        if digest is None:
            return self.entry
        return {**{key: value for key, value in self.entry.items() if key != "urdf"}, "assets": digest}

    def collision_space(self, obstacles: Sequence[Obstacle]) -> CollisionSpace:
        """Where this robot's clearance can be asked for; borrows a PyBullet world until it is closed."""
        from pytest_lpb.problem.spatial.space import SpatialSpace

        return SpatialSpace(self, obstacles)
