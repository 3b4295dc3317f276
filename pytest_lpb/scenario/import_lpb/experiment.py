"""Turns experiment files of localPlannerBench (exp.yaml) into scenario files.

What the formats share keeps the meaning it had there: bodies are spheres at link frames, trials run to their end
whatever happens, the goal counts as soon as it is reached. The rest is listed: what is lost, and what differs.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pytest_lpb.documents.reader import read_yaml
from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.errors import LpbError
from pytest_lpb.names import listed
from pytest_lpb.scenario.import_lpb.fields import Fields, ranges_between
from pytest_lpb.scenario.import_lpb.goals import goals_of
from pytest_lpb.scenario.import_lpb.obstacles import obstacles_of
from pytest_lpb.scenario.import_lpb.robots import BenchRobot, Frame, robot_of
from pytest_lpb.scenario.schema.environment import MAX_STEPS

CONTROLS = {"acc": "acceleration", "vel": "velocity"}
ENGINES = {2: "planar", 3: "pybullet"}
MAX_JOINTS = 100

CONVERTED = {"T", "dt", "robot_type", "n", "goal", "initState", "limits", "r_body", "obstacles", "randomObstacles"}
CONVERTED |= {"selfCollision", "control_mode", "urdf_file_name", "base_type", "collision_links"}
# These follow from the rest: the name of the environment, the frame and the wheels of a known robot, where links end.
IMPLIED = {"env", "dynamic", "defaults", "root_link", "ee_links", "actuated_wheels", "castor_wheels"}
IMPLIED |= {"wheel_radius", "wheel_distance", "not_actuated_joints", "spawn_offset"}


@dataclass
class Imported:
    """A scenario file's content, what could not be converted, and what means something slightly different."""

    content: dict[str, Any]
    lost: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def text(self, source: str) -> str:
        """The scenario file: what it came from, what is missing, what differs, the content."""
        lines = [f"# Imported from {source} of localPlannerBench."]
        lines += [f"# Not converted: {line}" for line in self.lost]
        lines += [f"# Differs: {line}" for line in self.notes]
        return "\n".join(lines) + "\n" + dump_yaml(self.content)


def import_experiment(path: Path, base: Path | None = None) -> Imported:
    """The scenario of an experiment file.

    Args:
        path: the experiment file.
        base: the folder that the scenario file will lie in, which names of meshes are relative to; default this one.

    Raises LpbError, with `file:line`, for a file that is none.
    """
    try:
        document = read_yaml(path.read_bytes(), str(path), "an experiment is a mapping with T, dt, robot_type, ...")
    except OSError as error:
        raise LpbError(f"{path}: cannot be read: {error.strerror or error}") from None
    fields = Fields(document, path)
    if "goal" not in fields and "initState" not in fields:
        raise fields.error("is no experiment of localPlannerBench: it has neither a goal nor an initState")
    return _converted(fields, Path.cwd() if base is None else base)


def _converted(fields: Fields, base: Path) -> Imported:
    robot, count = robot_of(fields), fields.integer("n")
    if not 1 <= count <= MAX_JOINTS:
        raise fields.error(f"found {count}; allowed: 1 to {MAX_JOINTS} joints", "n")
    goals = goals_of(fields, robot, count)
    obstacles = obstacles_of(fields, robot.dimension, base)
    result = Imported({}, [*goals.lost, *obstacles.lost], [*goals.notes, *obstacles.notes])
    result.content |= {
        "version": 1,
        "description": f"Imported from {fields.path.name} of localPlannerBench.",
        "robot": _robot(fields, robot, count, result),
        "environment": {"engine": ENGINES[robot.dimension], **_times(fields, result), "end_at": []},
        "start": _start(fields, robot, count, result),
        "goal": goals.goals,
        "obstacles": obstacles.obstacles,
        "success": {"hold_time": 0.0},
    }
    randomize = {"goal": goals.ranges} if goals.ranges is not None else {}
    if obstacles.group is not None:
        randomize |= {"obstacles": obstacles.group, "keep_obstacles": False}
    if randomize:
        result.content["randomize"] = randomize
    result.lost += [f"{key}, which has no meaning here" for key in fields.data if key not in CONVERTED | IMPLIED]
    return result


