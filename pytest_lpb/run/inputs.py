"""Planner files in a run folder: with its problems, all that it takes to run it again elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.isolation.far.values import encoded
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.problem.hashing import plain

FOLDER = "planners"


def planner_file(run: Path, name: str) -> Path:
    """Where a run folder keeps a planner's configuration."""
    return run / FOLDER / f"{name}.yaml"


def write_planner_files(run: Path, planners: Iterable[PlannerConfiguration]) -> None:
    """Write each planner's configuration as a planner file; the code of its class stays where it is."""
    for planner in planners:
        path = planner_file(run, planner.name)
        path.parent.mkdir(exist_ok=True)
        replace_file(path, dump_yaml(_content(planner)).encode())


def _content(planner: PlannerConfiguration) -> dict[str, Any]:
    optional = {
        "parameters": encoded(planner.parameters),
        "per_robot": encoded(planner.per_robot),
        "period": planner.period,
        "delay": planner.delay,
        "supports": encoded(planner.supports),
        "xfail": plain(planner.xfail),
        **(plain(planner.isolation.to_dict()) if planner.isolation else {}),
    }
    return ({"planner": planner.planner} if planner.planner else {}) | {
        key: value for key, value in optional.items() if value
    }
