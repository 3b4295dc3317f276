"""Marks of goals against the goals' own errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytest_lpb.environment.goal_marks import goal_marks, traced_pose
from pytest_lpb.problem.spatial.goals import PositionGoal
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.rotations import matrix_of
from tests.problem.spatial.entries import Entry, panda_entry, problem_of

HAND: Entry = {"name": "reach", "type": "position", "link": "panda_hand", "tolerance": 0.07, "primary": True}
POSITIONS: dict[str, Entry] = {
    "fixed": {"target": [0.5, 0.2, 0.4]},
    "moving": {"trajectory": ["0.5 + 0.1*t", "0.2", "0.4*cos(t)"]},
    "of a point": {"target": [0.5, 0.2, 0.4], "point": [0.0, 0.03, 0.1]},
    "of two axes": {"target": [0.5, 0.4], "axes": [0, 2]},
    "relative": {"target": [0.1, 0.2, 0.3], "relative_to": "panda_link3"},
    "all of it": {"target": [0.1, 0.3], "axes": [1, 2], "relative_to": "panda_link3", "point": [0.0, 0.03, 0.1]},
}


@pytest.mark.parametrize("kind", POSITIONS)
def test_a_mark_is_as_far_away_as_the_error_says(tmp_path: Path, kind: str) -> None:
    problem = problem_of(tmp_path, panda_entry(goal=[{**HAND, **POSITIONS[kind]}]))
    robot, goal = problem.robot, problem.primary
    assert isinstance(robot, SpatialRobot)
    assert isinstance(goal, PositionGoal)
    generator = np.random.default_rng(0)
    for t in (0.0, 0.6):
        q = problem.start_q + generator.uniform(-0.3, 0.3, 7)
        frames = robot.link_frames(q)
        (mark,) = goal_marks(problem, t, frames)
        target = goal.motion.evaluate(np.array([t]))[0][0]
        error = goal.distance(goal.value(q.tolist(), robot.frames(q.tolist())), target.tolist())
        assert np.linalg.norm(mark.position - traced_pose(goal, problem, frames)[:3, 3]) == pytest.approx(error)
        assert mark.radius == 0.07
        assert mark.rotation is None


def test_an_orientation_is_shown_where_its_link_is_to_be(tmp_path: Path) -> None:
    turn = {"name": "turn", "type": "orientation", "target": [0.5, 0.5, 0.5, 0.5], "tolerance": 0.1}
    goals = [
        {**HAND, **POSITIONS["fixed"]},
        {**turn, "link": "panda_hand"},
        {**turn, "name": "two", "link": "panda_link4"},
    ]
    joint = {"name": "elbow", "type": "joint", "joints": ["panda_joint4"], "target": [-1.0]}
    problem = problem_of(tmp_path, panda_entry(goal=[*goals, joint]))
    robot = problem.robot
    assert isinstance(robot, SpatialRobot)
    frames = robot.link_frames(problem.start_q)
    position, hand, link4 = goal_marks(problem, 0.0, frames)
    assert position.rotation is None
    assert hand.position == pytest.approx([0.5, 0.2, 0.4])
    assert link4.position == pytest.approx(frames[robot.link_index("panda_link4"), :3, 3])
    for mark in (hand, link4):
        assert mark.rotation == pytest.approx(matrix_of([0.5, 0.5, 0.5, 0.5]))


def test_goals_of_no_link_trace_the_last_one(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, panda_entry())
    frames = np.arange(len(problem.robot.link_names) * 16.0).reshape(-1, 4, 4)
    assert traced_pose(problem.primary, problem, frames) == pytest.approx(frames[-1])
