"""Whether a problem's start and goal are free and within reach. `feasible` says no more than that."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing

import numpy as np

from pytest_lpb.problem.collision import CollisionSpace
from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import FloatArray, Robot, robot_from
from pytest_lpb.scenario.inverse_kinematics import goal_configurations

MOST_NAMED = 20  # pairs that overlap, in a message


def is_free(space: CollisionSpace, q: Sequence[float], margin: float) -> bool:
    """Whether the robot at q keeps `margin` [m] from obstacles and does not touch itself."""
    return not space.clearance(q)[0] < margin and not space.self_clearance(q)[0] < 0.0


def start_fault(robot: Robot, q: Sequence[float], obstacles: Sequence[Obstacle]) -> str | None:
    """What is wrong with a start, in words; None when it is free."""
    with closing(robot.collision_space(obstacles)) as space:
        distance, body, obstacle = space.clearance(q)
        if distance < -space.contact_slack_m:
            return (
                f"the start is in collision: {body!r} is {-distance:.3g} m inside obstacle {obstacle!r}; "
                "move the start or the obstacle"
            )
        distance, body, other = space.self_clearance(q)
        if distance < -space.contact_slack_m:
            return (
                f"the start is in self-collision: {body!r} is {-distance:.3g} m inside {other!r}; "
                f"choose another start, or{_way_out(robot, q, space.contact_slack_m)}"
            )
    return None


def _way_out(robot: Robot, q: Sequence[float], slack: float) -> str:
    """How to say that bodies may overlap that do so at q."""
    pairs = _overlapping(robot, q, slack)
    if isinstance(robot.entry.get("self_collision_pairs"), list):
        names = " and ".join(f"[{one}, {other}]" for one, other in pairs)
        return f" if they overlap by design, take {names} out of self_collision_pairs"
    names = ", ".join(f"[{one}, {other}]" for one, other in pairs)
    return f" if they overlap by design, robot: {{self_collision_pairs: {{except: [{names}]}}}}"


def _overlapping(robot: Robot, q: Sequence[float], slack: float) -> list[tuple[str, str]]:
    """Self-collision pairs that overlap at q by more than `slack` [m], the deepest first; at most `MOST_NAMED`."""
    pairs = list(robot.self_collision_pairs)
    found: list[tuple[str, str]] = []
    while pairs and len(found) < MOST_NAMED:
        rest = robot_from({**robot.entry, "self_collision_pairs": [list(pair) for pair in pairs]})
        with closing(rest.collision_space([])) as space:
            distance, one, other = space.self_clearance(q)
        if not distance < -slack:
            break
        found.append((one, other))
        pairs = [pair for pair in pairs if {*pair} != {one, other}]
    return found


def goal_fault(robot: Robot, goal: Sequence[SubGoal], start_q: FloatArray, obstacles: Sequence[Obstacle]) -> str | None:
    """What is wrong with the goal at t = 0, in words; None when the robot can be there without a collision.

    Moving targets and goals without a tolerance are not judged.
    """
    static = [sub_goal for sub_goal in goal if sub_goal.tolerance is not None and not sub_goal.moving]
    if not static:
        return None
    configurations = goal_configurations(robot, static, start_q)
    if not configurations:
        return f"the goal is out of reach: no configuration of {robot.name!r} has {_described(static)}"
    with closing(robot.collision_space([obstacle for obstacle in obstacles if not obstacle.moving])) as space:
        if any(is_free(space, q.tolist(), -space.contact_slack_m) for q in configurations):
            return None
        distance, body, obstacle = max(space.clearance(q.tolist()) for q in configurations)
        free = [q.tolist() for q in configurations if not space.clearance(q.tolist())[0] < 0.0]
        nearest = [(*space.self_clearance(q), q) for q in free]
    if distance < 0.0:
        return (
            f"the goal is in collision: wherever it is reached, {body!r} is {-distance:.3g} m or more inside "
            f"obstacle {obstacle!r}; move the goal or the obstacle"
        )
    _, one, other, q = max(nearest)
    return (
        f"the goal is in self-collision: {one!r} overlaps {other!r}, or other bodies of the robot each other, in every "
        f"configuration found; choose another goal, or{_way_out(robot, q, 0.0)}"
    )


def _described(goal: Sequence[SubGoal]) -> str:
    parts = []
    for sub_goal in goal:
        target = sub_goal.motion.evaluate(np.zeros(1))[0][0].tolist()
        within = " and ".join(f"{part.tolerance:g} {part.unit}" for part in sub_goal.components)
        parts.append(f"{sub_goal.name!r} within {within} of {target}")
    return " and ".join(parts)
