"""URDF robots known by name: those that come with PyBullet, and those of the package example-robot-data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, lru_cache
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType

from pytest_lpb.errors import MissingRobotsError, ScenarioError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.problem.registries import robots

NOTHING: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class LibraryRobot:
    """A URDF file, and what it does not say of itself.

    Attributes:
        path: the file.
        joints: planned joints; None: all that move but the locked ones.
        locked: joints held at a position [rad or m].
        base: what it stands on.
        wheel_base: of a moving base [m].
        steering: joints turned by a bicycle's steering angle.
    """

    path: Path
    joints: tuple[str, ...] | None = None
    locked: Mapping[str, float] = field(default_factory=lambda: NOTHING)
    base: str = "fixed"
    wheel_base: float | None = None
    steering: tuple[str, ...] = ()


# File below PyBullet's data folder, and what else there is to say. A new robot is one entry here.
_PYBULLET: dict[str, dict[str, object]] = {
    "panda": {
        "path": "franka_panda/panda.urdf",
        "joints": tuple(f"panda_joint{index}" for index in range(1, 8)),
        "locked": MappingProxyType({"panda_finger_joint1": 0.02, "panda_finger_joint2": 0.02}),
    },
    "kuka_iiwa": {"path": "kuka_iiwa/model.urdf"},
    "xarm6": {"path": "xarm/xarm6_robot.urdf"},
    "husky": {"path": "husky/husky.urdf", "base": "differential_drive", "wheel_base": 0.55},
    "racecar": {
        "path": "racecar/racecar.urdf",
        "base": "bicycle",
        "wheel_base": 0.325,
        "steering": ("left_steering_hinge_joint", "right_steering_hinge_joint"),
    },
}

# Robots of example-robot-data, by the names its own loaders have; files below its folder of robots.
_EXAMPLE_ROBOT_DATA: dict[str, dict[str, object]] = {
    "ur3": {"path": "ur_description/urdf/ur3_robot.urdf"},
    "ur5": {"path": "ur_description/urdf/ur5_robot.urdf"},
    "ur5_gripper": {"path": "ur_description/urdf/ur5_gripper.urdf"},
    "ur10": {"path": "ur_description/urdf/ur10_robot.urdf"},
    "kinova": {"path": "kinova_description/robots/kinova.urdf"},
    "tiago": {"path": "tiago_description/robots/tiago.urdf", "base": "differential_drive", "wheel_base": 0.4044},
    "tiago_no_hand": {
        "path": "tiago_description/robots/tiago_no_hand.urdf",
        "base": "differential_drive",
        "wheel_base": 0.4044,
    },
    "tiago_dual": {
        "path": "tiago_description/robots/tiago_dual.urdf",
        # The hands' many joints are held: planning for them is grasping.
        "joints": (
            "torso_lift_joint",
            "head_1_joint",
            "head_2_joint",
            *(f"arm_{side}_{number}_joint" for side in ("left", "right") for number in range(1, 8)),
        ),
        "base": "differential_drive",
        "wheel_base": 0.4044,
    },
    "double_pendulum": {"path": "double_pendulum_description/urdf/double_pendulum.urdf"},
}


BUILT_IN = (*_PYBULLET, *_EXAMPLE_ROBOT_DATA)


def known_robots() -> tuple[str, ...]:
    """Names of all robots of the library, sorted; those of example-robot-data whether it is installed or not."""
    return tuple(sorted({*BUILT_IN, *(robot.name for robot in robots.all() if robot.urdf is not None)}))


def library_robot(name: str) -> LibraryRobot:
    """A robot known by name.

    Raises:
        ScenarioError: unknown name.
        MissingRobotsError: the package that has it is not installed.
    """
    registered = robots.get(name)
    if registered is not None and registered.urdf is not None:
        return LibraryRobot(**registered.urdf)
    entry = _PYBULLET.get(name) or _EXAMPLE_ROBOT_DATA.get(name)
    if entry is None:
        raise ScenarioError(
            f"unknown robot {name!r}{suggestion(name, known_robots())}; known: {listed(known_robots())}"
        )
    folder = _pybullet_folder() if name in _PYBULLET else _example_robot_data_folder()
    if folder is None:
        raise MissingRobotsError(
            f"the robot {name} comes with the package example-robot-data, which is not installed: "
            "pip install 'pytest-lpb[robots]'"
        )
    return LibraryRobot(**{**entry, "path": folder / str(entry["path"])})  # type: ignore[arg-type] # fields by name


def installed_folders() -> list[Path]:
    """Folders of the packages that robots known by name come with, links followed."""
    return [folder.resolve() for folder in (_pybullet_folder(), _example_robot_data_folder()) if folder is not None]


@lru_cache(maxsize=1024)
def is_installed(file: Path) -> bool:
    """Whether a file belongs to one of those packages."""
    try:
        resolved = file.resolve()
    except (OSError, RuntimeError):
        return False  # links that go in a circle
    return any(resolved.is_relative_to(folder) for folder in installed_folders())


@cache
def _pybullet_folder() -> Path:
    """Where PyBullet's data lie; found without importing it."""
    spec = find_spec("pybullet_data")
    assert spec is not None
    assert spec.origin is not None, "pybullet_data comes with pybullet"
    return Path(spec.origin).parent


@cache
def _example_robot_data_folder() -> Path | None:
    """Where the robots of example-robot-data lie, or None; its wheel installs data below `cmeel.prefix`."""
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        installed = distribution("example-robot-data")
    except PackageNotFoundError:
        return None
    folder = Path(str(installed.locate_file("cmeel.prefix/share/example-robot-data/robots")))
    return folder if folder.is_dir() else None
