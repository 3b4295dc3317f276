"""What run.json says of a run: command, versions, machine, planners and scenarios."""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_lpb.errors import LpbError
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.study.family import Family
from pytest_lpb.trial.specification import usable_cores

if TYPE_CHECKING:
    from pytest_lpb.problem.spatial.robot import SpatialRobot

SCHEMA_VERSION = 1
PACKAGES = (
    "pytest-lpb",
    "pytest",
    "pytest-xdist",
    "pytest-benchmark",
    "gymnasium",
    "numpy",
    "scipy",
    "pandas",
    "pyarrow",
    "pydantic",
    "matplotlib",
)
GIT_TIMEOUT_S = 5.0
SPATIAL = b"pybullet"  # the engine's name, which every scenario in space writes


def run_information(
    command: Sequence[str],
    planners: Iterable[PlannerConfiguration],
    families: Mapping[str, Family],
    options: Mapping[str, Any],
    folder: Path,
) -> dict[str, Any]:
    """Content of run.json.

    Args:
        command: as it was typed.
        planners: with resolved parameters.
        families: problems by scenario key.
        options: seeds, flags, KPIs, modules, workers.
        folder: whose git commit counts.
    """
    families = dict(sorted(families.items()))
    spatial = {key: family for key, family in families.items() if SPATIAL in family.path.read_bytes()}
    return {
        "schema_version": SCHEMA_VERSION,
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": list(command),
        **options,
        "planners": {planner.name: planner.to_dict() for planner in planners},
        "scenarios": {key: family.description() for key, family in families.items()},
        **_robots(spatial),
        "packages": {name: installed_version(name) for name in PACKAGES},
        "machine": machine(),
        "git": git_state(folder),
    }


def _robots(families: Mapping[str, Family]) -> dict[str, dict[str, Any]]:
    """What is to be known of the robots of scenarios in space, by scenario.

    Pairs of bodies that always overlap and are therefore not checked for self-collision; notes on how a URDF was read,
    and on what of it is not there and not needed; warnings of what is probably not meant.
    """
    pairs: dict[str, Any] = {}
    notes: dict[str, Any] = {}
    warnings: dict[str, Any] = {}
    for key, robot in _spatial_robots(families):
        pairs[key] = [list(pair) for pair in robot.left_out_pairs]
        if found := robot.notes:
            notes[key] = found
        if found := robot.warnings:
            warnings[key] = found
    return {"self_collision_left_out": pairs, "robot_notes": notes, "robot_warnings": warnings}


def _spatial_robots(families: Mapping[str, Family]) -> Iterator[tuple[str, SpatialRobot]]:
    if not families:
        return
    # Imported late: it costs nothing where nothing is in space.
    from pytest_lpb.problem.robot import robot_from
    from pytest_lpb.problem.spatial.robot import SpatialRobot

    for key, family in families.items():
        try:
            robot = robot_from(family.scenario().concrete["robot"])
        except LpbError:
            continue  # an error where the scenario is collected
        if isinstance(robot, SpatialRobot):
            yield key, robot


def machine() -> dict[str, Any]:
    """Processor, cores, memory and system; never the machine's name."""
    return {
        "cpu": _cpu(),
        "cores": usable_cores(),
        "memory_gib": _memory_gib(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": f"{platform.python_implementation()} {platform.python_version()}",
    }


def git_state(folder: Path) -> dict[str, Any] | None:
    """Commit of the repository that holds a folder, and whether it has changes; None outside of one."""
    commit = _git(folder, "rev-parse", "HEAD")
    if commit is None:
        return None
    return {"commit": commit, "dirty": bool(_git(folder, "status", "--porcelain", "--untracked-files=no"))}


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        result = subprocess.run(
            ["git", "-C", str(folder), *arguments],
            capture_output=True,
            text=True,
            check=True,
            timeout=GIT_TIMEOUT_S,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return result.stdout.strip()


def installed_version(package: str) -> str | None:
    """Version of an installed package; None where it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _memory_gib() -> float | None:
    if not hasattr(os, "sysconf") or "SC_PHYS_PAGES" not in os.sysconf_names:
        return None
    return round(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**30, 1)
