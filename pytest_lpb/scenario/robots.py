"""The robot of a scenario file, in the plane or in space: its structure and its concrete form."""

from __future__ import annotations

from pytest_lpb.errors import ScenarioError
from pytest_lpb.scenario.schema.robot import Robot
from pytest_lpb.scenario.structure import Structure, planar_model, planar_structure


def is_planar(robot: Robot) -> bool:
    """Whether the robot is of a planar model."""
    return robot.urdf is None and planar_model(robot.model or "") is not None


def structure_of(robot: Robot) -> Structure | None:
    """The structure of a robot that can be; None for others, whose faults a check tells."""
    if is_planar(robot):
        try:
            return planar_structure(robot)
        except ScenarioError:
            return None
    if (robot.model is None) == (robot.urdf is None):
        return None
    # Imported late: planar scenarios need none of it.
    from pytest_lpb.scenario.spatial import SpatialDescription

    try:
        return SpatialDescription(robot).structure
    except ScenarioError:
        return None
