"""Which parts of a robot keep away from each other."""

from __future__ import annotations

from typing import Any

import casadi
import numpy as np
import pytest

from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.scene.maps import State
from pytest_lpb.planner.scene.parts import Ball, Segment, distance_between
from pytest_lpb.planner.scene.self_collision import PartPair, pairs_of
from pytest_lpb.problem.robot import Robot, robot_from
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.problem.spatial.space import overlaps
from tests.planner import problems
from tests.planner.scene.making import Entry, act, goal, planar, spatial
from tests.problem.spatial.robots import ENTRIES

ARM = problems.arm(0.6, 0.5, 0.4)


def arm(*pairs: list[str]) -> Robot:
    return robot_from(planar(ARM, self_collision_pairs=list(pairs)))


def pairs(robot: Robot, **parameters: Any) -> list[PartPair]:
    return pairs_of(robot, FabricsParameters(**parameters))


def test_robots_whose_bodies_may_meet_have_no_pairs() -> None:
    assert pairs(arm()) == []


def test_only_pairs_that_come_near_count() -> None:
    # Link 2 starts 0.6 m from the base and is 0.5 m long: it never touches the base. Link 3 can.
    robot = arm(["base", "link2"], ["base", "link3"])
    assert [(one.body, other.body) for one, other in pairs(robot)] == [("base", "link2"), ("base", "link3")]
    assert [(one.body, other.body) for one, other in pairs(robot, self_collision_reach=0.0)] == [("base", "link3")]


def test_bodies_of_which_links_are_told_apart_by_capsules_are_capsules() -> None:
    ((one, other),) = pairs(arm(["link1", "link3"]))
    assert isinstance(one, Segment)
    assert isinstance(other, Segment)


def test_balls_take_the_place_of_capsules_that_mostly_overlap() -> None:
    # A capsule around the box that carries the arm reaches far above it.
    robot = robot_from(spatial(ENTRIES["arm on a car"], self_collision_pairs=[["mobile_base", "link2"]]))
    found = pairs(robot)
    assert found
    assert all(isinstance(one, Ball) and isinstance(other, Ball) for one, other in found)
    assert {(one.body, other.body) for one, other in found} == {("mobile_base", "link2")}
    # Those that often overlap do so mostly where the bodies touch.
    state = State(robot)
    distances = [
        distance_between(one, other, [part.place(state.frames) for part in (one, other)]) for one, other in found
    ]
    function = casadi.Function("distances", [state.q], [casadi.vertcat(*distances)])
    samples = np.random.default_rng(0).uniform(-np.pi, np.pi, (300, robot.dof))
    assert isinstance(robot, SpatialRobot)
    touching = overlaps(robot, [("mobile_base", "link2")], samples)[:, 0]
    for share in np.hstack([np.array(function(q)) for q in samples]) < 0.0:
        assert (share & ~touching).mean() < 0.05 or (share & touching).sum() > 0.7 * (share & ~touching).sum()
    assert 0.0 < touching.mean() < 0.9


def test_balls_of_some_pairs_leave_the_capsules_of_others() -> None:
    bodies = [["base", "link3"], ["mobile_base", "link2"]]
    found = pairs(robot_from(spatial(ENTRIES["arm on a car"], self_collision_pairs=bodies)))
    assert {(one.body, other.body) for one, other in found} == {("base", "link3"), ("mobile_base", "link2")}
    assert all(isinstance(other, Segment) is (other.body == "link3") for _, other in found)


@pytest.mark.parametrize(("leaf", "apart"), [("soft_barrier", True), ("none", False)])
def test_a_geometry_keeps_bodies_apart_and_none_has_no_leaf(leaf: str, apart: bool) -> None:
    names = ["joint1", "joint2", "joint3"]
    state = ([0.3, 2.0, 1.9], [0.0, 0.5, 0.7])
    goals = [goal("joint", [0.0, 0.0, 0.0], joints=names)]
    alone, together = (
        act(planar(ARM, self_collision_pairs=bodies), *state, goals, self_collision_geometry=leaf)
        for bodies in ([], [["base", "link3"]])
    )
    assert bool(np.abs(together - alone).max() > 1e-3) is apart


def test_distances_are_sampled_where_joints_can_be() -> None:
    # With joint 3 stretched link 3 cannot reach back to the base.
    stretched: Entry = {"position": [None, None, [-0.1, 0.1]]}
    robot = robot_from(planar(ARM, self_collision_pairs=[["base", "link3"]], limits=stretched))
    assert pairs(robot, self_collision_reach=0.05) != []
    bent: Entry = {"position": [None, [-0.5, 0.5], [-0.1, 0.1]]}
    assert pairs(robot_from({**robot.entry, "limits": bent}), self_collision_reach=0.05) == []
