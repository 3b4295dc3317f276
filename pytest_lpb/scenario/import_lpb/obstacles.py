"""Obstacles of an experiment as those of a scenario file: spheres, cylinders, boxes; in the plane their outlines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import atan2
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.names import is_name
from pytest_lpb.scenario.import_lpb.fields import Fields, ranges_between
from pytest_lpb.scenario.import_lpb.meshes import shape_of_urdf
from pytest_lpb.scenario.import_lpb.motions import LostError, motion_of

LEAST_RADIUS_M = 1e-3  # of drawn obstacles; zero is no radius here
_UPRIGHT = 1e-9  # largest x and y of the quaternion of an obstacle that is turned about z alone


@dataclass
class Obstacles:
    """What became of an experiment's `obstacles` and `randomObstacles`, as in `Goals`."""

    obstacles: list[dict[str, Any]] = field(default_factory=list)
    group: dict[str, Any] | None = None
    lost: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


Sized = dict[str, Any]


def _sphere(fields: Fields) -> Sized:
    return {"shape": "sphere", "radius": fields.number(fields.first("radius", "r"))}


def _cylinder(fields: Fields) -> Sized:
    return {"shape": "cylinder", "radius": fields.number("radius"), "length": fields.number("height")}


def _box(fields: Fields) -> Sized:
    return {"shape": "box", "size": [fields.number(side) for side in ("length", "width", "height")]}


# By what the names of types contain, in this order. A further shape is one entry here.
SHAPES: dict[str, Callable[[Fields], Sized]] = {"sphere": _sphere, "cylinder": _cylinder, "box": _box}
# By their keys, for obstacles without a type that names a shape: the first that has all of them.
_KEYS: tuple[tuple[tuple[str, ...], Callable[[Fields], Sized]], ...] = (
    (("length", "width", "height"), _box),
    (("radius", "height"), _cylinder),
    (("radius",), _sphere),
    (("r",), _sphere),
)


def obstacles_of(experiment: Fields, dimension: int, base: Path) -> Obstacles:
    """All obstacles, and the ranges of drawn ones; `base` is the scenario's folder. Raises LpbError for wrong ones."""
    result = Obstacles()
    given = experiment.below("obstacles").mappings()
    for name, fields in given.items():
        try:
            obstacle = _obstacle(fields, dimension, base, result)
        except LostError as error:
            result.lost.append(str(error))
            continue
        result.obstacles.append({"name": name if is_name(name) else f"obstacle{len(result.obstacles)}", **obstacle})
    result.group = _drawn(experiment.below("randomObstacles"), next(iter(given.values()), None), dimension, result)
    return result


def _obstacle(fields: Fields, dimension: int, base: Path, result: Obstacles) -> Sized:
    geometry = fields.below("geometry") if "geometry" in fields else fields
    sized = shape_of_urdf(fields, base) if "urdf" in fields else _reader(fields, geometry)(geometry)
    lengths = [sized.get("radius"), sized.get("length"), *sized.get("size", ())]
    if any(length is not None and length <= 0.0 for length in lengths):
        raise LostError(f"{fields.name}, whose size is not above 0")
    if fields.get("movable") is True:
        result.lost.append(f"{fields.name}.movable: nothing is pushed here")
    key = geometry.first("position", "x")
    size = _coordinates(geometry, key, dimension)
    place, notes = motion_of(geometry, key, "position", np.zeros(size), size)
    result.notes.extend(notes)
    if dimension == 3:
        return {**sized, **place, **_orientation(geometry)}
    return _section(fields, geometry, sized, place, result)


def _reader(fields: Fields, geometry: Fields) -> Callable[[Fields], Sized]:
    kind = str(fields.get("type") or "").lower()
    for name, read in SHAPES.items():
        if name in kind:
            return read
    known = kind in ("", "analytic", "spline", "static", "dynamic")
    for keys, read in _KEYS:
        if known and all(key in geometry for key in keys):
            return read
    raise LostError(f"{fields.name} of type {fields.get('type')!r}; converted are {', '.join(SHAPES)}, urdf")


