"""Checks that involve several keys of a scenario file, run after each key has been checked by itself."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

from pytest_lpb.documents.faults import Fault
from pytest_lpb.scenario.checks import goal, obstacles, randomize, robot, time
from pytest_lpb.scenario.robots import structure_of
from pytest_lpb.scenario.schema import ScenarioFile
from pytest_lpb.scenario.structure import Structure

Check = Callable[..., Iterator[Fault]]

# (check, what it needs): parts of the file, or `structure`, the names of the robot's joints and bodies.
CHECKS: tuple[tuple[Check, tuple[str, ...]], ...] = (
    (robot.check_model, ("robot",)),
    (robot.check_engine_fits, ("robot", "environment", "structure")),
    (robot.check_control, ("robot", "environment")),
    (robot.check_limits, ("robot", "structure")),
    (robot.check_spheres, ("robot", "structure")),
    (robot.check_pairs, ("robot", "structure")),
    (robot.check_start, ("start", "robot", "structure")),
    (time.check_engine, ("environment",)),
    (time.check_steps, ("environment",)),
    (time.check_rows, ("environment", "obstacles", "randomize")),
    (time.check_hold_time, ("success", "environment")),
    (time.check_criteria, ("success",)),
    (time.check_seeds, ("seed", "trials")),
    (time.check_certified, ("certified",)),
    (goal.check_names, ("goal",)),
    (goal.check_primary, ("goal",)),
    (goal.check_frames, ("goal", "structure")),
    (goal.check_tolerances, ("goal", "structure")),
    (goal.check_targets, ("goal", "environment", "structure")),
    (obstacles.check_names, ("obstacles", "source")),
    (obstacles.check_shapes, ("obstacles", "environment")),
    (obstacles.check_motions, ("obstacles", "environment")),
    (obstacles.check_meshes, ("obstacles",)),
    (randomize.check_draw, ("randomize",)),
    (randomize.check_configurations, ("randomize", "robot", "structure")),
    (randomize.check_goal, ("randomize", "goal")),
    (randomize.check_groups, ("randomize", "environment")),
)


@dataclass(frozen=True)
class _Parts:
    """What checks may ask for, by name."""

    file: ScenarioFile
    wrong: frozenset[str]

    @cached_property
    def _structure(self) -> Structure | None:
        return None if "robot" in self.wrong else structure_of(self.file.robot)

    def collect(self, names: tuple[str, ...]) -> list[object] | None:
        """The parts of these names; None when one of them is wrong and cannot be checked."""
        values = [self._part(name) for name in names]
        return None if any(value is self for value in values) else values

    def _part(self, name: str) -> object:
        if name == "structure":
            return self._structure or self
        return self if name in self.wrong else getattr(self.file, name)


def check(file: ScenarioFile, wrong: frozenset[str]) -> list[Fault]:
    """Run every check whose parts are right by themselves.

    Args:
        file: the validated file; parts in `wrong` may be missing.
        wrong: top-level keys with a fault of their own.
    """
    parts = _Parts(file, wrong)
    faults: list[Fault] = []
    for function, needs in CHECKS:
        values = parts.collect(needs)
        if values is not None:
            faults.extend(function(*values))
    return faults
