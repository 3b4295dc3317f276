"""The canonical form of a scenario: every default filled in, plain Python types only."""

from typing import Any

from pytest_lpb.problem.criterion import parse_criterion
from pytest_lpb.scenario.checks.goal import goal_names, primary_index
from pytest_lpb.scenario.checks.obstacles import obstacle_names
from pytest_lpb.scenario.robots import is_planar
from pytest_lpb.scenario.schema import ScenarioFile
from pytest_lpb.scenario.schema.environment import Environment, Start
from pytest_lpb.scenario.schema.goal import Goal, Tolerance
from pytest_lpb.scenario.schema.obstacle import AxisAngle, Obstacle
from pytest_lpb.scenario.schema.randomize import Randomize
from pytest_lpb.scenario.schema.robot import Robot
from pytest_lpb.scenario.schema.success import Success
from pytest_lpb.scenario.self_collision import concrete_pairs
from pytest_lpb.scenario.structure import Structure, planar_entry

DEFAULT_HOLD_TIME = 0.5  # [s]
DEFAULT_SUBSTEPS = 20  # of the physics per dt
DEFAULT_ORIENTATIONS: dict[int, Any] = {2: 0.0, 3: [1.0, 0.0, 0.0, 0.0]}  # by dimension: angle [rad], quaternion wxyz
HOLD_TO_THE_END = "end"

Plain = dict[str, Any]


def concrete_form(file: ScenarioFile, structure: Structure) -> Plain:
    """What `Problem.from_dict` reads; a scenario file of this content gives the same form again."""
    robot = planar_entry(file.robot) if is_planar(file.robot) else _spatial_robot(file.robot)
    robot["self_collision_pairs"] = concrete_pairs(file.robot, structure.links, structure.bodies)
    return {
        "version": 1,
        "description": file.description,
        "tags": list(file.tags),
        "robot": robot,
        "environment": _environment(file.environment),
        "start": _start(file.start, structure),
        "goal": _goals(file.goal),
        "obstacles": _obstacles(file.obstacles, structure.dimension),
        "seed": file.seed,
        "trials": file.trials,
        "success": _success(file.success, file.goal),
        **({} if file.certified is None else {"certified": file.certified.model_dump(exclude_none=True)}),
    }


def _spatial_robot(robot: Robot) -> Plain:
    # Imported late: planar scenarios need none of it.
    from pytest_lpb.scenario.spatial import SpatialDescription

    return SpatialDescription(robot).entry


def _environment(environment: Environment) -> Plain:
    plain = environment.model_dump(exclude={"substeps"})
    if environment.dynamics:
        plain["substeps"] = DEFAULT_SUBSTEPS if environment.substeps is None else environment.substeps
    return plain


def _start(start: Start, structure: Structure) -> Plain:
    velocity = getattr(start, structure.velocity_key)
    return {
        "q": list(start.q or [0.0] * structure.dof),
        structure.velocity_key: list(velocity or [0.0] * len(structure.actions)),
    }


def _goals(goals: list[Goal]) -> list[Plain]:
    primary = primary_index(goals)
    return [
        {
            "name": name,
            "type": goal.type,
            **_given(goal, leave=("name", "type", "tolerance", "weight", "primary", "periodic")),
            **_periodic(goal),
            "tolerance": _tolerance(goal),
            "weight": goal.weight,
            "primary": index == primary,
        }
        for index, (name, goal) in enumerate(zip(goal_names(goals), goals, strict=True))
    ]


def _tolerance(goal: Goal) -> float | Plain | None:
    """A tolerance as a number, unless its units differ in it."""
    if not isinstance(goal.tolerance, Tolerance):
        return goal.tolerance
    given = goal.tolerance.model_dump(exclude_none=True)
    return given if len(set(given.values())) > 1 else float(next(iter(given.values())))


def _given(part: Goal | Obstacle, leave: tuple[str, ...]) -> Plain:
    return {key: value for key, value in part.model_dump(exclude_none=True).items() if key not in leave}


def _periodic(part: Goal | Obstacle) -> Plain:
    if getattr(part, "spline", None) is None:
        return {}
    return {"periodic": bool(getattr(part, "periodic", None))}


def _obstacles(obstacles: list[Obstacle], dimension: int) -> list[Plain]:
    return [
        {
            "name": name,
            "shape": obstacle.shape,
            **_given(obstacle, leave=("name", "shape", "orientation", "periodic")),
            **_periodic(obstacle),
            "orientation": _orientation(obstacle, dimension),
        }
        for name, obstacle in zip(obstacle_names(obstacles), obstacles, strict=True)
    ]


def _orientation(obstacle: Obstacle, dimension: int) -> Any:
    given = obstacle.orientation
    if given is None:
        return DEFAULT_ORIENTATIONS[dimension]
    return given.model_dump() if isinstance(given, AxisAngle) else given


def _success(success: Success, goals: list[Goal]) -> Plain:
    moving = getattr(goals[primary_index(goals)], "target", ()) is None
    default = HOLD_TO_THE_END if moving else DEFAULT_HOLD_TIME
    plain: Plain = {"hold_time": default if success.hold_time is None else success.hold_time}
    if success.rate is not None:
        plain["rate"] = str(parse_criterion(success.rate))
    for name, text in (success.model_extra or {}).items():
        plain[name] = str(parse_criterion(text))
    return plain


def randomize_form(randomize: Randomize) -> Plain:
    """The ranges given, by part: start {q}, goal [ranges] or {q}, obstacles [groups]."""
    return randomize.model_dump(include={"start", "goal", "obstacles"}, exclude_none=True)
