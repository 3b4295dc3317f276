"""Spatial robots for tests, from concrete entries that need no scenario file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pytest_lpb.problem.robot import robot_from
from pytest_lpb.problem.spatial.generated import GENERATED
from pytest_lpb.problem.spatial.library import library_robot
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.urdf_reader import load_urdf

Entry = dict[str, Any]

TILTED: Entry = {"position": [0.1, -0.2, 0.3], "orientation": [0.5, 0.5, 0.5, 0.5]}

DEFAULTS: Entry = {
    "joints": [],
    "locked_joints": {},
    "base": "fixed",
    "base_pose": None,
    "base_size": None,
    "wheel_base": None,
    "control": "acceleration",
    "body_radius": None,
    "collision": "geometry",
    "limits": {},
    "self_collision_pairs": [],
}

PANDA: Entry = {
    "model": "panda",
    "joints": [f"panda_joint{index}" for index in range(1, 8)],
    "locked_joints": {"panda_finger_joint1": 0.02},
}
KUKA: Entry = {"model": "kuka_iiwa", "joints": [f"lbr_iiwa_joint_{index}" for index in range(1, 8)]}
HUSKY: Entry = {"model": "husky", "base": "differential_drive", "wheel_base": 0.55}
RACECAR: Entry = {"model": "racecar", "base": "bicycle", "wheel_base": 0.325}
POINT: Entry = {"model": "point_3d", "joints": ["x", "y", "z"], "body_radius": 0.2}
ARM: Entry = {
    "model": "arm_3d",
    "links": [0.5, 0.4, 0.3],
    "joints": ["joint1", "joint2", "joint3"],
    "body_radius": 0.05,
}
CART: Entry = {"model": "cart", "base": "differential_drive", "wheel_base": 0.4, "body_radius": 0.2}
CAR: Entry = {"model": "car", "base": "bicycle", "wheel_base": 0.5}
MOUNTED: Entry = {**PANDA, "base_size": [0.6, 0.5, 0.4], "base_pose": TILTED}

# One robot per way of being put together.
ENTRIES: dict[str, Entry] = {
    "panda": {**PANDA, "base_pose": TILTED},
    "panda with its fingers": {**PANDA, "joints": [*PANDA["joints"], "panda_finger_joint1"], "locked_joints": {}},
    "kuka": KUKA,
    "husky": HUSKY,
    "racecar": RACECAR,
    "arm": ARM,
    "point": {**POINT, "base_pose": TILTED},
    "cart": CART,
    "car": CAR,
    "panda on wheels": {**MOUNTED, "base": "differential_drive", "wheel_base": 0.5},
    "panda on a holonomic base": {**MOUNTED, "base": "holonomic"},
    "arm on a car": {**ARM, "base": "bicycle", "wheel_base": 0.5, "base_size": [0.6, 0.4, 0.3]},
}

# A gripper whose second finger follows the first, and a wrist that follows the lift at half its rate.
MIMIC_URDF = """<robot name="gripper">
  <link name="root"/><link name="lifted"/><link name="wrist"/><link name="left"/><link name="right"/>
  <joint name="lift" type="prismatic"><parent link="root"/><child link="lifted"/>
    <origin xyz="0 0 1"/><axis xyz="0 0 1"/><limit lower="0" upper="1"/></joint>
  <joint name="turn" type="revolute"><parent link="lifted"/><child link="wrist"/>
    <origin xyz="0.2 0 0"/><axis xyz="0 0 2"/><limit lower="-3" upper="3"/>
    <mimic joint="lift" multiplier="0.5" offset="0.1"/></joint>
  <joint name="open" type="prismatic"><parent link="wrist"/><child link="left"/>
    <origin xyz="0.1 0 0"/><axis xyz="0 1 0"/><limit lower="0" upper="0.1"/></joint>
  <joint name="close" type="prismatic"><parent link="wrist"/><child link="right"/>
    <origin xyz="0.1 0 0"/><axis xyz="0 1 0"/><limit lower="-0.1" upper="0"/>
    <mimic joint="open" multiplier="-1"/></joint>
</robot>
"""


def robot_entry(entry: Entry, **changes: Any) -> Entry:
    """A concrete entry: defaults filled in, joints that are neither planned nor steered locked at zero."""
    full = {**DEFAULTS, "name": entry.get("model", "robot"), **entry, **changes}
    taken = set(full["joints"])
    movable: tuple[str, ...] = ()
    if full.get("urdf"):
        movable = load_urdf(Path(full["urdf"])).movable
    elif full["model"] not in GENERATED:
        known = library_robot(full["model"])
        movable = load_urdf(known.path).movable
        taken |= set(known.steering if full["base"] == "bicycle" else ())
    locked = {name: full["locked_joints"].get(name, 0.0) for name in movable if name not in taken}
    return {**full, "locked_joints": locked}


def spatial_robot(entry: Entry, **changes: Any) -> SpatialRobot:
    """The robot of an entry."""
    made = robot_from(robot_entry(entry, **changes))
    assert isinstance(made, SpatialRobot)
    return made


def mimic_robot(folder: Path, **changes: Any) -> SpatialRobot:
    """The gripper of `MIMIC_URDF`, written into a folder; its joints are lift and open."""
    path = folder / "gripper.urdf"
    path.write_text(MIMIC_URDF, encoding="utf-8")
    return spatial_robot({"urdf": str(path), "joints": ["lift", "open"]}, **changes)
