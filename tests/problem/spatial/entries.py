"""Concrete 3-D problems for tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.load import load_scenario

PANDA_START = [1.0, 0.0, 0.0, -1.5, 0.0, 1.8675, 0.0]

Entry = dict[str, Any]


def scenario_entry(robot: Entry, obstacles: Sequence[Entry] = (), **parts: Any) -> Entry:
    """A scenario's content; its goal is one that every robot has: the first joint at zero."""
    return {
        "version": 1,
        "robot": robot,
        "environment": {"engine": "pybullet", "dt": 0.01, "duration": 1.0, **parts.pop("environment", {})},
        "goal": [{"type": "joint", "joints": [parts.pop("joint")], "target": [0.0], "tolerance": 0.01}],
        "obstacles": list(obstacles),
        **parts,
    }


def problem_of(folder: Path, entry: Entry, seed: int = 0) -> Problem:
    """The problem of a scenario's content, loaded through a file."""
    path = folder / "scenario.yaml"
    path.write_text(dump_yaml(entry), encoding="utf-8")
    return draw_problem(load_scenario(path), seed)


def point_entry(radius: float, obstacles: Sequence[Entry], **parts: Any) -> Entry:
    """A sphere among obstacles."""
    return scenario_entry({"model": "point_3d", "body_radius": radius}, obstacles, joint="x", **parts)


def panda_entry(obstacles: Sequence[Entry] = (), **parts: Any) -> Entry:
    """The Panda among obstacles, in the start of the paper's problems."""
    parts.setdefault("start", {"q": PANDA_START})
    return scenario_entry({"model": "panda", **parts.pop("robot", {})}, obstacles, joint="panda_joint1", **parts)


def write_torus(path: Path, major: float, minor: float, around: int = 48, across: int = 24) -> Path:
    """A torus about z as an OBJ file: a ring of radius `major` [m] with a tube of radius `minor` [m]."""
    u = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    v = np.linspace(0.0, 2.0 * np.pi, across, endpoint=False)
    ring, tube = np.meshgrid(u, v, indexing="ij")
    radius = major + minor * np.cos(tube)
    points = np.stack([radius * np.cos(ring), radius * np.sin(ring), minor * np.sin(tube)], axis=-1).reshape(-1, 3)
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in points]
    for i in range(around):
        for j in range(across):
            a, b = i * across + j, ((i + 1) % around) * across + j
            c, d = ((i + 1) % around) * across + (j + 1) % across, i * across + (j + 1) % across
            lines += [f"f {a + 1} {b + 1} {c + 1}", f"f {a + 1} {c + 1} {d + 1}"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
