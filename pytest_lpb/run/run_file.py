"""What run.json may hold, whoever wrote it: wrong types are told with their place. What is unknown is let be."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from pytest_lpb.bounded import read_bounded
from pytest_lpb.documents.faults import capped, described, key_path
from pytest_lpb.errors import RecordingError
from pytest_lpb.names import is_name
from pytest_lpb.run.plan import check_plan

MAX_RUN_FILE_BYTES = 100_000_000  # planned trials of a million scenarios fit


def _named(path: str) -> str:
    if not all(is_name(part) for part in path.split("/")):
        raise ValueError("is no name")
    return path


def _key(path: str) -> str:
    """A scenario's key: its folders may have any name, but none leads elsewhere."""
    if any(part in ("", ".", "..") for part in path.split("/")) or not path.isprintable():
        raise ValueError("is no name")
    return path


Name = Annotated[str, AfterValidator(_named)]
Key = Annotated[str, AfterValidator(_key)]
Count = Annotated[int, Field(ge=0, le=10**9)]
Number = Annotated[float, Field(allow_inf_nan=False)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="allow", strict=True)


class _Module(_Part):
    module: str
    file: str


class _Planner(_Part):
    planner: str = ""
    file: str | None = None
    parameters: dict[str, Any] | None = None
    per_robot: dict[str, dict[str, Any]] | None = None
    parameters_hash: str | None = None
    source_hash: str | None = None
    source: dict[str, Any] | str | None = None
    period: Number | None = None
    delay: Number | None = None


class _Scenario(_Part):
    file: str = ""
    hash: str = ""
    problems_of: str | None = None
    changes: dict[str, Any] | None = None


class _Machine(_Part):
    cpu: str | None = None
    cores: Count | None = None
    memory_gib: Number | None = None
    system: str | None = None
    python: str | None = None


class _Git(_Part):
    commit: str | None = None
    dirty: bool | None = None


class _Gate(_Part):
    baseline: str
    fail_on: list[str]
    inconclusive: str


class _Variant(_Part):
    of: str
    values: dict[str, Any]


class _Seeds(_Part):
    first: Annotated[int, Field(ge=-(2**63), le=2**63)] | None = None
    trials: Count | None = None


def _plan(plan: dict[str, dict[str, str]]) -> dict[str, dict[str, str]]:
    check_plan(plan)
    return plan


class _RunFile(_Part):
    """All that is read of it anywhere; runs of other versions may lack some."""

    schema_version: int = 1
    title: str | None = None
    started: str | None = None
    command: str | list[str] | None = None
    seeds: _Seeds | list[int] | None = None
    random: list[str] | None = None
    kpis: list[str] | None = None
    plugins: list[_Module] = []
    workers: Count | None = None
    rootdir: str | None = None
    invocation: str | None = None
    pythonpath: list[str] = []
    arguments: list[str] | None = None
    options: dict[str, Any] | None = None
    planned: Annotated[dict[Key, dict[Name, str]], AfterValidator(_plan)] | None = None
    planners: dict[Name, _Planner] = {}
    scenarios: dict[Key, _Scenario] = {}
    self_collision_left_out: dict[str, list[list[str]]] | None = None
    robot_notes: dict[str, list[str]] | None = None
    robot_warnings: dict[Key, list[str]] | None = None
    packages: dict[str, str | None] | None = None
    machine: _Machine | None = None
    git: _Git | None = None
    gate: _Gate | None = None
    swept: dict[str, dict[str, _Variant]] | None = None
    notes: list[str] | None = None


def read_run_file(path: Path) -> dict[str, Any]:
    """The content of a run.json. Raises RecordingError: one line per fault, with its key."""
    content = read_bounded(path, MAX_RUN_FILE_BYTES, RecordingError)
    try:
        info = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"cannot read {path}: {error}") from None
    try:
        _RunFile.model_validate(info)
    except ValidationError as error:
        faults = [f"{path}: {_told(fault)}" for fault in error.errors()]
        raise RecordingError("\n".join(capped(list(dict.fromkeys(faults))))) from None
    return dict(info)


def robot_warnings(info: Mapping[str, Any]) -> list[str]:
    """What is probably not meant about the robots of a run, with the scenarios that it is about."""
    scenarios: dict[str, list[str]] = {}
    for scenario, texts in (info.get("robot_warnings") or {}).items():
        for text in texts:
            scenarios.setdefault(text, []).append(scenario)
    return [f"{', '.join(capped(names))}: {text}" for text, names in scenarios.items()]


def _told(fault: Any) -> str:
    key = key_path(fault["loc"]) or "the file"
    if fault["type"] == "missing":
        return f"{key}: is missing"
    return f"{key}: found {described(fault['input'])[:200]}; {fault['msg']}"
