"""The concrete problem of one trial: everything drawn, every default filled in."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from pytest_lpb.problem.goal import SubGoal, goal_from
from pytest_lpb.problem.hashing import HASHED_SECTIONS, hash_of
from pytest_lpb.problem.hold import rows_to_hold
from pytest_lpb.problem.obstacle import Obstacle
from pytest_lpb.problem.robot import FloatArray, Robot, robot_from

NOT_CRITERIA = ("hold_time", "rate")  # keys of `success` that are no KPI criterion


class Problem:
    """A concrete problem. Build it with `from_dict`; a problem is never changed afterwards.

    Args:
        entry: the concrete dictionary: sections robot, environment, start, goal, obstacles, success, and seed.
        name: key of the scenario it was drawn from.
    """

    def __init__(self, entry: Mapping[str, Any], name: str) -> None:
        self.entry = dict(entry)
        self.name = name
        self.seed: int = entry["seed"]
        settings = entry["environment"]
        self.dt: float = settings["dt"]  # [s]
        self.duration: float = settings["duration"]  # [s]
        self.steps = round(self.duration / self.dt)
        self.engine: str = settings["engine"]
        self.end_at: frozenset[str] = frozenset(settings["end_at"])
        self.safety_margin: float = settings["safety_margin"]  # [m]
        self.prediction: str = settings["prediction"]
        self.dynamics: bool = settings.get("dynamics", False)
        self.substeps: int = settings.get("substeps", 1)  # of the physics per step, with dynamics
        self.gravity: tuple[float, ...] = tuple(settings.get("gravity", (0.0, 0.0, -9.81)))  # [m/s^2]
        self.robot: Robot = robot_from(entry["robot"])
        self.control = self.robot.control
        self.dimension: int = self.robot.dimension
        self.goal: tuple[SubGoal, ...] = goal_from(entry["goal"], self.robot)
        self.primary: SubGoal = next(goal for goal in self.goal if goal.primary)
        self.obstacles: tuple[Obstacle, ...] = tuple(Obstacle(item) for item in entry["obstacles"])
        start = entry["start"]
        self.start_q: FloatArray = np.array(start["q"], dtype=float)
        self.start_u: FloatArray = np.array(start["u" if "u" in start else "qd"], dtype=float)
        success = entry["success"]
        self.hold_time: float | str = success["hold_time"]  # [s] or "end"
        self.criteria: dict[str, str] = {name: text for name, text in success.items() if name not in NOT_CRITERIA}
        certified = entry.get("certified")
        self.certified_path_length_m: float | None = None if certified is None else certified["length_m"]

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any], name: str = "") -> Problem:
        """The problem of a concrete dictionary, as `to_dict` gives it."""
        return cls(entry, name)

    def to_dict(self) -> dict[str, Any]:
        """The concrete dictionary: a scenario file's content that repeats this problem exactly."""
        return dict(self.entry)

    @cached_property
    def problem_hash(self) -> str:
        """SHA-256 of robot, environment, start, goal and obstacles, in hexadecimal."""
        parts = {section: self.entry[section] for section in HASHED_SECTIONS}
        parts["robot"] = self.robot.hashed()
        parts["obstacles"] = [obstacle.hashed() for obstacle in self.obstacles]
        return hash_of(parts)

    @property
    def hold_rows(self) -> int | None:
        """Steps that the goal must be held for; None: to the last row."""
        return rows_to_hold(self.hold_time, self.dt)

    @property
    def times(self) -> FloatArray:
        """Times of all rows, (steps + 1,) [s]."""
        times: FloatArray = np.arange(self.steps + 1) * self.dt
        return times
