"""Which parts of a robot may meet each other: what its self-collision leaves are of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import casadi
import numpy as np
from numpy.typing import NDArray

from pytest_lpb.planner.scene.parts import Part, distance_between
from pytest_lpb.planner.scene.robot_parts import Taken, balls_of, capsules_of
from pytest_lpb.problem.robot import FloatArray, Robot
from pytest_lpb.problem.spatial.robot import SpatialRobot
from pytest_lpb.symbolic.kinematics import Frames

SAMPLES = 256  # configurations in which distances of pairs are looked at
FALSE_OF_CAPSULES = 0.1  # share of these in which capsules may overlap while their links do not
FALSE_OF_BALLS = 0.02  # the same of two balls

PartPair = tuple[Part, Part]
BodyPair = tuple[str, str]
Bodies = Mapping[str, Sequence[Part]]


def pairs_of(robot: Robot, parameters: Taken) -> list[PartPair]:
    """Pairs of parts of the bodies in `self_collision_pairs` that come nearer than `self_collision_reach`.

    They are the capsules that hold the bodies. In space capsules hold more than their links: where they often overlap
    while the links do not touch, the smaller balls that cover the links take their place, but for those that do so too.
    """
    samples = _samples(robot)
    capsules = _met(robot, robot.self_collision_pairs, capsules_of(robot), parameters, samples)
    if not isinstance(robot, SpatialRobot):
        return [met.pair for met in capsules]
    untold = list(dict.fromkeys(met.bodies for met in capsules if met.overlaps.mean() >= FALSE_OF_CAPSULES))
    untold = [bodies for bodies in untold if _false(robot, bodies, capsules, samples) >= FALSE_OF_CAPSULES]
    told = [met.pair for met in capsules if met.bodies not in untold]
    balls = _met(robot, untold, balls_of(robot, parameters), parameters, samples)
    touching = _touching(robot, untold, samples)
    return told + [met.pair for met in balls if not _misleads(met, touching[met.bodies])]


@dataclass(frozen=True)
class _Met:
    """A pair of parts that comes near, and in which configurations they overlap."""

    pair: PartPair
    overlaps: NDArray[np.bool_]  # (SAMPLES,)

    @property
    def bodies(self) -> BodyPair:
        return self.pair[0].body, self.pair[1].body


def _false(robot: SpatialRobot, bodies: BodyPair, found: Sequence[_Met], samples: FloatArray) -> float:
    """Share of configurations in which parts of two bodies overlap while the bodies do not."""
    overlap = np.any([met.overlaps for met in found if met.bodies == bodies], axis=0)
    return float((overlap & ~_touching(robot, [bodies], samples)[bodies]).mean())


def _misleads(met: _Met, touching: NDArray[np.bool_]) -> bool:
    """Whether two balls overlap in many configurations, mostly while their bodies do not."""
    false, true = met.overlaps & ~touching, met.overlaps & touching
    return bool(false.mean() >= FALSE_OF_BALLS and false.sum() > true.sum())


def _touching(robot: SpatialRobot, pairs: Sequence[BodyPair], samples: FloatArray) -> dict[BodyPair, NDArray[np.bool_]]:
    """In which configurations bodies overlap, (SAMPLES,) each."""
    from pytest_lpb.problem.spatial.space import overlaps  # late: it needs PyBullet

    return dict(zip(pairs, overlaps(robot, pairs, samples).T, strict=True)) if pairs else {}


def _met(robot: Robot, pairs: Sequence[BodyPair], parts: Bodies, parameters: Taken, samples: FloatArray) -> list[_Met]:
    """Pairs of parts that come near."""
    made = [pair for first, second in pairs for pair in product(parts.get(first, ()), parts.get(second, ()))]
    if not made:
        return []
    distances = _distances(robot, made, samples)
    near = distances.min(axis=0) < parameters.self_collision_reach
    return [_Met(pair, column < 0.0) for pair, column, kept in zip(made, distances.T, near, strict=True) if kept]


def _samples(robot: Robot) -> FloatArray:
    """Configurations within the limits, the same each time; a turn of what has no limits."""
    lower, upper = robot.limits.position.T
    lowest = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - 2.0 * np.pi, -np.pi))
    highest = np.where(np.isfinite(upper), upper, lowest + 2.0 * np.pi)
    samples: FloatArray = lowest + np.random.Generator(np.random.PCG64(0)).random((SAMPLES, robot.dof)) * (
        highest - lowest
    )
    return samples


def _distances(robot: Robot, pairs: list[PartPair], samples: FloatArray) -> FloatArray:
    """Distances (SAMPLES, pairs) [m]."""
    q = casadi.SX.sym("q", robot.dof)
    frames = Frames(robot, q)
    distances = casadi.vertcat(
        *(distance_between(first, second, (first.place(frames), second.place(frames))) for first, second in pairs)
    )
    function = casadi.Function("distances", [q], [distances], {"cse": True})
    result: FloatArray = np.array(function(samples.T)).T
    return result
