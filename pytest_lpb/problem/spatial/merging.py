"""URDF models whose links that move as one are one link."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.urdf import Inertial, Joint, Link, UrdfModel, identity


def merged_links(model: UrdfModel, moving: Collection[str]) -> tuple[UrdfModel, dict[str, tuple[str, FloatArray]]]:
    """The model with links that move as one merged into the first of them, without geometry; and where each link is.

    Links on the root stay as they are: they carry what does not move.

    Args:
        model: the robot.
        moving: its joints that move; the others stay at zero.

    Returns the model, and of each link the one it is part of and its pose in there (4, 4).
    """
    places: dict[str, tuple[str, FloatArray]] = {model.root: (model.root, identity())}
    joints: list[Joint] = []
    for joint in model.joints:
        host, pose = places[joint.parent]
        at = pose @ joint.origin
        if joint.name in moving or host == model.root:
            places[joint.child] = (joint.child, identity())
            kind = joint.kind if joint.name in moving else "fixed"
            joints.append(replace(joint, kind=kind, parent=host, origin=at))
        else:
            places[joint.child] = (host, at)
    links = []
    for host in (model.root, *(joint.child for joint in joints)):
        inertials = [(model.link(name).inertial, pose) for name, (place, pose) in places.items() if place == host]
        links.append(Link(host, inertial=_merged(inertials)))
    return replace(model, links=tuple(links), joints=tuple(joints)), places


def _merged(inertials: Sequence[tuple[Inertial | None, FloatArray]]) -> Inertial | None:
    """Inertia of several bodies, each at a pose (4, 4), as one; about its centre of mass, axes as of the frame."""
    parts = [
        (one.mass, pose @ one.origin, one.inertia) for one, pose in inertials if one is not None and one.mass > 0.0
    ]
    if not parts:
        return None
    mass = sum(part_mass for part_mass, *_ in parts)
    centre = sum(part_mass * pose[:3, 3] for part_mass, pose, _ in parts) / mass
    inertia = np.zeros((3, 3))
    for part_mass, pose, own in parts:
        away = pose[:3, 3] - centre
        turn = pose[:3, :3]
        inertia += turn @ own @ turn.T + part_mass * (away @ away * np.eye(3) - np.outer(away, away))  # Steiner
    origin = np.eye(4)
    origin[:3, 3] = centre
    return Inertial(mass, origin, inertia)
