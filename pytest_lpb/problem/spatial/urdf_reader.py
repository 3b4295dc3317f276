"""Reads URDF files: XML of links and joints. Faults name file and line."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import lru_cache
from math import inf, isfinite, sqrt
from pathlib import Path

import numpy as np

from pytest_lpb.bounded import read_bounded
from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion.directions import LONGEST, rescaled
from pytest_lpb.names import listed, suggestion
from pytest_lpb.problem.allowed import allowed_by_user, project_of, refusal
from pytest_lpb.problem.packages import SCHEME, PackageFinder, environment
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.content import bounded_digest
from pytest_lpb.problem.spatial.mesh_limits import MESH_SUFFIXES
from pytest_lpb.problem.spatial.rotations import matrix_of, matrix_of_rpy, normalised
from pytest_lpb.problem.spatial.urdf import Geometry, Inertial, Joint, Link, UrdfModel
from pytest_lpb.problem.spatial.urdf_limits import with_ranges
from pytest_lpb.problem.spatial.urdf_tree import in_tree_order
from pytest_lpb.problem.spatial.xml_reader import Element, parse_xml

MAX_URDF_BYTES = 10_000_000
MAX_LINKS = 2_000
MAX_LENGTH_M = 1e4
VERSION = re.compile(r"1(?:\.(\d{1,3}))?")

# What roslaunch would replace: the default of an environment variable.
OPTENV = re.compile(r"\$\(optenv\s+\S+\s*(.*)\)")

KINDS = {"fixed": "fixed", "revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic"}


def load_urdf(path: Path) -> UrdfModel:
    """The robot of a URDF file; a file that has not changed is read once.

    A visual that cannot be shown is left away with a note. A collision mesh that is not there is kept as `missing`: a
    scenario may replace it, see `check_meshes_present`.

    Raises ScenarioError, with `file:line` where there is one, for a file that is no URDF, unknown links, a joint type
    that cannot be simulated, several roots or a loop.
    """
    path = Path(path).absolute()
    key = (path, bounded_digest(path, MAX_URDF_BYTES), environment(), allowed_by_user())
    model = _load(*key)
    if any(_found_now(name, path) for name in model.absent):
        _load.cache_clear()
        model = _load(*key)
    return model


@lru_cache(maxsize=64)
def _load(path: Path, _digest: str, _packages: object, _allowed: object) -> UrdfModel:
    return _Reader(path).model()


def check_meshes_present(model: UrdfModel) -> None:
    """Raise ScenarioError, `file:line: ..`, for a collision mesh that is not there."""
    for link in model.links:
        for shape in link.collisions:
            if shape.missing:
                raise ScenarioError(shape.missing)


class _Reader:
    """One file being read."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._packages = PackageFinder(path)
        self._notes: list[str] = []
        self._warnings: list[str] = []
        self._absent: list[str] = []
        self._located: dict[str, Path] = {}
        root = parse_xml(read_bounded(path, MAX_URDF_BYTES, ScenarioError), path)
        if root.tag != "robot":
            hint = "; run xacro on it first" if path.suffix == ".xacro" else ""
            raise self._fault(root, f"found <{root.tag}>; a URDF file has a <robot>{hint}")
        if any(child.tag.startswith("xacro:") for child in root.children):
            raise self._fault(root, "found xacro macros; run xacro on it first and use what it writes")
        self._root = root
        self._version = self._schema_version()
        self._colors = {
            element.attributes.get("name", ""): color
            for element in root.all("material")
            if (color := self._color(element)) is not None
        }

    def _fault(self, element: Element, what: str) -> ScenarioError:
        return ScenarioError(f"{self._path}:{element.line}: {what}")

    def _schema_version(self) -> tuple[int, int]:
        """Of URDF, (1, 0) where the file gives none."""
        text = self._root.attributes.get("version", "1.0")
        found = VERSION.fullmatch(text.strip())
        if found is None:
            raise self._fault(self._root, f"found the version {text!r} of URDF; allowed: 1.0, 1.1 and others of 1")
        return 1, int(found.group(1) or 0)

    def model(self) -> UrdfModel:
        links: dict[str, Link] = {}
        for element in self._root.all("link"):
            name = self._name(element, links)
            links[name] = self._link(element, name)
        if not links:
            raise self._fault(self._root, "found no <link>")
        if len(links) > MAX_LINKS:
            raise self._fault(self._root, f"found {len(links)} links; allowed are {MAX_LINKS}")
        joints: dict[str, Joint] = {}
        for element in self._root.all("joint"):
            name = self._name(element, joints)
            joints[name] = self._joint(element, name, links)
        joints |= {element.attributes["name"]: self._followed(element, joints) for element in self._root.all("joint")}
        joints, held, limits = with_ranges(joints)
        ordered_links, ordered_joints = in_tree_order(links, joints, self._path)
        return UrdfModel(
            self._root.attributes.get("name", self._path.stem),
            ordered_links,
            ordered_joints,
            self._path,
            tuple(dict.fromkeys([*self._notes, *(f"{self._path.name}: {note}" for note in held)])),
            (*self._warnings, *(f"{self._path.name}: {warning}" for warning in limits)),
            tuple(dict.fromkeys(self._absent)),
            self._located,
        )

    def _followed(self, element: Element, joints: dict[str, Joint]) -> Joint:
        """A joint with what it mimics; of one that mimics a follower, what that one follows.

        Where q = a r + b and r = c s + d, q = a c s + (a d + b).
        """
        joint = joints[element.attributes["name"]]
        if joint.mimic is None:
            return joint
        source, multiplier, offset = joint.mimic
        passed = {joint.name: None}  # in their order
        while True:
            if source not in joints:
                raise self._fault(element, f"mimics {source!r}, which is no joint{suggestion(source, joints)}")
            if source in passed:
                raise self._fault(element, f"mimics itself: {' -> '.join([*passed, source])}")
            further = joints[source].mimic
            if further is None:
                return replace(joint, mimic=(source, multiplier, offset))
            passed[source] = None
            source, multiplier, offset = further[0], multiplier * further[1], multiplier * further[2] + offset

    def _note(self, element: Element, what: str) -> str:
        return f"{self._path.name}:{element.line}: {what}"

    def _name(self, element: Element, taken: object) -> str:
        name = element.attributes.get("name")
        if not name:
            raise self._fault(element, f"<{element.tag}> has no name")
        if name in taken:  # type: ignore[operator] # a dictionary
            raise self._fault(element, f"<{element.tag}> {name!r} is there twice; names are unique")
        return name

    def _link(self, element: Element, name: str) -> Link:
        return Link(
            name,
            tuple(self._geometry(part) for part in element.all("collision")),
            tuple(shape for part in element.all("visual") if (shape := self._visual(part)) is not None),
            self._inertial(element.find("inertial")),
        )

    def _inertial(self, element: Element | None) -> Inertial | None:
        if element is None or (mass := element.find("mass")) is None:
            return None
        inertia = np.zeros((3, 3))
        given = element.find("inertia")
        if given is not None:
            for row, column, key in (
                (0, 0, "ixx"),
                (0, 1, "ixy"),
                (0, 2, "ixz"),
                (1, 1, "iyy"),
                (1, 2, "iyz"),
                (2, 2, "izz"),
            ):
                inertia[row, column] = inertia[column, row] = self._number(given, key, 0.0)
        return Inertial(self._number(mass, "value", 0.0), self._origin(element), inertia)

    def _visual(self, element: Element) -> Geometry | None:
        """What is seen of a link; None, with a note, for what cannot be shown: nothing else needs it."""
        try:
            shape = self._geometry(element)
        except ScenarioError as error:
            self._notes.append(f"{self._without_folder(error)}; it is not shown")
            return None
        if shape.kind != "mesh":
            return shape
        name = self._name_of_mesh(element)
        if shape.file is None:
            why: str | None = "is not there"
        elif shape.file.suffix.lower() not in MESH_SUFFIXES:
            why = f"is no {listed(MESH_SUFFIXES)} file"
        else:
            why = refusal(shape.file, project_of(self._path)) if name in self._located else None
        if why:
            self._located.pop(name, None)
            self._notes.append(self._note(element, f"the visual mesh {name!r} {why}; it is not shown"))
            return None
        return shape

    def _without_folder(self, error: ScenarioError) -> str:
        """A fault as a note has it: equal wherever the robot lies."""
        return str(error).removeprefix(f"{self._path.parent}/")

    def _name_of_mesh(self, element: Element) -> str:
        return next((part.attributes.get("filename", "") for part in element.below() if part.tag == "mesh"), "")

    def _geometry(self, element: Element) -> Geometry:
        geometry = element.find("geometry")
        shape = geometry.children[0] if geometry is not None and geometry.children else None
        if shape is None:
            raise self._fault(element, f"<{element.tag}> has no <geometry> with a shape")
        if shape.tag not in _SIZES:
            raise self._fault(shape, f"found <{shape.tag}>; allowed: {listed(_SIZES)}")
        size = tuple(
            value for key, default, count in _SIZES[shape.tag] for value in self._numbers(shape, key, default, count)
        )
        if shape.tag != "mesh" and not all(0.0 < value <= MAX_LENGTH_M for value in size):
            raise self._fault(
                shape, f"found the size {list(size)}; lengths above 0 m and up to {MAX_LENGTH_M:g} m are required"
            )
        file, missing = self._mesh(shape) if shape.tag == "mesh" else (None, "")
        return Geometry(
            shape.tag, size, self._origin(element), file, self._material(element.find("material")), shape.line, missing
        )

    def _material(self, element: Element | None) -> tuple[float, float, float, float] | None:
        if element is None:
            return None
        return self._color(element) or self._colors.get(element.attributes.get("name", ""))

    def _color(self, element: Element) -> tuple[float, float, float, float] | None:
        color = element.find("color")
        if color is None:
            return None
        try:
            r, g, b, a = self._numbers(color, "rgba", None, 4)
        except ScenarioError as error:
            self._notes.append(f"{self._without_folder(error)}; this colour is not shown")
            return None
        return (r, g, b, a)

    def _mesh(self, shape: Element) -> tuple[Path | None, str]:
        """The file of a mesh; or None, and what to say of one that is not there."""
        name = shape.attributes.get("filename", "")
        found = _resolved(name, self._path, self._packages)
        if found is not None:
            if name.startswith(SCHEME) and self._packages.find_above(name) is None:
                self._located[name] = found
            return found, ""
        self._absent.append(name)
        where = f"looked for it from {self._path.parent}"
        if name.startswith(SCHEME):
            where = self._packages.searched(name)
        return None, str(self._fault(shape, f"the mesh {name!r} is not there; {where}"))

    def _joint(self, element: Element, name: str, links: dict[str, Link]) -> Joint:
        given = element.attributes.get("type", "")
        if given not in KINDS:
            raise self._fault(element, f"joint {name!r} is of type {given!r}; allowed: {listed(KINDS)}")
        ends = {}
        for end in ("parent", "child"):
            part = element.find(end)
            link = "" if part is None else part.attributes.get("link", "")
            if link not in links:
                raise self._fault(element, f"joint {name!r}: its {end} {link!r} is no link{suggestion(link, links)}")
            ends[end] = link
        lower, upper, velocity, effort = self._limits(element, given)
        mimic = element.find("mimic")
        followed = None
        if mimic is not None:
            followed = (
                mimic.attributes.get("joint", ""),
                self._number(mimic, "multiplier", 1.0),
                self._number(mimic, "offset", 0.0),
            )
        return Joint(
            name,
            KINDS[given],
            ends["parent"],
            ends["child"],
            self._origin(element),
            (1.0, 0.0, 0.0) if given == "fixed" else self._axis(element),
            lower,
            upper,
            velocity,
            effort,
            followed if KINDS[given] != "fixed" else None,
        )

    def _limits(self, element: Element, kind: str) -> tuple[float, float, float, float]:
        """Lower, upper, velocity, effort; a speed or force of 0 means that none is given."""
        limit = element.find("limit")
        if limit is None:
            return -inf, inf, inf, inf
        velocity, effort = self._number(limit, "velocity", 0.0), self._number(limit, "effort", 0.0)
        rates = (velocity if velocity > 0.0 else inf, effort if effort > 0.0 else inf)
        if kind == "continuous":
            return (-inf, inf, *rates)
        lower, upper = self._number(limit, "lower", 0.0), self._number(limit, "upper", 0.0)
        given = [key for key in ("lower", "upper") if key in limit.attributes]
        name = element.attributes["name"]
        if len(given) == 1 and kind != "fixed":
            self._notes.append(self._note(limit, f"joint {name!r} has the limit {given[0]} alone; the other is 0"))
        if lower > upper and kind != "fixed":
            what = f"joint {name!r}: lower {lower:g} is above upper {upper:g}; it is taken to be unlimited"
            self._warnings.append(self._note(limit, what))
        if lower == upper == 0.0 and len(given) == 2 and kind != "fixed":
            self._notes.append(self._note(limit, f"joint {name!r}: limits of 0 and 0 stand for none"))
        # Exporters write 0 and 0 for none; PyBullet takes bounds in the wrong order for none.
        return (-inf, inf, *rates) if lower > upper or lower == upper == 0.0 else (lower, upper, *rates)

    def _axis(self, element: Element) -> tuple[float, float, float]:
        part = element.find("axis")
        if part is None:
            return (1.0, 0.0, 0.0)
        x, y, z = self._numbers(part, "xyz", None, 3)
        length = sqrt(x * x + y * y + z * z)
        if length < 1e-9:
            raise self._fault(part, "found an axis of zeros; it has no direction")
        if not length < LONGEST:
            x, y, z = rescaled((x, y, z))
            length = sqrt(x * x + y * y + z * z)
        return (x / length, y / length, z / length)

    def _origin(self, element: Element) -> FloatArray:
        pose = np.eye(4)
        origin = element.find("origin")
        if origin is not None:
            pose[:3, 3] = self._numbers(origin, "xyz", (0.0, 0.0, 0.0), 3)
            if np.abs(pose[:3, 3]).max() > MAX_LENGTH_M:
                raise self._fault(
                    origin, f"found {pose[:3, 3].tolist()} m; allowed are numbers within ±{MAX_LENGTH_M:g}"
                )
            pose[:3, :3] = self._rotation(origin)
        pose.flags.writeable = False
        return pose

    def _rotation(self, origin: Element) -> FloatArray:
        """From rpy [rad], or since URDF 1.1 from the quaternion quat_xyzw, which is normalised: (3, 3)."""
        if "quat_xyzw" not in origin.attributes:
            return matrix_of_rpy(*self._numbers(origin, "rpy", (0.0, 0.0, 0.0), 3))
        if self._version < (1, 1):
            what = 'found quat_xyzw, which readers of URDF 1.0 pass over; write rpy, or <robot version="1.1">'
            raise self._fault(origin, what)
        if "rpy" in origin.attributes:
            raise self._fault(origin, "found rpy and quat_xyzw; one of them is required")
        x, y, z, w = self._numbers(origin, "quat_xyzw", None, 4)
        if sqrt(x * x + y * y + z * z + w * w) < 1e-9:
            raise self._fault(origin, "found a quaternion of zeros; it has no direction")
        return matrix_of(normalised((w, x, y, z)))

    def _number(self, element: Element, key: str, default: float) -> float:
        return self._numbers(element, key, (default,), 1)[0]

    def _numbers(self, element: Element, key: str, default: tuple[float, ...] | None, count: int) -> tuple[float, ...]:
        text = element.attributes.get(key)
        if text is None and default is not None:
            return default
        try:
            values = tuple(float(part) for part in OPTENV.sub(r"\1", text or "").split())
        except ValueError:
            values = ()
        if len(values) != count or not all(isfinite(value) for value in values):
            raise self._fault(element, f"<{element.tag}> {key}: found {text!r}; {count} finite numbers are required")
        return values


# Attributes of each shape: name, default, how many numbers.
_SIZES: dict[str, tuple[tuple[str, tuple[float, ...] | None, int], ...]] = {
    "box": (("size", None, 3),),
    "sphere": (("radius", None, 1),),
    "cylinder": (("radius", None, 1), ("length", None, 1)),
    "capsule": (("radius", None, 1), ("length", None, 1)),
    "mesh": (("scale", (1.0, 1.0, 1.0), 3),),
}


def _resolved(name: str, urdf: Path, packages: PackageFinder) -> Path | None:
    """The file of a mesh: relative to the URDF, absolute, file:// or package://; None when there is none."""
    if not name or "\0" in name:
        return None
    scheme, separator, rest = name.partition("://")
    if not separator:
        return _existing(urdf.parent / name)
    if scheme == "file":
        return _existing(Path(rest))
    return packages.find(name)


def _found_now(name: str, urdf: Path) -> bool:
    """Whether a mesh that was not there has come; ROS is not searched again for those of its packages."""
    if name.startswith(SCHEME):
        return PackageFinder(urdf).find_above(name) is not None
    return _resolved(name, urdf, PackageFinder(urdf)) is not None


def _existing(path: Path) -> Path | None:
    return path.resolve() if path.is_file() else None
