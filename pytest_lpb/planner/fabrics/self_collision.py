"""Which parts of a robot may meet each other: what its self-collision leaves are of."""

from __future__ import annotations

from collections.abc import Iterator

import casadi
import numpy as np

from pytest_lpb.planner.fabrics.parts import Part, distance_between
from pytest_lpb.planner.fabrics.robot_parts import capsules_of
from pytest_lpb.problem.robot import FloatArray, Robot
from pytest_lpb.symbolic.kinematics import Frames

SAMPLES = 256  # configurations in which distances of pairs are looked at
OVERLAPPING = 0.3  # share of these above which a pair's capsules are too large to tell whether the links touch

PartPair = tuple[Part, Part]


def pairs_of(robot: Robot, reach: float) -> list[PartPair]:
    """Pairs of balls and capsules of the bodies in `self_collision_pairs` that come nearer than `reach` [m].

    Capsules hold more than their links: pairs of neighbours that overlap in most configurations are left out, as no
    distance between capsules says whether those links touch.
    """
    parts = capsules_of(robot)
    pairs = [
        (first, second)
        for one, other in robot.self_collision_pairs
        for first in parts.get(one, ())
        for second in parts.get(other, ())
    ]
    if not pairs:
        return []
    least = np.full(len(pairs), np.inf)
    overlapping = np.zeros(len(pairs))
    for distances in _distances(robot, pairs):
        least = np.minimum(least, distances)
        overlapping += distances < 0.0
    return [
        pair
        for pair, nearest, count in zip(pairs, least, overlapping, strict=True)
        if nearest < reach and count < OVERLAPPING * SAMPLES
    ]


def _distances(robot: Robot, pairs: list[PartPair]) -> Iterator[FloatArray]:
    """Distances [m] of all pairs in random configurations within the limits."""
    q = casadi.SX.sym("q", robot.dof)
    frames = Frames(robot, q)
    distances = casadi.vertcat(
        *(distance_between(first, second, (first.place(frames), second.place(frames))) for first, second in pairs)
    )
    function = casadi.Function("distances", [q], [distances], {"cse": True})
    limits = np.clip(robot.limits.position, -np.pi, np.pi)
    generator = np.random.Generator(np.random.PCG64(0))
    samples = limits[:, 0] + generator.random((SAMPLES, robot.dof)) * (limits[:, 1] - limits[:, 0])
    yield from np.array(function(samples.T)).T
