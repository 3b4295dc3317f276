"""The robot of a scenario file, in the plane or in space: its structure and its concrete form."""

from __future__ import annotations

from pytest_lpb.errors import ScenarioError
from pytest_lpb.scenario.schema.robot import Robot
from pytest_lpb.scenario.structure import MODELS, Structure, planar_structure


def is_planar(robot: Robot) -> bool:
    """Whether the robot is of a planar model."""
    return robot.urdf is None and robot.model in MODELS


def structure_of(robot: Robot) -> Structure | None:
    """The structure of a robot that can be; None for others, whose faults a check tells."""
    if is_planar(robot):
        return planar_structure(robot)
    if (robot.model is None) == (robot.urdf is None):
        return None
    # Imported late: planar scenarios need none of it.
    from pytest_lpb.scenario.spatial import SpatialDescription

    try:
        return SpatialDescription(robot).structure
    except ScenarioError:
        return None
