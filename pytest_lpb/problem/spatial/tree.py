"""Kinematics of a tree of links: frames and Jacobians in NumPy, vectorised over a trajectory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.rotations import turned
from pytest_lpb.problem.spatial.urdf import Joint, UrdfModel


class _Moving:
    """A joint that q moves."""

    def __init__(self, joint: Joint, source: int, multiplier: float, offset: float) -> None:
        self.revolute = joint.kind == "revolute"
        self.axis = np.array(joint.axis)
        self.source = source
        self.multiplier = multiplier
        self.offset = offset
        x, y, z = joint.axis
        self.cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        self.square = self.cross @ self.cross

    def motions(self, q: FloatArray) -> FloatArray:
        """Poses (N, 4, 4) of the child in the joint's frame at q (N, dof)."""
        values = self.multiplier * q[:, self.source] + self.offset
        poses = np.zeros((len(q), 4, 4))
        poses[:] = np.eye(4)
        if self.revolute:
            poses[:, :3, :3] = turned(self.axis, values)
        else:
            poses[:, :3, 3] = values[:, None] * self.axis
        return poses


class _Stack:
    """The joints above one link, stacked: few calls of NumPy whatever their number."""

    def __init__(self, steps: list[tuple[FloatArray, _Moving]], last: FloatArray) -> None:
        joints = [joint for _, joint in steps]
        self._last = last
        self._sources = np.array([joint.source for joint in joints], dtype=np.intp)
        self._multipliers = np.array([joint.multiplier for joint in joints])
        self._offsets = np.array([joint.offset for joint in joints])
        self._revolute = np.array([joint.revolute for joint in joints], dtype=float)
        self._mixed = not self._revolute.all()
        self._repeated = len(set(self._sources.tolist())) < len(joints)
        # A step is still + s first + c second: (s, c) = (sin, 1 - cos) of a turn, (value, 0) of a slide.
        self._parts = np.zeros((3, len(joints), 4, 4))
        for row, (before, joint) in enumerate(steps):
            first, second = np.zeros((4, 4)), np.zeros((4, 4))
            if joint.revolute:
                first[:3, :3], second[:3, :3] = joint.cross, joint.square
            else:
                first[:3, 3] = joint.axis
            self._parts[:, row] = before, before @ first, before @ second
        self._axes = np.array([joint.axis for joint in joints]).reshape(-1, 3, 1)

    def frames(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Frames (n, 4, 4) behind each joint, and that of the link (4, 4)."""
        values = q[self._sources] * self._multipliers + self._offsets
        first, second = np.sin(values), 1.0 - np.cos(values)
        if self._mixed:
            first = self._revolute * first + (1.0 - self._revolute) * values
            second *= self._revolute
        still, sines, cosines = self._parts
        moves = still + first[:, None, None] * sines + second[:, None, None] * cosines
        pose = np.eye(4)
        for row, move in enumerate(moves):
            pose = moves[row] = pose @ move
        return moves, pose @ self._last

    def frame_and_jacobian(self, q: FloatArray, dof: int) -> tuple[FloatArray, FloatArray]:
        """Frame (4, 4) of the link, and its Jacobian (6, dof)."""
        moves, pose = self.frames(q)
        axes = (moves[:, :3, :3] @ self._axes)[:, :, 0]
        columns = np.empty((6, len(axes)))
        columns[:3] = _cross(axes, pose[:3, 3] - moves[:, :3, 3]).T
        columns[3:] = axes.T
        if self._mixed:
            columns *= self._revolute
            columns[:3] += (1.0 - self._revolute) * axes.T
        columns *= self._multipliers
        jacobian = np.zeros((6, dof))
        if self._repeated:
            for column, source in enumerate(self._sources):
                jacobian[:, source] += columns[:, column]
        else:
            jacobian[:, self._sources] = columns
        return pose, jacobian


class KinematicTree:
    """Frames of all links of a URDF model as functions of q.

    Args:
        model: the robot; the root link's frame is the world.
        joint_names: joints in the order of q.
        locked: positions of the other joints that could move [rad or m].

    Attributes: names, of the links in tree order.
    """

    def __init__(self, model: UrdfModel, joint_names: Sequence[str], locked: Mapping[str, float]) -> None:
        self.names = tuple(link.name for link in model.links)
        self.dof = len(joint_names)
        index = {name: place for place, name in enumerate(self.names)}
        entry = {name: place for place, name in enumerate(joint_names)}
        self._parents = [-1, *(index[joint.parent] for joint in model.joints)]
        self._origins: list[FloatArray] = [np.eye(4)]
        self._moving: list[_Moving | None] = [None]
        for joint in model.joints:
            source, multiplier, offset = joint.mimic if joint.mimic is not None else (joint.name, 1.0, 0.0)
            moving = None
            origin = np.array(joint.origin)
            if joint.kind != "fixed" and source in entry:
                moving = _Moving(joint, entry[source], multiplier, offset)
            elif joint.kind != "fixed":
                value = multiplier * locked.get(source, 0.0) + offset
                origin = origin @ _Moving(joint, 0, 1.0, 0.0).motions(np.array([[value]]))[0]
            self._origins.append(origin)
            self._moving.append(moving)
        self._collect()

    def _collect(self) -> None:
        """What Jacobians need of all moving joints at once, and the shortened chain of each link."""
        moved = [link for link, moving in enumerate(self._moving) if moving is not None]
        joints = [self._moving[link] for link in moved]
        self._joint_links = np.array(moved, dtype=np.intp)
        self._sources = np.array([joint.source for joint in joints if joint], dtype=np.intp)
        self._multipliers = np.array([joint.multiplier for joint in joints if joint])
        self._axes = np.array([joint.axis for joint in joints if joint]).reshape(-1, 3)
        self._revolute = np.array([joint.revolute for joint in joints if joint], dtype=bool)
        above = np.zeros((len(self.names), len(moved)), dtype=bool)  # which joints carry which link
        place = {link: column for column, link in enumerate(moved)}
        for link, parent in enumerate(self._parents):
            if parent >= 0:
                above[link] = above[parent]
            if link in place:
                above[link, place[link]] = True
        self._above = above
        self._chains = [self._chain(link) for link in range(len(self.names))]
        self._stacks: dict[int, _Stack] = {}

    def _chain(self, link: int) -> tuple[list[tuple[FloatArray, _Moving]], FloatArray]:
        """From the root to a link: (pose before a joint, joint) with fixed joints multiplied in, and what follows."""
        steps: list[tuple[FloatArray, _Moving]] = []
        path: list[int] = []
        while link >= 0:
            path.append(link)
            link = self._parents[link]
        pose = np.eye(4)
        for place in reversed(path):
            pose = pose @ self._origins[place]
            moving = self._moving[place]
            if moving is not None:
                steps.append((pose, moving))
                pose = np.eye(4)
        return steps, pose

    def frames_along(self, q: FloatArray) -> FloatArray:
        """Frames of all links in the world along a trajectory q (N, dof): (N, links, 4, 4)."""
        q = np.asarray(q, dtype=float)
        frames = np.empty((len(self.names), len(q), 4, 4))
        for link, parent in enumerate(self._parents):
            moving = self._moving[link]
            frame = self._origins[link] if parent < 0 else frames[parent] @ self._origins[link]
            frames[link] = frame if moving is None else frame @ moving.motions(q)
        return np.swapaxes(frames, 0, 1)

    def frame(self, q: FloatArray, link: int) -> FloatArray:
        """Frame of one link in the world at q (dof,): (4, 4)."""
        return self._stack(link).frames(q)[1]

    def frame_and_jacobian(self, q: FloatArray, link: int) -> tuple[FloatArray, FloatArray]:
        """Frame (4, 4) of a link and the velocity of its origin and its angular velocity per qd, (6, dof)."""
        return self._stack(link).frame_and_jacobian(q, self.dof)

    def _stack(self, link: int) -> _Stack:
        """The chain of a link, stacked the first time it is asked for."""
        if link not in self._stacks:
            self._stacks[link] = _Stack(*self._chains[link])
        return self._stacks[link]

    def jacobians(self, frames: FloatArray) -> FloatArray:
        """Jacobians (links, 6, dof) of all links, of their frames (links, 4, 4) as `frames_along` has them."""
        carriers = frames[self._joint_links]
        axes = (carriers[:, :3, :3] @ self._axes[:, :, None])[:, :, 0]
        arms = frames[:, None, :3, 3] - carriers[None, :, :3, 3]
        columns = np.zeros((len(self.names), len(axes), 6))
        revolute = self._revolute[:, None]
        columns[:, :, :3] = np.where(revolute, _cross(axes, arms), axes)
        columns[:, :, 3:] = np.where(revolute, axes, 0.0)
        columns *= (self._above * self._multipliers)[:, :, None]
        result = np.zeros((len(self.names), 6, self.dof))
        if len(set(self._sources.tolist())) == len(self._sources):
            result[:, :, self._sources] = np.swapaxes(columns, 1, 2)
        else:  # joints that mimic another add to its column
            for column, source in enumerate(self._sources):
                result[:, :, source] += columns[:, column]
        return result


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products along the last axis; np.cross takes several times as long for few vectors."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)