def _times(fields: Fields, result: Imported) -> dict[str, float]:
    dt, steps = fields.positive("dt"), fields.integer("T")
    if steps <= 0:
        raise fields.error(f"found {steps}; a number above 0 is required", "T")
    if steps > MAX_STEPS:
        result.lost.append(f"T: {steps} steps; a trial has at most {MAX_STEPS}")
    return {"dt": dt, "duration": round(min(steps, MAX_STEPS) * dt, 9)}


def _start(fields: Fields, robot: BenchRobot, count: int, result: Imported) -> dict[str, Any]:
    """The start: as many entries as the robot has here."""
    state = fields.below("initState")
    size = len(robot.joints(count))
    q, speeds = state.numbers("q0"), state.numbers("q0dot")
    if robot.note:
        result.notes.append(robot.note)
    wanted = robot.speeds or size
    q = q[:size] if len(q) == size + robot.unused else q
    if len(q) != size:
        raise state.error(f"found {len(q)} numbers; {size} are required: {', '.join(robot.joints(count))}", "q0")
    if len(speeds) > wanted and not any(speeds):
        speeds = speeds[:wanted]  # at rest, whatever is counted
    speeds = speeds[:wanted] if len(speeds) == wanted + robot.unused else speeds
    if len(speeds) != wanted:
        raise state.error(f"found {len(speeds)} numbers; {wanted} are required", "q0dot")
    return {"q": q, robot.velocity: speeds}


def _robot(fields: Fields, robot: BenchRobot, count: int, result: Imported) -> dict[str, Any]:
    """The `robot` section: its bodies are spheres of radius `r_body` at its frames."""
    control = str(fields.get("control_mode") or ("vel" if "-vel-" in str(fields.get("env")) else "acc"))
    if control not in CONTROLS:
        raise fields.error(f"found {control!r}; can be imported: {listed(CONTROLS)}", "control_mode")
    pairs = _pairs(fields, robot, count, result)
    section = robot.section(count) | {
        "control": CONTROLS[control],
        "collision": {"spheres": _spheres(fields, robot, count, [frame for pair in pairs for frame in pair], result)},
        "self_collision_pairs": [list(pair) for pair in dict.fromkeys((a.link, b.link) for a, b in pairs)],
    }
    limits = fields.below("limits")
    if limits.data:
        ranges = ranges_between(limits, "low", limits, "high")
        size = len(robot.joints(count))
        if len(ranges) < size:
            result.lost.append(f"limits of {len(ranges)} joints; the robot has {size}")
        else:
            section["limits"] = {"position": ranges[:size]}
    return section


def _spheres(
    fields: Fields, robot: BenchRobot, count: int, paired: list[Frame], result: Imported
) -> dict[str, list[list[float]]]:
    """Spheres per link: at all numbered frames but the first, or at the links that the file names."""
    radius = fields.positive("r_body")
    given = fields.get("collision_links")
    if isinstance(given, list) and given:
        frames = [robot.frame(fields, ["collision_links", index], link, count) for index, link in enumerate(given)]
    else:
        frames = list(robot.frames(count)[1:])
    more = [frame for frame in dict.fromkeys(paired) if frame not in frames]
    if more:
        names = ", ".join(dict.fromkeys(str(frame.link) for frame in more))
        result.notes.append(f"selfCollision.pairs: the spheres of {names}, which they need, count for obstacles, too")
    spheres: dict[str, list[list[float]]] = {}
    for frame in dict.fromkeys([*frames, *more]):
        if frame.link is not None:
            place = frame.point[: robot.dimension] if robot.dimension == 3 else (*frame.point[:2], 0.0)
            spheres.setdefault(frame.link, []).append([*place, radius])
    return spheres


def _pairs(fields: Fields, robot: BenchRobot, count: int, result: Imported) -> list[tuple[Frame, Frame]]:
    """Pairs of frames whose spheres must not touch."""
    collision = fields.below("selfCollision")
    given = collision.get("pairs") or []
    if not isinstance(given, list):
        raise collision.error("a list of pairs of links is required", "pairs")
    pairs = []
    for index, pair in enumerate(given):
        if not isinstance(pair, list) or len(pair) != 2:
            raise collision.error(f"found {pair!r}; two links are required", "pairs", index)
        first, second = (robot.frame(collision, ["pairs", index, side], link, count) for side, link in enumerate(pair))
        if first.link is None or second.link is None:
            result.lost.append(f"selfCollision.pairs[{index}], one of which is the world's origin, no body")
        elif first.link == second.link:
            result.lost.append(f"selfCollision.pairs[{index}], both of which move with {first.link}")
        else:
            pairs.append((first, second))
    return pairs
