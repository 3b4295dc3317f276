"""Whether a problem's start and goal are free and within reach. `feasible` says no more than that."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing

import numpy as np

from pytest_lpb.problem.collision import CollisionSpace
from pytest_lpb.problem.goal import SubGoal
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import FloatArray, Robot
from pytest_lpb.scenario.inverse_kinematics import goal_configurations


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
                f"choose another start, or{_way_out(body, other)}"
            )
    return None


def _way_out(body: str, other: str) -> str:
    """How to say that two bodies may overlap."""
    return f" if they overlap by design, robot: {{self_collision_pairs: {{except: [[{body}, {other}]]}}}}"


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
        _, one, other = max(space.self_clearance(q.tolist()) for q in configurations)
    if distance < 0.0:
        return (
            f"the goal is in collision: wherever it is reached, {body!r} is {-distance:.3g} m or more inside "
            f"obstacle {obstacle!r}; move the goal or the obstacle"
        )
    return (
        f"the goal is in self-collision: {one!r} overlaps {other!r}, or other bodies of the robot each other, in every "
        f"configuration found; choose another goal, or{_way_out(one, other)}"
    )


def _described(goal: Sequence[SubGoal]) -> str:
    parts = []
    for sub_goal in goal:
        target = sub_goal.motion.evaluate(np.zeros(1))[0][0].tolist()
        within = " and ".join(f"{part.tolerance:g} {part.unit}" for part in sub_goal.components)
        parts.append(f"{sub_goal.name!r} within {within} of {target}")
    return " and ".join(parts)
