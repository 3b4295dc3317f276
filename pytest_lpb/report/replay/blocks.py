"""All replays of a report within its budget: blocks by key; robots, problems and meshes that trials share are one."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_lpb.errors import LpbError
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.packing import packed
from pytest_lpb.report.replay.choice import in_order_of_interest
from pytest_lpb.report.replay.motion import Motion, motion_for
from pytest_lpb.report.replay.trial import robot_block, scene_block, trial_block

if TYPE_CHECKING:
    import pandas as pd

    from pytest_lpb.trajectory import Trajectory

MAX_BYTES = 2_600_000  # of all blocks together: a report of 200 trials stays under 5 MB


@dataclass
class Replays:
    """What was made, as text to be put into the page.

    Attributes:
        blocks: key -> packed block: `trial:K` with K the place among the trials, `robot:K`, `scene:K`, `mesh:K`.
        places: places of the trials that have a replay.
        spatial: whether one of them is in space.
        faults: raw data that could not be read.
    """

    blocks: dict[str, str] = field(default_factory=dict)
    places: list[int] = field(default_factory=list)
    spatial: bool = False
    faults: list[str] = field(default_factory=list)


def replays(data: ReportData, trials: pd.DataFrame, budget: int = MAX_BYTES) -> Replays:
    """Replays of the most interesting of `trials` until the budget [bytes] is used."""
    maker = _Maker(Replays())
    places = {str(node_id): place for place, node_id in enumerate(trials["node_id"])}
    chosen = in_order_of_interest(trials)
    for node_id, problem in zip(chosen["node_id"], chosen["problem_hash"], strict=True):
        try:
            trajectory = data.trajectory_of(str(node_id))
            if len(trajectory) > 1:
                maker.add(places[str(node_id)], trajectory, str(problem))
        except (LpbError, OSError) as error:
            maker.made.faults.append(f"{node_id}: {' '.join(str(error).split())}")
        if maker.size > budget:
            break
    return maker.made


class _Maker:
    """Makes blocks and knows which there are."""

    def __init__(self, made: Replays) -> None:
        self.made = made
        self.size = 0
        self._motions: dict[int, Motion] = {}
        self._keys: dict[tuple[str, str], str] = {}
        self._meshes: dict[Path, str] = {}

    def add(self, place: int, trajectory: Trajectory, problem_hash: str) -> None:
        """Add a trial, and what it needs that is not there yet."""
        problem = trajectory.problem
        motion = self._motions.setdefault(problem.dimension, motion_for(problem.dimension))
        block = trial_block(trajectory, motion)
        robot = self._shared("robot", _identity(problem.robot.to_dict()), lambda: robot_block(trajectory, motion))
        scene = self._shared("scene", problem_hash, lambda: scene_block(trajectory, motion))
        self._add_meshes(motion)
        self._put(f"trial:{place}", {"robot": robot, "scene": scene, **block})
        self.made.places.append(place)
        self.made.spatial |= problem.dimension == 3

    def _shared(self, kind: str, identity: str, make: Callable[[], dict[str, Any]]) -> str:
        if (kind, identity) not in self._keys:
            number = sum(known == kind for known, _ in self._keys)
            self._keys[kind, identity] = f"{kind}:{number}"
            self._put(f"{kind}:{number}", make())
        return self._keys[kind, identity]

    def _add_meshes(self, motion: Motion) -> None:
        for number, path in enumerate(motion.meshes):
            if f"mesh:{number}" not in self.made.blocks:
                self._put(f"mesh:{number}", _mesh(path))

    def _put(self, key: str, block: dict[str, Any]) -> None:
        self.made.blocks[key] = packed(block)
        self.size += len(self.made.blocks[key])


def _mesh(path: Path) -> dict[str, Any]:
    from pytest_lpb.report.replay.shapes import mesh_block

    try:
        return mesh_block(path)
    except (LpbError, OSError):
        return {"vertices": None, "faces": None}  # it is left out, as in the pictures


def _identity(entry: dict[str, Any]) -> str:
    return json.dumps({key: value for key, value in entry.items() if key != "control"}, sort_keys=True)
