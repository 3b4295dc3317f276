"""Reads URDF files: XML of links and joints. Faults name file and line."""

from __future__ import annotations

import re
from functools import lru_cache
from math import inf, isfinite, sqrt
from pathlib import Path

import numpy as np

from pytest_lpb.bounded import read_bounded, regular_file
from pytest_lpb.errors import ScenarioError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.problem.robot import FloatArray
from pytest_lpb.problem.spatial.rotations import matrix_of_rpy
from pytest_lpb.problem.spatial.urdf import Geometry, Inertial, Joint, Link, UrdfModel
from pytest_lpb.problem.spatial.urdf_tree import in_tree_order
from pytest_lpb.problem.spatial.xml_reader import Element, parse_xml

MAX_URDF_BYTES = 10_000_000
MAX_LINKS = 2_000
MAX_LENGTH_M = 1e4

# What roslaunch would replace: the default of an environment variable.
OPTENV = re.compile(r"\$\(optenv\s+\S+\s*(.*)\)")

KINDS = {"fixed": "fixed", "revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic"}


def load_urdf(path: Path) -> UrdfModel:
    """The robot of a URDF file; a file that has not changed is read once.

    Raises ScenarioError, with `file:line` where there is one, for a file that is no URDF, a missing mesh, unknown
    links, a joint type that cannot be simulated, several roots or a loop.
    """
    path = Path(path).absolute()
    stat = regular_file(path, ScenarioError)
    return _load(path, stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=64)
def _load(path: Path, _changed: int, _size: int) -> UrdfModel:
    return _Reader(path).model()


class _Reader:
    """One file being read."""

    def __init__(self, path: Path) -> None:
        self._path = path
        root = parse_xml(read_bounded(path, MAX_URDF_BYTES, ScenarioError), path)
        if root.tag != "robot":
            hint = "; run xacro on it first" if path.suffix == ".xacro" else ""
            raise self._fault(root, f"found <{root.tag}>; a URDF file has a <robot>{hint}")
        if any(child.tag.startswith("xacro:") for child in root.children):
            raise self._fault(root, "found xacro macros; run xacro on it first and use what it writes")
        self._root = root
        self._colors = {
            element.attributes.get("name", ""): color
            for element in root.all("material")
            if (color := self._color(element)) is not None
        }

    def _fault(self, element: Element, what: str) -> ScenarioError:
        return ScenarioError(f"{self._path}:{element.line}: {what}")

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
        for element in self._root.all("joint"):
            mimic = joints[element.attributes["name"]].mimic
            if mimic is not None and mimic[0] not in joints:
                raise self._fault(element, f"mimics {mimic[0]!r}, which is no joint{suggestion(mimic[0], joints)}")
            if mimic is not None and joints[mimic[0]].mimic is not None:
                raise self._fault(
                    element, f"mimics {mimic[0]!r}, which mimics another; name the one that moves by itself"
                )
        ordered_links, ordered_joints = in_tree_order(links, joints, self._path)
        return UrdfModel(self._root.attributes.get("name", self._path.stem), ordered_links, ordered_joints, self._path)

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
            tuple(self._geometry(part) for part in element.all("visual")),
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
        file = self._mesh(shape) if shape.tag == "mesh" else None
        return Geometry(
            shape.tag, size, self._origin(element), file, self._material(element.find("material")), shape.line
        )

    def _material(self, element: Element | None) -> tuple[float, float, float, float] | None:
        if element is None:
            return None
        return self._color(element) or self._colors.get(element.attributes.get("name", ""))

    def _color(self, element: Element) -> tuple[float, float, float, float] | None:
        color = element.find("color")
        if color is None:
            return None
        r, g, b, a = self._numbers(color, "rgba", None, 4)
        return (r, g, b, a)

    def _mesh(self, shape: Element) -> Path:
        name = shape.attributes.get("filename", "")
        found = _resolved(name, self._path)
        if found is None:
            raise self._fault(shape, f"the mesh {name!r} is not there; looked for it from {self._path.parent}")
        return found

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
        # As PyBullet and others read it: limits that leave no motion are none.
        return (lower, upper, *rates) if lower < upper else (-inf, inf, *rates)

    def _axis(self, element: Element) -> tuple[float, float, float]:
        part = element.find("axis")
        if part is None:
            return (1.0, 0.0, 0.0)
        x, y, z = self._numbers(part, "xyz", None, 3)
        length = sqrt(x * x + y * y + z * z)
        if length < 1e-9:
            raise self._fault(part, "found an axis of zeros; it has no direction")
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
            pose[:3, :3] = matrix_of_rpy(*self._numbers(origin, "rpy", (0.0, 0.0, 0.0), 3))
        pose.flags.writeable = False
        return pose

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


def _resolved(name: str, urdf: Path) -> Path | None:
    """The file of a mesh: relative to the URDF, absolute, file:// or package://; None when there is none."""
    scheme, separator, rest = name.partition("://")
    if not separator:
        return _existing(urdf.parent / name)
    if scheme == "file":
        return _existing(Path(rest))
    package, _, inside = rest.partition("/")
    for folder in urdf.parents:
        for candidate in (folder / inside if folder.name == package else None, folder / package / inside):
            if candidate is not None and candidate.is_file():
                return candidate.resolve()
        # A package's folder may have another name than the package.
        if (folder / "package.xml").is_file() and (folder / inside).is_file():
            return (folder / inside).resolve()
    return None


def _existing(path: Path) -> Path | None:
    return path.resolve() if path.is_file() else None
