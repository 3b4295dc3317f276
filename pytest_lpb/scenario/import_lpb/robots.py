"""Robots of localPlannerBench, and what each is here: its `robot` section, its numbered frames, its links by name.

There, links are numbers into a table of frames (`forwardkinematics` 1.0, confirmed by the frames that its published
results record): number 1 of the Panda is panda_link3, and its last number lies 20 mm beyond the flange panda_link8.
Release 1.1.1 says links by name and robots by URDF file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pytest_lpb.names import listed, suggestion
from pytest_lpb.scenario.import_lpb.fields import Fields, Key

FLANGE_TO_TIP_M = 0.02  # of panda_link9 there, along z of panda_link8
BOXER_TIP_M = 0.4  # [m] of the boxer's `ee_link` ahead of the axle
GROUND_ROBOT_TIP_M = 0.2


@dataclass(frozen=True)
class Frame:
    """A frame of a robot: a point of one of its links here; without a link, a place that stands still.

    Attributes:
        link: its link, or None.
        point: in the link's frame, or the world's [m].
    """

    link: str | None
    point: tuple[float, ...] = (0.0, 0.0, 0.0)


WORLD = Frame(None)


@dataclass(frozen=True)
class BenchRobot:
    """A robot there, and what it is here.

    Attributes:
        section: its `robot` section, given its number of joints.
        frames: of the numbers 0, 1, .., given its number of joints.
        joints: names of the entries of q here, given its number of joints.
        dimension: 2 in the engine `planar`, 3 in `pybullet`.
        names: frames that are known by a name.
        links: names of links that are the same here.
        velocity: key of the start velocity.
        speeds: entries of the start velocity; None: as many as joints.
        unused: last entries of q there that are none here.
        note: what differs here, for the importer's list.
    """

    section: Callable[[int], dict[str, Any]]
    frames: Callable[[int], tuple[Frame, ...]]
    joints: Callable[[int], tuple[str, ...]]
    dimension: int
    names: Mapping[str, Frame] = field(default_factory=dict)
    links: tuple[str, ...] = ()
    velocity: str = "qd"
    speeds: int | None = None
    unused: int = 0
    note: str = ""

    def frame(self, fields: Fields, keys: Sequence[Key], given: Any, count: int) -> Frame:
        """The frame that a number or a name found below `keys` stands for. Raises LpbError for an unknown one."""
        frames, names = self.frames(count), {**{link: Frame(link) for link in self.links}, **self.names}
        if isinstance(given, str) and not given.isdigit():
            if given in names:
                return names[given]
            raise fields.error(f"found the link {given!r}{suggestion(given, names)}; allowed: {listed(names)}", *keys)
        number = fields.checked_integer(given, keys)
        if not 0 <= number < len(frames):
            named = f", or one of {listed(names)}" if names else ""
            raise fields.error(f"found {number}; a link is a number of 0 to {len(frames) - 1}{named}", *keys)
        return frames[number]


_PANDA_NUMBERS = (0, 3, 4, 5, 6, 7, 8)
_PANDA_TIP = Frame("panda_link8", (0.0, 0.0, FLANGE_TO_TIP_M))
_PANDA_FRAMES = (*(Frame(f"panda_link{number}") for number in _PANDA_NUMBERS), _PANDA_TIP)
_PANDA_LINKS = (*(f"panda_link{number}" for number in range(9)), "panda_hand", "panda_leftfinger", "panda_rightfinger")
_PANDA_JOINTS = tuple(f"panda_joint{number}" for number in range(1, 8))
_POSE = ("x", "y", "theta")
_WORLD_NAMES = dict.fromkeys(("world", "world_link", "origin"), WORLD)


def _mounted(x: float, z: float) -> dict[str, Any]:
    return {"base_pose": {"position": [x, 0.0, z], "orientation": [1.0, 0.0, 0.0, 0.0]}}


def _on_mount(x: float, z: float) -> Frame:
    """A frame that the moving base carries, seen from panda_link0."""
    return Frame("panda_link0", (x, 0.0, z))


_POINT = BenchRobot(
    section=lambda _: {"model": "point"},
    frames=lambda _: (WORLD, Frame("body"), Frame("body")),
    joints=lambda _: ("x", "y"),
    dimension=2,
    names={**_WORLD_NAMES, "base_link": Frame("body")},
)
_POINT_URDF = BenchRobot(
    section=_POINT.section,
    frames=lambda _: (WORLD, *[Frame("body")] * 3),
    joints=_POINT.joints,
    dimension=2,
    names=_POINT.names,
    unused=1,
    note="initState: theta, the third joint of this disc, which turns nothing that counts",
)


def _cart(ahead: float) -> BenchRobot:
    tip = Frame("base", (ahead, 0.0))
    return BenchRobot(
        section=lambda _: {"model": "differential_drive"},
        frames=lambda _: (WORLD, tip, tip, tip),
        joints=lambda _: _POSE,
        dimension=2,
        names={**_WORLD_NAMES, "ee_link": tip, "base_link": Frame("base")},
        velocity="u",
        speeds=2,
    )


def _arm_frames(count: int) -> tuple[Frame, ...]:
    return (Frame("base"), *(Frame(f"link{number + 1}") for number in range(1, count)), Frame("end"))


_PLANAR_ARM = BenchRobot(
    section=lambda count: {"model": "planar_arm", "links": count},
    frames=_arm_frames,
    joints=lambda count: tuple(f"joint{number}" for number in range(1, count + 1)),
    dimension=2,
    names=_WORLD_NAMES,
)
_PANDA = BenchRobot(
    section=lambda _: {"model": "panda"},
    frames=lambda _: _PANDA_FRAMES,
    joints=lambda _: _PANDA_JOINTS,
    dimension=3,
    names={**_WORLD_NAMES, "panda_link9": _PANDA_TIP},
    links=_PANDA_LINKS,
)
_MOBILE_PANDA = BenchRobot(
    section=lambda _: {"model": "panda", "base": "holonomic", **_mounted(0.0, 0.25)},
    frames=lambda _: (WORLD, _on_mount(0.0, -0.1), _on_mount(0.0, -0.1), *_PANDA_FRAMES),
    joints=lambda _: (*_POSE, *_PANDA_JOINTS),
    dimension=3,
    names={**_PANDA.names, "base_link": _on_mount(0.0, -0.1)},
    links=_PANDA_LINKS,
)
_ALBERT = BenchRobot(
    section=lambda _: {"model": "panda", "base": "differential_drive", **_mounted(-0.15, 0.5995)},
    frames=lambda _: (WORLD, _on_mount(0.55, -0.5995), _on_mount(0.15, 0.0), *_PANDA_FRAMES),
    joints=_MOBILE_PANDA.joints,
    dimension=3,
    names={
        **_PANDA.names,
        "base_link": _on_mount(0.15, -0.5995),
        "base_tip_link": _on_mount(0.55, -0.5995),
        "top_mount": _on_mount(0.15, 0.0),
    },
    links=_PANDA_LINKS,
    velocity="u",
    speeds=9,
)

_GRASP = (0.0, 0.0, -0.2766)  # of the gripper's grasping frame in the frame of an arm's last link [m]
_TIAGO_ARM_NUMBERS = (1, 2, 3, 4, 5, 7)


def _tiago_arm(side: str) -> tuple[Frame, ...]:
    links = [Frame(f"arm_{side}_{number}_link") for number in _TIAGO_ARM_NUMBERS]
    return (*links, Frame(f"arm_{side}_7_link", _GRASP))


_TIAGO_JOINTS = (
    "torso_lift_joint",
    "head_1_joint",
    "head_2_joint",
    *(f"arm_{side}_{number}_joint" for side in ("left", "right") for number in range(1, 8)),
)
_TIAGO_TORSO = (Frame("base_link"), Frame("torso_fixed_link"), Frame("torso_fixed_link"), Frame("torso_lift_link"))
_TIAGO = BenchRobot(
    section=lambda _: {
        "model": "tiago_dual",
        "base": "differential_drive",
        "joints": list(_TIAGO_JOINTS),
        **_mounted(-0.18, 0.10),
    },
    frames=lambda _: (
        WORLD,
        *_TIAGO_TORSO,
        *_tiago_arm("left"),
        *_tiago_arm("right"),
        Frame("head_1_link"),
        Frame("head_2_link"),
    ),
    joints=lambda _: (*_POSE, *_TIAGO_JOINTS),
    dimension=3,
    names={**_WORLD_NAMES, **{f"gripper_{side}_grasping_frame": _tiago_arm(side)[-1] for side in ("left", "right")}},
    links=tuple(
        frame.link for frame in (*_TIAGO_TORSO, *_tiago_arm("left"), *_tiago_arm("right")) if frame.link is not None
    ),
    velocity="u",
    speeds=19,
    note="robot_type: the grippers; this Tiago has hands, at rest",
)

# A further robot of localPlannerBench is one entry here.
BENCH_ROBOTS: dict[str, BenchRobot] = {
    "pointRobot": _POINT,
    "pointMass": _POINT,
    "pointRobotUrdf": _POINT_URDF,
    "planarArm": _PLANAR_ARM,
    "boxer": _cart(BOXER_TIP_M),
    "groundRobot": _cart(GROUND_ROBOT_TIP_M),
    "panda": _PANDA,
    "mobilePanda": _MOBILE_PANDA,
    "albert": _ALBERT,
    "tiago": _TIAGO,
}

# The robot of a URDF file, by its stem in lower case without `_`.
_BY_URDF = {name.lower(): name for name in BENCH_ROBOTS} | {
    "pointrobot": "pointRobotUrdf",
    "pandawithfinger": "panda",
    "pandawithgripper": "panda",
}


def robot_of(fields: Fields) -> BenchRobot:
    """The robot of an experiment. Raises LpbError for one that is not known."""
    if "robot_type" in fields:
        name = fields.get("robot_type")
        if not isinstance(name, str) or name not in BENCH_ROBOTS:
            hint = suggestion(str(name), BENCH_ROBOTS)
            raise fields.error(f"found {name!r}{hint}; can be imported: {listed(BENCH_ROBOTS)}", "robot_type")
        # The point of release 1.1.1 is a URDF with three joints.
        return _POINT_URDF if BENCH_ROBOTS[name] is _POINT and "urdf_file_name" in fields else BENCH_ROBOTS[name]
    if "urdf_file_name" not in fields:
        raise fields.error("is missing; experiments of localPlannerBench have it, or urdf_file_name", "robot_type")
    urdf = str(fields.get("urdf_file_name"))
    stem = urdf.rpartition("/")[2].lower().removesuffix(".urdf").replace("_", "").replace("-", "")
    if stem not in _BY_URDF:
        known = ", ".join(sorted({f"{stem}.urdf" for stem in _BY_URDF}))
        raise fields.error(
            f"found {urdf!r}; known by name are {known} (`_` may be anywhere); for another robot import with "
            "`robot_type: panda` and put `robot: {urdf: ...}` into the scenario file",
            "urdf_file_name",
        )
    return BENCH_ROBOTS[_BY_URDF[stem]]
