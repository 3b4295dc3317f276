"""Which parts of a robot may meet each other: what its self-collision leaves are of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import casadi
import numpy as np

from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.fabrics.parts import Part, distance_between
from pytest_lpb.planner.fabrics.robot_parts import balls_of, capsules_of
from pytest_lpb.problem.robot import FloatArray, Robot
from pytest_lpb.symbolic.kinematics import Frames

SAMPLES = 256  # configurations in which distances of pairs are looked at
CAPSULES_OVERLAP = 0.3  # share of these from which on a pair's capsules do not tell whether the links touch
BALLS_OVERLAP = 0.02  # the same of two balls

PartPair = tuple[Part, Part]
Bodies = Mapping[str, Sequence[Part]]


def pairs_of(robot: Robot, parameters: FabricsParameters) -> list[PartPair]:
    """Pairs of parts of the bodies in `self_collision_pairs` that come nearer than `self_collision_reach`.

    They are the capsules that hold the bodies. Capsules hold more than their links: where those of neighbours overlap
    in many configurations, the smaller balls that cover the links take their place, but for those that overlap too.
    """
    capsules = _met(robot, robot.self_collision_pairs, capsules_of(robot), parameters)
    told, untold = _split(capsules, CAPSULES_OVERLAP)
    if not untold:
        return told
    bodies = list(dict.fromkeys((first.body, second.body) for first, second in untold))
    return told + _split(_met(robot, bodies, balls_of(robot, parameters), parameters), BALLS_OVERLAP)[0]


def _met(
    robot: Robot, pairs: Sequence[tuple[str, str]], parts: Bodies, parameters: FabricsParameters
) -> list[tuple[PartPair, float]]:
    """Pairs of parts that come near, with the share of configurations in which they overlap."""
    made = [pair for first, second in pairs for pair in product(parts.get(first, ()), parts.get(second, ()))]
    if not made:
        return []
    distances = _distances(robot, made)
    shares = (distances < 0.0).mean(axis=0)
    near = distances.min(axis=0) < parameters.self_collision_reach
    return [(pair, float(share)) for pair, share, kept in zip(made, shares, near, strict=True) if kept]


def _split(pairs: Sequence[tuple[PartPair, float]], most: float) -> tuple[list[PartPair], list[PartPair]]:
    """Pairs that overlap in less than a share of configurations, and the others."""
    return [pair for pair, share in pairs if share < most], [pair for pair, share in pairs if share >= most]


def _distances(robot: Robot, pairs: list[PartPair]) -> FloatArray:
    """Distances (SAMPLES, pairs) [m] in random configurations within the limits."""
    q = casadi.SX.sym("q", robot.dof)
    frames = Frames(robot, q)
    distances = casadi.vertcat(
        *(distance_between(first, second, (first.place(frames), second.place(frames))) for first, second in pairs)
    )
    function = casadi.Function("distances", [q], [distances], {"cse": True})
    limits = np.clip(robot.limits.position, -np.pi, np.pi)
    generator = np.random.Generator(np.random.PCG64(0))
    samples = limits[:, 0] + generator.random((SAMPLES, robot.dof)) * (limits[:, 1] - limits[:, 0])
    result: FloatArray = np.array(function(samples.T)).T
    return result
