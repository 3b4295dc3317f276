"""Finds and reads planner configurations: `planners/NAME.yaml`, shipped ones, `PATH.yaml`, `NAME=PATH`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pytest_lpb.bounded import read_bounded
from pytest_lpb.documents.reader import MAX_BYTES, Document, read_yaml
from pytest_lpb.documents.recognition import SUFFIXES
from pytest_lpb.errors import ConfigurationError, LpbError
from pytest_lpb.isolation.settings import KEYS, Isolation, faults_of, isolation_of
from pytest_lpb.names import is_name, listed, suggestion
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.registry import registered_names
from pytest_lpb.planner.support import CONTROLS
from pytest_lpb.problem.preview import MAX_STEPS
from pytest_lpb.shipped import shipped_folder

PARAMETERS = ("parameters", "per_robot")  # keys whose values a class reads: it may allow any number


class _Preview(BaseModel):
    """What a program wants to see of the future."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    steps: Annotated[int, Field(ge=1, le=MAX_STEPS)]
    step_s: Annotated[float, Field(gt=0.0)]


class _File(BaseModel):
    """Content of a planner configuration file."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    planner: str = ""
    parameters: dict[str, Any] = {}
    per_robot: dict[str, dict[str, Any]] = {}
    period: Annotated[float, Field(gt=0.0)] | None = None
    delay: Annotated[float, Field(ge=0.0)] = 0.0
    xfail: dict[str, Any] = {}
    description: str = ""
    supports: dict[str, Any] = {}
    python: str | None = None
    ssh: str | None = None
    command: str | list[str] = ""
    preview: _Preview | None = None
    environment: dict[str, str] = {}
    working_dir: str | None = None
    isolate: bool | None = None
    deadline_s: Annotated[float, Field(gt=0.0)] | None = None
    setup_deadline_s: Annotated[float, Field(gt=0.0)] | None = None
    memory_mb: Annotated[int, Field(ge=1)] | None = None


def parted(reference: str) -> tuple[str, str]:
    """The name that a reference gives a planner, and the path that it names; empty for none."""
    name, equals, path = reference.partition("=")
    if equals:
        return name, path
    return (Path(reference).stem, reference) if reference.endswith(SUFFIXES) else (reference, "")


def with_path(reference: str, change: Callable[[str], str]) -> str:
    """A reference with its path, if it has one, changed."""
    name, path = parted(reference)
    if not path:
        return reference
    return f"{name}={change(path)}" if "=" in reference else change(path)


def find_planners(references: Sequence[str], folders: Sequence[Path]) -> list[PlannerConfiguration]:
    """The configurations that `--lpb-planners` names, in its order.

    Args:
        references: NAME, PATH.yaml or NAME=PATH each.
        folders: folders of NAME.yaml, in the order of search; shipped ones come last.

    Raises ConfigurationError for unknown, repeated or wrong ones.
    """
    found: dict[str, PlannerConfiguration] = {}
    for reference in references:
        configuration = _find(reference, list(dict.fromkeys([*folders, shipped_folder("planners")])))
        if configuration.name in found:
            raise ConfigurationError(f"planner {configuration.name!r} is named twice in {', '.join(references)}")
        configuration.check()
        found[configuration.name] = configuration
    return list(found.values())


def _find(reference: str, folders: Iterable[Path]) -> PlannerConfiguration:
    name, path = parted(reference)
    if path or "=" in reference:
        return read_planner(Path(path), name)
    if ":" in reference:
        raise ConfigurationError(
            f"planner {reference!r}: give it a name in a file `NAME.yaml` with `planner: {reference}`"
        )
    for folder in folders:
        for suffix in SUFFIXES:
            if (folder / f"{reference}{suffix}").is_file():
                return read_planner(folder / f"{reference}{suffix}", reference)
    if reference in registered_names():
        return PlannerConfiguration(reference, reference)
    raise _unknown(reference, folders)


def _unknown(reference: str, folders: Iterable[Path]) -> ConfigurationError:
    names = set(registered_names())
    for folder in folders:
        names |= {path.stem for suffix in SUFFIXES for path in folder.glob(f"*{suffix}")}
    searched = ", ".join(str(folder) for folder in folders if folder.is_dir())
    return ConfigurationError(
        f"unknown planner {reference!r}{suggestion(reference, names)}; known are {listed(names)} (searched {searched})"
    )


def read_planner(path: Path, name: str) -> PlannerConfiguration:
    """The configuration in a file, under a name.

    Raises ConfigurationError with file and line for everything that is wrong with it.
    """
    if not is_name(name):
        raise ConfigurationError(f"planner name {name!r} is not allowed; use letters, digits, _ . - and no leading dot")
    try:
        content = read_bounded(path, MAX_BYTES)
    except LpbError as error:
        reason = str(error).removeprefix(f"{path}: ").removeprefix("cannot be read: ")
        raise ConfigurationError(f"planner {name!r}: cannot read {path}: {reason}") from None
    try:
        document = read_yaml(content, str(path), "a planner configuration is a mapping with the key `planner`")
    except LpbError as error:
        raise ConfigurationError(str(error)) from None
    return _parsed(document, path, name)


def _parsed(document: Document, path: Path, name: str) -> PlannerConfiguration:
    try:
        content = _File.model_validate(document.data)
    except ValidationError as error:
        raise ConfigurationError("\n".join(_message(document, path, fault) for fault in error.errors())) from None
    faults = [
        f"{path}:{document.line_of(loc)}: {'.'.join(map(str, loc))}: found {value}; a finite number is required"
        for loc, value in _not_finite(document.data, ())
        if content.command or loc[0] not in PARAMETERS
    ]
    faults += [
        f"{path}:{document.line_of(('per_robot', key))}: per_robot: {key}: unknown control {control!r}"
        f"{suggestion(control, CONTROLS)}; allowed: {listed(CONTROLS)}"
        for key in content.per_robot
        for _, at, control in [key.partition("@")]
        if at and control not in CONTROLS
    ]
    values = content.model_dump(include=set(KEYS) | {"planner"})
    faults += [f"{path}:{document.line_of((key,))}: {key}: {text}" for key, text in faults_of(values)]
    if not (content.planner or content.command):
        faults.append(f"{path}:{document.line_of(())}: planner: missing; name the planner's class here")
    if faults:
        raise ConfigurationError("\n".join(faults))
    return PlannerConfiguration(
        name=name,
        planner=content.planner,
        parameters=content.parameters,
        per_robot=content.per_robot,
        period=content.period,
        delay=content.delay,
        xfail=content.xfail,
        supports=content.supports,
        isolation=isolation_of(values, path.parent),
        path=path,
        document=document,
    )


def recorded_isolation(values: Any, folder: Path) -> Isolation | None:
    """The isolation that a run recorded, as of a planner file in a folder.

    Raises ConfigurationError for values of a wrong type; LookupError, ValueError or GetoptError for others.
    """
    try:
        content = _File.model_validate(values)
    except ValidationError as error:
        fault = error.errors()[0]
        place = ".".join(map(str, fault["loc"]))
        raise ConfigurationError(f"{place}: {fault['msg']}, found {fault['input']!r}".removeprefix(": ")) from None
    return isolation_of(content.model_dump(include=set(KEYS)), folder)


def _message(document: Document, path: Path, fault: Any) -> str:
    loc, key = fault["loc"], ".".join(map(str, fault["loc"]))
    line = document.line_of(loc)
    if fault["type"] == "extra_forbidden":
        allowed = _File.model_fields
        return f"{path}:{line}: {key}: unknown key{suggestion(str(loc[-1]), allowed)}; allowed: {listed(allowed)}"
    return f"{path}:{line}: {key}: {fault['msg']}, found {fault['input']!r}"


def _not_finite(value: Any, loc: tuple[str | int, ...]) -> Iterator[tuple[tuple[str | int, ...], float]]:
    """Places of infinities and NaN in a document."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from _not_finite(item, (*loc, key))
    if isinstance(value, float) and not isfinite(value):
        yield loc, value