def _coordinates(geometry: Fields, key: str, dimension: int) -> int:
    """How many coordinates the place of an obstacle has: 2 or 3 in the plane, 3 in space."""
    given = geometry.get("trajectory") if "trajectory" in geometry else geometry.get(key)
    return 3 if dimension == 3 or (isinstance(given, list) and len(given) == 3) else 2


def _quaternion(geometry: Fields) -> list[float]:
    if "orientation" not in geometry:
        return [1.0, 0.0, 0.0, 0.0]
    w, x, y, z = geometry.numbers("orientation", 4)
    if w * w + x * x + y * y + z * z < 1e-12:
        raise geometry.error("found a quaternion of length 0", "orientation")
    length = float(np.linalg.norm([w, x, y, z]))
    return [w / length, x / length, y / length, z / length]


def _orientation(geometry: Fields) -> dict[str, Any]:
    quaternion = _quaternion(geometry)
    return {"orientation": quaternion} if quaternion[1:] != [0.0, 0.0, 0.0] else {}


def _section(fields: Fields, geometry: Fields, sized: Sized, place: dict[str, Any], result: Obstacles) -> Sized:
    """The outline of an obstacle seen from above, for robots in the plane."""
    w, x, y, z = _quaternion(geometry)
    if sized["shape"] in ("mesh", "capsule"):
        raise LostError(f"{fields.name}, a {sized['shape']}, which the engine of its robot does not have")
    if sized["shape"] != "sphere" and max(abs(x), abs(y)) > _UPRIGHT:
        raise LostError(f"{fields.name}, a {sized['shape']} that is tilted out of the plane of its robot")
    flat = {key: [row[:3] for row in value] if key == "spline" else value[:2] for key, value in place.items()}
    heights = [row[3:] for row in place["spline"]] if "spline" in place else next(iter(place.values()))[2:]
    if sized["shape"] == "sphere" and not all(height in (0.0, "0", "0.0", [0.0], []) for height in heights):
        result.notes.append(f"{fields.name}: a sphere above or below its robot's plane, here a circle of its radius")
    if sized["shape"] == "box":
        angle = 2.0 * atan2(z, w)
        return {"shape": "rectangle", "size": sized["size"][:2], **flat, **({"orientation": angle} if angle else {})}
    return {"shape": "circle", "radius": sized["radius"], **flat}


def _drawn(given: Fields, first: Fields | None, dimension: int, result: Obstacles) -> dict[str, Any] | None:
    """Ranges of drawn obstacles: of the first listed one, or older files' own."""
    number = given.integer("number", 0)
    if number <= 0:
        return None
    if "limits" in given:
        place, radius = given.below("limits").below("x"), given.below("limits").below("r")
        position = ranges_between(place, "low", place, "high")
        radii = [radius.number("low"), radius.number("high")]
    elif first is not None and "low" in first and "high" in first:
        low, high = first.below("low"), first.below("high")
        if "radius" not in low or "radius" not in high or {"height", "length"} & set(low.data):
            result.lost.append(f"{given.name}: only spheres are drawn, {first.name} is none")
            return None
        position = ranges_between(low, "position", high, "position")
        radii = [low.number("radius"), high.number("radius")]
    else:
        result.lost.append(f"{given.name}.number: {number} drawn obstacles, for which there are no ranges")
        return None
    if len(position) < dimension:
        result.lost.append(f"{given.name}, whose ranges have {len(position)} coordinates; {dimension} are required")
        return None
    if len(position) > dimension and any(position[dimension]):
        result.notes.append(f"{given.name}: heights of drawn spheres; in the plane they are circles of their radius")
    if min(radii) < LEAST_RADIUS_M:
        result.notes.append(f"random obstacles of radius {min(radii):g}; the least is {LEAST_RADIUS_M:g} m")
    shape = "sphere" if dimension == 3 else "circle"
    radii = sorted(max(radius, LEAST_RADIUS_M) for radius in radii)
    return {"count": number, "shape": shape, "position": position[:dimension], "radius": radii}
