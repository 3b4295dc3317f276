"""Turns experiment files of localPlannerBench (exp.yaml) into scenario files.

What the formats share is carried over, in the meaning it had there: bodies are spheres at the link frames, trials run
to their end whatever happens, the goal counts as soon as it is reached. The rest is listed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.documents.reader import Document, read_yaml
from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.errors import LpbError, ScenarioError
from pytest_lpb.motion import ExpressionMotion
from pytest_lpb.names import is_name, listed, suggestion

Plain = dict[str, Any]

LEAST_RADIUS_M = 1e-3  # of drawn obstacles; zero is no radius here
SPLINE_ROWS = 31  # a spline is given by this many points on it
PANDA_FLANGE = 7  # number of the last frame of its chain there; panda_link8 here
CARRIED = {"T", "dt", "robot_type", "n", "goal", "initState", "limits", "r_body", "obstacles", "randomObstacles"}
CARRIED |= {"selfCollision", "control_mode"}
IMPLIED = {"env", "dynamic", "defaults"}  # follow from the rest
CONTROLS = {"acc": "acceleration", "vel": "velocity"}


@dataclass(frozen=True)
class RobotType:
    """A robot there, and what it is here: its `robot` section, and the name of its k-th link frame of n."""

    robot: Callable[[int], Plain]
    link: Callable[[int, int], str]
    engine: str
    shape: str  # of obstacles
    velocity: str = "qd"


def _arm_link(number: int, count: int) -> str:
    return "base" if number == 0 else "end" if number == count else f"link{number + 1}"


def _panda_link(number: int, _: int) -> str:
    return "panda_link8" if number == PANDA_FLANGE else f"panda_link{number}"


_POINT = RobotType(lambda _: {"model": "point"}, lambda *_: "body", "planar", "circle")
_CART = RobotType(lambda _: {"model": "differential_drive"}, lambda *_: "base", "planar", "circle", "u")
# A further robot of localPlannerBench is one entry here.
ROBOT_TYPES: dict[str, RobotType] = {
    "pointRobot": _POINT,
    "pointMass": _POINT,
    "planarArm": RobotType(lambda count: {"model": "planar_arm", "links": count}, _arm_link, "planar", "circle"),
    "panda": RobotType(lambda _: {"model": "panda"}, _panda_link, "pybullet", "sphere"),
    "boxer": _CART,
    "groundRobot": _CART,
}


@dataclass
class Imported:
    """A scenario file's content, and what could not be carried over."""

    content: Plain
    left_out: list[str] = field(default_factory=list)

    def text(self, source: str) -> str:
        """The scenario file: what it came from, what is missing, the content."""
        lines = [f"# Imported from {source} of localPlannerBench."]
        lines += [f"# Not carried over: {line}" for line in self.left_out]
        return "\n".join(lines) + "\n" + dump_yaml(self.content)


def import_experiment(path: Path) -> Imported:
    """The scenario of an experiment file. Raises LpbError, with `file:line`, for a file that is none."""
    try:
        document = read_yaml(path.read_bytes(), str(path))
    except OSError as error:
        raise LpbError(f"{path}: cannot be read: {error.strerror or error}") from None
    return _Import(document, path).run()


