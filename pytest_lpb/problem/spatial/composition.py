"""A robot as it stands in the world: its URDF model on a base, with the collision geometry that is asked for."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.problem.hashing import canonical_json
from pytest_lpb.problem.robot import ROBOT_MODELS, FloatArray
from pytest_lpb.problem.spatial.base import BASES
from pytest_lpb.problem.spatial.content import file_digest
from pytest_lpb.problem.spatial.generated import GENERATED, Sizes, base_body
from pytest_lpb.problem.spatial.library import known_robots, library_robot
from pytest_lpb.problem.spatial.rotations import matrix_of, normalised
from pytest_lpb.problem.spatial.tree import KinematicTree
from pytest_lpb.problem.spatial.urdf import Geometry, Joint, Link, UrdfModel, translation
from pytest_lpb.problem.spatial.urdf_reader import check_meshes_present, load_urdf

WORLD = "lpb_world"  # root of every composed robot; helper links begin with lpb_
HELPER = "lpb_"
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "theta": (0.0, 0.0, 1.0)}

# What of a robot's entry its composition depends on.
KEYS = ("model", "links", "joints", "locked_joints", "base", "base_pose", "base_size", "wheel_base", "body_radius")


@dataclass(frozen=True, eq=False)
class Composition:
    """What robots of equal entries share; never changed.

    Attributes:
        urdf: the whole robot from `WORLD` on, base joints included.
        tree: its kinematics.
        joints: names of the entries of q.
        kinds: of these, prismatic or revolute.
        links: names of the robot's own links.
        link_rows: their rows in the tree.
        base_pose: (4, 4), of the robot on its base, or in the world.
    """

    urdf: UrdfModel
    tree: KinematicTree
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    links: tuple[str, ...]
    link_rows: tuple[int, ...]
    base_pose: FloatArray


def model_of(entry: Mapping[str, Any]) -> UrdfModel:
    """The URDF model that a robot's entry names. Raises ScenarioError for a file or name that cannot be used."""
    if entry.get("urdf"):
        return load_urdf(Path(entry["urdf"]))
    name = entry["model"]
    known = {*ROBOT_MODELS, *GENERATED, *known_robots()}
    if name not in known:
        raise ScenarioError(f"robot: model: unknown {name!r}{suggestion(name, known)}; allowed: {listed(known)}")
    if name in GENERATED:
        given = {"body_radius": entry.get("body_radius"), "wheel_base": entry.get("wheel_base")}
        sizes = {key: value for key, value in given.items() if value is not None}
        return GENERATED[name].build(Sizes(links=tuple(entry.get("links") or ()), **sizes))
    return load_urdf(library_robot(name).path)


def steering_of(entry: Mapping[str, Any]) -> tuple[str, ...]:
    """Joints that a bicycle's steering angle turns."""
    name = entry.get("model")
    if name is None or name in GENERATED:
        return ()
    return library_robot(name).steering


def composed(entry: Mapping[str, Any]) -> Composition:
    """The composition of a robot's concrete entry; equal entries share one while their files do not change."""
    model = model_of(entry)
    stamps = [] if model.path is None else [str(model.path), file_digest(model.path)]
    key = {name: entry.get(name) for name in (*KEYS, "collision")} | {"stamps": stamps}
    return _composed(canonical_json(key), model if model.path is not None else None)


@lru_cache(maxsize=64)
def _composed(key: str, model: UrdfModel | None) -> Composition:
    entry = json.loads(key)
    model = model or model_of(entry)
    base = BASES[entry["base"]]
    taken = set(base.joints) & {joint.name for joint in model.joints}
    if taken and base.joints:
        raise ScenarioError(
            f"{model.name} has joints called {', '.join(sorted(taken))}, as its base has; rename them in the URDF"
        )
    pose = pose_of(entry.get("base_pose"))
    robot = _steered(model, steering_of(entry)) if entry["base"] == "bicycle" else model
    links = [Link(WORLD)]
    joints: list[Joint] = []
    if base.joints:
        _add_moving_frame(links, joints, entry.get("base_size"))
    joints.append(Joint("lpb_mount", "fixed", links[-1].name, robot.root, pose))
    whole = replace(model, links=(*links, *robot.links), joints=(*joints, *robot.joints))
    own = tuple(link.name for link in whole.links if not link.name.startswith(HELPER))
    urdf = with_collision(whole, entry.get("collision") or "geometry", own)
    repeated = {link.name for link in robot.links} & {link.name for link in links}
    if repeated:
        raise ScenarioError(
            f"{model.name} has links called {', '.join(sorted(repeated))}, as its base has; rename them"
        )
    names = (*base.joints, *entry["joints"])
    tree = KinematicTree(urdf, names, entry["locked_joints"])
    kinds = (*base.kinds, *(model.joint(name).kind for name in entry["joints"]))
    return Composition(urdf, tree, names, kinds, own, tuple(tree.names.index(name) for name in own), pose)


def _steered(model: UrdfModel, steering: tuple[str, ...]) -> UrdfModel:
    """The model whose steering joints follow the steering angle."""
    joints = tuple(replace(j, mimic=("delta", 1.0, 0.0)) if j.name in steering else j for j in model.joints)
    return replace(model, joints=joints)


def _add_moving_frame(links: list[Link], joints: list[Joint], size: list[float] | None) -> None:
    """Links and joints of a base that moves in the plane, and the box that carries the robot."""
    for name, kind in (("x", "prismatic"), ("y", "prismatic"), ("theta", "revolute")):
        link = base_body(size) if name == "theta" and size else Link(f"{HELPER}{name}")
        joints.append(Joint(name, kind, links[-1].name, link.name, axis=AXES[name]))
        links.append(link)


def pose_of(given: Mapping[str, Any] | None) -> FloatArray:
    """A base pose (4, 4), read-only, from position [m] and orientation wxyz; None: the identity."""
    pose = np.eye(4)
    if given is not None:
        pose[:3, 3] = given["position"]
        pose[:3, :3] = matrix_of(normalised(given["orientation"]))
    pose.flags.writeable = False  # robots of equal entries share it
    return pose


def with_collision(model: UrdfModel, collision: str | Mapping[str, Any], own: tuple[str, ...]) -> UrdfModel:
    """The model with the collision geometry that `robot.collision` asks for.

    Raises ScenarioError for a mesh that this takes and that is not there.
    """
    if isinstance(collision, str):
        check_meshes_present(model)
        return model
    spheres = dict(_spheres(collision, own))
    return replace(model, links=tuple(replace(link, collisions=spheres.get(link.name, ())) for link in model.links))


def _spheres(collision: Mapping[str, Any], own: tuple[str, ...]) -> Iterator[tuple[str, tuple[Geometry, ...]]]:
    radius = collision.get("link_spheres")
    if radius is not None:
        for link in own:
            yield link, (Geometry("sphere", (float(radius),)),)
    for link, rows in (collision.get("spheres") or {}).items():
        yield link, tuple(Geometry("sphere", (float(r),), translation(x, y, z)) for x, y, z, r in rows)
