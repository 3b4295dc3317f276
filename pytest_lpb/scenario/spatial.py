"""The `robot` section of a spatial robot with every default filled in: from its URDF, and what is known by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

from pytest_lpb.documents.faults import Fault
from pytest_lpb.errors import ScenarioError
from pytest_lpb.names import is_name, suggestion
from pytest_lpb.problem.spatial.base import BASES
from pytest_lpb.problem.spatial.composition import composed
from pytest_lpb.problem.spatial.generated import GENERATED, GeneratedModel, Sizes
from pytest_lpb.problem.spatial.library import LibraryRobot, known_robots, library_robot
from pytest_lpb.problem.spatial.robot_files import check_meshes
from pytest_lpb.problem.spatial.urdf import Joint, UrdfModel
from pytest_lpb.problem.spatial.urdf_reader import load_urdf
from pytest_lpb.scenario.robot_names import wrong_name
from pytest_lpb.scenario.schema.robot import MAX_LINKS, BasePose, CollisionSpheres, Robot
from pytest_lpb.scenario.schema.values import MAX_COORDINATE
from pytest_lpb.scenario.structure import Structure

DEFAULT_WHEEL_BASE_M = 0.5
WHEELED = ("differential_drive", "bicycle")
POINT = "point_3d"
URDF_SUFFIX = ".urdf"  # what tells a URDF with meshes from a mesh where files are copied

Entry = dict[str, Any]


class RobotFaultError(ScenarioError):
    """A fault of the robot section, with its key."""

    def __init__(self, fault: Fault) -> None:
        super().__init__(fault.message)
        self.fault = fault


def spatial_models() -> tuple[str, ...]:
    """Names of all robots in space."""
    return tuple(sorted({*GENERATED, *known_robots()}))


class SpatialDescription:
    """What follows from the `robot` section of a scenario file.

    Args:
        robot: with an absolute path in `urdf`.

    Attributes: entry, as a concrete problem has it; structure, the names of its parts.

    Raises RobotFaultError for a robot that cannot be, MissingRobotsError for one that is not installed.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._generated: GeneratedModel | None = GENERATED.get(robot.model or "")
        self._library = self._from_library()
        self._model = self._load()
        self._base = self._base_name()
        self._check_names()
        self._joints = self._planned()
        self._locked = self._locked_joints()
        self.entry = self._entry()
        self.structure = self._structure()

    def _fault(self, key: str, message: str) -> RobotFaultError:
        return RobotFaultError(Fault(("robot", key), message))

    def _from_library(self) -> LibraryRobot | None:
        name = self._robot.model
        return None if name is None or self._generated else library_robot(name)

    def _load(self) -> UrdfModel:
        robot = self._robot
        if self._generated is not None:
            if robot.model == "arm_3d" and robot.links is None:
                raise self._fault("links", "is missing; arm_3d needs a count of links, or their lengths [m]")
            sizes = Sizes(
                links=tuple(robot.links or ()),
                body_radius=robot.body_radius or self._generated.body_radius or 0.1,
                wheel_base=robot.wheel_base or self._generated.wheel_base or DEFAULT_WHEEL_BASE_M,
            )
            return self._generated.build(sizes)
        if robot.urdf is not None:
            self._check_file(Path(robot.urdf))
        try:
            if robot.urdf is not None and isinstance(robot.collision, str):
                check_meshes(Path(robot.urdf))  # others are replaced
            return load_urdf(self._library.path if self._library else Path(robot.urdf or ""))
        except (OSError, ScenarioError) as error:
            raise self._fault(self._source, str(error)) from None

    @property
    def _source(self) -> str:
        """The key that names the robot."""
        return "model" if self._robot.urdf is None else "urdf"

    def _check_file(self, path: Path) -> None:
        if path.suffix != URDF_SUFFIX:
            hint = "; run xacro on it first and use what it writes" if path.suffix == ".xacro" else ""
            raise self._fault("urdf", f"found {path.name!r}; the name of a URDF file ends in {URDF_SUFFIX}{hint}")
        if not path.is_file():
            raise self._fault("urdf", f"there is no file {path}")
        if self._robot.name is None and not is_name(path.stem):
            raise self._fault("urdf", f"{path.stem!r} cannot be the robot's name; give it another with the key name")

    def _check_names(self) -> None:
        if self._generated is not None:
            return
        carried = self._robot.base_size is not None
        wrong = wrong_name(self._model, BASES[self._base].joints, carried=carried)
        if wrong is not None:
            raise self._fault(self._source, wrong)

    def _base_name(self) -> str:
        known = self._generated or self._library
        default = "fixed" if known is None else known.base
        chosen = self._robot.base or default
        if self._robot.model == POINT and chosen != "fixed":
            raise self._fault("base", f"{chosen} is not available for {POINT}, which moves by itself; allowed: fixed")
        return chosen

    def _steering(self) -> tuple[str, ...]:
        return self._library.steering if self._library and self._base == "bicycle" else ()

    def _planned(self) -> tuple[str, ...]:
        movable = self._model.movable
        given = self._robot.joints
        if given is None:
            listed = self._library.joints if self._library else None
            left = {*(self._robot.locked_joints or {}), *self._steering()}
            if listed is None:
                left |= {name for name in movable if _is_wheel(self._model.joint(name))}
            planned = tuple(name for name in listed or movable if name not in left)
        else:
            for index, name in enumerate(given):
                self._check_joint(("joints", index), name, movable)
            planned = tuple(given)
        if not planned and self._base == "fixed":
            raise self._fault("joints", f"{self._model.name} has no joint that moves, and its base is fixed")
        if len(planned) > MAX_LINKS:
            what = f"{self._model.name} has {len(planned)} joints that move; name those to plan, at most {MAX_LINKS}"
            raise self._fault("joints", what)
        return planned

    def _check_joint(self, place: tuple[str | int, ...], name: str, movable: Sequence[str]) -> None:
        if name in self._steering():
            why = "is turned by the base's steering angle, delta; it can be neither planned nor locked"
            raise RobotFaultError(Fault(("robot", *place), f"joint {name!r} {why}"))
        if name in movable:
            return
        known = {joint.name: joint for joint in self._model.joints}
        if name not in known:
            message = f"unknown joint {name!r}{suggestion(name, movable)}; allowed: {', '.join(movable)}"
        else:
            followed = known[name].mimic
            why = "is fixed, or held by its limits" if followed is None else f"mimics {followed[0]!r}"
            message = f"joint {name!r} {why}; allowed: {', '.join(movable)}"
        raise RobotFaultError(Fault(("robot", *place), message))

    def _locked_joints(self) -> dict[str, float]:
        given = self._robot.locked_joints or {}
        for name in given:
            self._check_joint(("locked_joints", name), name, self._model.movable)
            if name in self._joints:
                raise RobotFaultError(
                    Fault(("robot", "locked_joints", name), f"joint {name!r} is planned; lock or plan it")
                )
        known: Mapping[str, float] = self._library.locked if self._library else {}
        free = [name for name in self._model.movable if name not in self._joints and name not in self._steering()]
        return {name: given.get(name, known.get(name, _nearest_to_zero(self._model.joint(name)))) for name in free}

    def _entry(self) -> Entry:
        robot, generated = self._robot, self._generated
        known = generated or self._library
        moving = self._base != "fixed"
        self._refuse_keys(moving)
        wheel_base = None
        if self._base in WHEELED:
            wheel_base = robot.wheel_base or (known.wheel_base if known else None) or DEFAULT_WHEEL_BASE_M
        entry: Entry = {"urdf": robot.urdf} if robot.urdf else {"model": robot.model}
        stem = Path(robot.urdf).stem if robot.urdf else str(robot.model)
        links = list(robot.links or ())
        entry["name"] = robot.name or (f"{stem}_{len(links)}" if links else stem)
        if links:
            entry["links"] = links
        entry |= {
            "joints": list(self._joints),
            "locked_joints": self._locked,
            "control": robot.control,
            "base": self._base,
            "base_pose": (robot.base_pose or BasePose()).model_dump(),
            "base_size": robot.base_size,
            "wheel_base": wheel_base,
            "body_radius": robot.body_radius or (generated.body_radius if generated else None),
            "collision": robot.collision
            if isinstance(robot.collision, str)
            else robot.collision.model_dump(exclude_none=True),
            "limits": self._limits(),
        }
        return entry

    def _refuse_keys(self, moving: bool) -> None:
        robot = self._robot
        if robot.links is not None and robot.model != "arm_3d":
            raise self._fault(
                "links", f"has no meaning for {self._model.name}; only arm_3d is made of links to measure"
            )
        if robot.body_radius is not None and (self._generated is None or self._generated.body_radius is None):
            raise self._fault("body_radius", f"has no meaning for {self._model.name}, whose geometry is given")
        if robot.base_size is not None and not moving:
            raise self._fault("base_size", "has no meaning for a fixed base; see base_pose")
        if robot.wheel_base is not None and self._base not in WHEELED:
            raise self._fault("wheel_base", f"has no meaning for the base {self._base}")
        if robot.control == "torque" and moving:
            raise self._fault("control", f"torque is not available for the base {self._base}; allowed: fixed")

    def _limits(self) -> Entry:
        base = BASES[self._base]
        steering = self._steering()
        defaults = dict(self._generated.position_limits) if self._generated else {}
        if steering:
            defaults["delta"] = (self._model.joint(steering[0]).lower, self._model.joint(steering[0]).upper)
        joints = [self._model.joint(name) for name in self._joints]
        free: list[list[float] | None] = [None] * len(base.actions)
        filled: Entry = {
            "position": [_pair(*defaults[name]) if name in defaults else None for name in base.joints]
            + [_pair(joint.lower, joint.upper) for joint in joints],
            "velocity": free + [_pair(-joint.velocity, joint.velocity) for joint in joints],
            "acceleration": free + [None] * len(joints),
            "effort": free + [_pair(-joint.effort, joint.effort) for joint in joints],
        }
        for key in self._robot.limits.model_fields_set if self._robot.limits else ():
            given = getattr(self._robot.limits, key)
            filled[key] = [None] * len(filled[key]) if given is None else given
        return filled

    def _structure(self) -> Structure:
        try:
            whole = composed(self.entry)
        except ScenarioError as error:
            raise self._fault("joints", str(error)) from None
        geometry = {link.name for link in whole.urdf.links if link.collisions}
        bodies = tuple(name for name in whole.links if name in geometry)
        if isinstance(self._robot.collision, CollisionSpheres):
            bodies = tuple(self._robot.collision.spheres or whole.links)
        base = BASES[self._base]
        return Structure(
            dimension=3,
            velocity_key="u" if self._base in WHEELED else "qd",
            joints=whole.joints,
            joint_types=whole.kinds,
            actions=(*base.actions, *self._joints),
            links=whole.links,
            bodies=bodies,
            position_limits=tuple(self.entry["limits"]["position"]),
        )


def _is_wheel(joint: Joint) -> bool:
    return joint.kind == "revolute" and not isfinite(joint.upper) and "wheel" in joint.name.lower()


def _nearest_to_zero(joint: Joint) -> float:
    return min(max(0.0, joint.lower), joint.upper)


def _pair(lower: float, upper: float) -> list[float] | None:
    """Limits as a scenario file can have them; some URDFs write 1e16 for none."""
    bounded = [max(lower, -MAX_COORDINATE), min(upper, MAX_COORDINATE)]
    return None if bounded == [-MAX_COORDINATE, MAX_COORDINATE] else bounded