class _Import:
    """One file on its way."""

    def __init__(self, document: Document, path: Path) -> None:
        self._document = document
        self._path = path
        self._data: Plain = document.data
        self.left_out: list[str] = []
        if not isinstance(self._data, dict):
            raise self._fault((), "is no experiment file: a mapping is required")
        name = self._needed("robot_type")
        if name not in ROBOT_TYPES:
            hint = suggestion(str(name), ROBOT_TYPES)
            raise self._fault(("robot_type",), f"found {name!r}{hint}; can be imported: {listed(ROBOT_TYPES)}")
        self._type = ROBOT_TYPES[name]
        self._count = int(self._needed("n"))

    def _fault(self, place: Sequence[str | int], what: str) -> LpbError:
        key = f"{'.'.join(map(str, place))}: " if place else ""
        return LpbError(f"{self._path}:{self._document.line_of(place)}: {key}{what}")

    def _needed(self, *place: str) -> Any:
        value: Any = self._data
        for depth, key in enumerate(place):
            if not isinstance(value, Mapping) or key not in value:
                raise self._fault(place[: depth + 1], "is missing; experiments of localPlannerBench have it")
            value = value[key]
        return value

    def run(self) -> Imported:
        """The whole scenario."""
        try:
            content = self._content()
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise self._fault((), f"is not as experiments of localPlannerBench are: {error!r}") from None
        for key in self._data:
            if key not in CARRIED | IMPLIED:
                self.left_out.append(f"{key}, which has no meaning here")
        return Imported(content, self.left_out)

    def _content(self) -> Plain:
        dt, start = float(self._needed("dt")), self._needed("initState")
        goals, ranges = self._goals()
        content: Plain = {
            "version": 1,
            "description": f"Imported from {self._path.name} of localPlannerBench.",
            "robot": self._robot(),
            "environment": {
                "engine": self._type.engine,
                "dt": dt,
                "duration": round(int(self._needed("T")) * dt, 9),
                "end_at": [],
            },
            "start": {"q": _floats(start["q0"]), self._type.velocity: _floats(start["q0dot"])},
            "goal": goals,
            "obstacles": self._obstacles(),
            "success": {"hold_time": 0.0},
        }
        randomize = ranges | self._random_obstacles()
        return content | ({"randomize": randomize} if randomize else {})

    def _robot(self) -> Plain:
        data, count = self._data, self._count
        limits = data.get("limits")
        pairs = (data.get("selfCollision") or {}).get("pairs") or []
        control = str(data.get("control_mode", "vel" if "-vel-" in str(data.get("env")) else "acc"))
        if control not in CONTROLS:
            raise self._fault(("control_mode",), f"found {control!r}; can be imported: {listed(CONTROLS)}")
        robot = self._type.robot(count) | {
            "control": CONTROLS[control],
            "collision": {"link_spheres": float(self._needed("r_body"))},
            "self_collision_pairs": [[self._type.link(int(k), count) for k in pair] for pair in pairs],
        }
        if limits:
            position = [list(pair) for pair in zip(_floats(limits["low"]), _floats(limits["high"]), strict=True)]
            robot["limits"] = {"position": position}
        return robot

    def _goals(self) -> tuple[list[Plain], Plain]:
        """The sub-goals, and the ranges of the primary one."""
        goals: list[Plain] = []
        ranges: Plain = {}
        for name, given in self._needed("goal").items():
            if int(given.get("parent_link", 0)) != 0:
                self.left_out.append(f"goal.{name}, which is relative to a link in the world's axes")
                continue
            target = self._motion(given, "desired_position", "target", f"goal.{name}")
            if target is None:
                continue
            primary = bool(given.get("is_primary_goal", given.get("prime", False)))
            goal = {
                "name": name if is_name(name) else f"goal{len(goals)}",
                "type": "position",
                "link": self._type.link(int(given["child_link"]), self._count),
                **target,
                "weight": float(given.get("weight", given.get("w", 1.0))),
                "primary": primary,
            }
            indices = [int(index) for index in given["indices"]]
            if indices != list(range(3 if self._type.engine == "pybullet" else 2)):
                goal["axes"] = indices
            if "epsilon" in given:
                goal["tolerance"] = float(given["epsilon"])
            goals.append(goal)
            if primary and "low" in given and "high" in given and "target" in target:
                ranges["goal"] = [list(p) for p in zip(_floats(given["low"]), _floats(given["high"]), strict=True)]
        if not goals:
            raise self._fault(("goal",), "no sub-goal of it can be carried over")
        if all("tolerance" not in goal for goal in goals):
            raise self._fault(("goal",), "no sub-goal has an epsilon; success is undefined without")
        return goals, ranges

    def _obstacles(self) -> list[Plain]:
        obstacles: list[Plain] = []
        for name, given in (self._data.get("obstacles") or {}).items():
            geometry = given.get("geometry", given)
            place = self._motion(
                geometry, "position" if "position" in geometry else "x", "position", f"obstacles.{name}"
            )
            radius = float(geometry.get("radius", geometry.get("r", 0.0)))
            if place is not None and radius > 0.0:
                shape = {"name": name if is_name(name) else f"obstacle{len(obstacles)}", "shape": self._type.shape}
                obstacles.append({**shape, "radius": radius, **place})
        return obstacles

    def _motion(self, given: Mapping[str, Any], fixed: str, key: str, what: str) -> Plain | None:
        """Where something is, as a scenario file says it; None, and a note, when it cannot be said."""
        trajectory, place = given.get("trajectory"), given.get(fixed)
        spline = next((part for part in (trajectory, place) if isinstance(part, Mapping)), None)
        if spline is not None:
            self.left_out.append(f"{what}: the spline's own form; {SPLINE_ROWS} points on it are given instead")
            return {"spline": _on_spline(spline)}
        if trajectory is not None:
            texts = [str(text) for text in trajectory]
            try:
                ExpressionMotion(texts)
            except ScenarioError as error:
                self.left_out.append(f"{what}, whose trajectory cannot be read: {error}")
                return None
            return {"trajectory": texts}
        if place is None:
            self.left_out.append(f"{what}, which has neither a position nor a trajectory")
            return None
        return {key: _floats(place)}

    def _random_obstacles(self) -> Plain:
        """Ranges of drawn obstacles: of the first listed one, or older files' own."""
        given = self._data.get("randomObstacles") or {}
        listed_ones = list((self._data.get("obstacles") or {}).values())
        low, high = self._ranges(given.get("limits"), listed_ones[0] if listed_ones else {})
        if not given.get("number") or not low:
            return {}
        radius = [max(float(low[1]), LEAST_RADIUS_M), max(float(high[1]), LEAST_RADIUS_M)]
        if float(low[1]) < LEAST_RADIUS_M:
            self.left_out.append(f"random obstacles of radius {low[1]:g}; the least is {LEAST_RADIUS_M:g} m")
        position = [list(pair) for pair in zip(_floats(low[0]), _floats(high[0]), strict=True)]
        group = {"count": int(given["number"]), "shape": self._type.shape, "position": position, "radius": radius}
        return {"obstacles": group, "keep_obstacles": False}

    @staticmethod
    def _ranges(limits: Any, first: Mapping[str, Any]) -> tuple[Any, Any]:
        """(position, radius) of the lower and the upper bounds; empty where none are given."""
        if limits:
            return (limits["x"]["low"], limits["r"]["low"]), (limits["x"]["high"], limits["r"]["high"])
        if "low" in first and "high" in first:
            return tuple((first[end]["position"], first[end]["radius"]) for end in ("low", "high"))  # type: ignore[return-value]
        return (), ()


def _floats(values: Sequence[Any]) -> list[float]:
    return [float(value) for value in values]


def _on_spline(given: Mapping[str, Any]) -> list[list[float]]:
    """Rows [t, x, y, ..] on a clamped B-spline of control points, a degree and a duration [s]."""
    from scipy.interpolate import BSpline  # late: only files with splines need it

    points = np.array(given.get("ctrlpts", given.get("controlPoints")), dtype=float)
    degree, duration = int(given["degree"]), float(given["duration"])
    inner = np.linspace(0.0, duration, len(points) - degree + 1)
    curve = BSpline(np.concatenate([[0.0] * degree, inner, [duration] * degree]), points, degree)
    times = np.linspace(0.0, duration, SPLINE_ROWS)
    rows: list[list[float]] = np.round(np.column_stack([times, curve(times)]), 9).tolist()
    return rows
