"""What a planner file's `planner` is: a class here, a class in a process of its own, or a program."""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import json
from collections.abc import Callable, Iterable, Mapping
from functools import cache, cached_property
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from typing import Any, Protocol

from pydantic import TypeAdapter, ValidationError
from pydantic.errors import PydanticUserError

from pytest_lpb.errors import ConfigurationError, LpbError
from pytest_lpb.isolation.session import Session
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.names import listed, suggestion
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.elsewhere import FarParameters, IsolatedPlanner
from pytest_lpb.planner.registry import planner_class
from pytest_lpb.problem.preview import Preview

Place = Callable[..., str]  # how messages call a part of the planner file, by its keys


class Definition(Protocol):
    """Where a planner's parameters are checked, and how it is built."""

    @property
    def identity(self) -> str:
        """What it is called by, on any machine."""

    @property
    def source_hash(self) -> str:
        """SHA-256 of its source; empty when there is none."""

    @property
    def source(self) -> dict[str, str] | None:
        """Module and file to load it from elsewhere; None when nothing has to be loaded."""

    @property
    def about(self) -> dict[str, Any]:
        """Versions of what runs it, where that is not this interpreter."""

    def checked(self, values: Mapping[str, Any], loc: tuple[str, ...], place: Place) -> Any:
        """Its parameters. Raises ConfigurationError."""

    def foresee(self, sets: Iterable[Mapping[str, Any]]) -> None:
        """Be told all sets of parameters that will be asked for."""

    def preview_for(self, parameters: Any) -> Preview | None:
        """What it wants to see of the future."""

    def build(self, parameters: Any) -> Planner:
        """A new planner."""


class ClassHere:
    """A class that is imported into this process."""

    def __init__(self, reference: str) -> None:
        self.cls: type[Planner] = planner_class(reference)
        self.about: dict[str, Any] = {}

    @property
    def identity(self) -> str:
        """Module and name of the class."""
        return f"{self.cls.__module__}:{self.cls.__qualname__}"

    @property
    def source_hash(self) -> str:
        """SHA-256 of the file of the class, or of all in its folder if that is a package."""
        file = self._file()
        if file is None:
            return ""
        packaged = (file.parent / "__init__.py").is_file()
        files = sorted(path for path in file.parent.rglob("*.py") if path.is_file()) if packaged else [file]
        digest = hashlib.sha256()
        for path in files:
            digest.update(path.relative_to(file.parent).as_posix().encode() + b"\0" + path.read_bytes())
        return digest.hexdigest()

    @property
    def source(self) -> dict[str, str] | None:
        """Module and file of the class; None for those of this package."""
        if self.cls.__module__.partition(".")[0] == "pytest_lpb":
            return None
        file = self._file()
        return {"module": self.cls.__module__, "file": str(file.resolve()) if file else ""}

    def _file(self) -> Path | None:
        try:
            file = inspect.getsourcefile(self.cls)
        except (OSError, TypeError):
            return None
        return Path(file) if file is not None and Path(file).is_file() else None

    def checked(self, values: Mapping[str, Any], loc: tuple[str, ...], place: Place) -> Any:
        """An instance of the class's Parameters. Raises ConfigurationError."""
        adapter = _adapter(self.identity, self.cls.Parameters)
        _check_names(values, [item.name for item in dataclasses.fields(self.cls.Parameters)], self.identity, loc, place)
        try:
            return adapter.validate_json(json.dumps(dict(values)), strict=True)
        except ValidationError as error:
            raise ConfigurationError(
                "\n".join(
                    f"{place(*loc, *map(str, fault['loc']))}: {fault['msg']}, found {fault['input']!r}"
                    for fault in error.errors()
                )
            ) from None

    def foresee(self, sets: Iterable[Mapping[str, Any]]) -> None:
        """Nothing to prepare."""

    def preview_for(self, parameters: Any) -> Preview | None:
        """What the class wants to see of the future."""
        return self.cls.preview_for(parameters)

    def build(self, parameters: Any) -> Planner:
        """An instance."""
        return self.cls(parameters)


class IsolatedClass(ClassHere):
    """A class of this interpreter, whose instances live in a process of their own."""

    def __init__(self, reference: str, isolation: Isolation) -> None:
        super().__init__(reference)
        self._isolation = isolation
        self._reference = reference if ":" in reference else self.identity

    def checked(self, values: Mapping[str, Any], loc: tuple[str, ...], place: Place) -> FarParameters:
        """The values, checked by the class here."""
        parameters = super().checked(values, loc, place)
        resolved = dataclasses.asdict(parameters)
        return FarParameters(dict(values), resolved, self.cls.preview_for(parameters))

    def preview_for(self, parameters: FarParameters) -> Preview | None:
        """What the class wants to see of the future."""
        return parameters.preview

    def build(self, parameters: FarParameters) -> Planner:
        """The planner in its process."""
        return IsolatedPlanner(parameters, self._isolation, self._reference, None)


class ClassElsewhere:
    """A class of another interpreter, which is asked for all that is known of it."""

    source: dict[str, str] | None = None

    def __init__(self, reference: str, isolation: Isolation) -> None:
        self._reference = reference
        self._isolation = isolation
        self._sets: dict[str, Mapping[str, Any]] = {_key({}): {}}

    def foresee(self, sets: Iterable[Mapping[str, Any]]) -> None:
        """All sets of parameters are sent in one go: starting an interpreter takes its time."""
        self._sets |= {_key(values): values for values in sets}

    @cached_property
    def _description(self) -> dict[str, Any]:
        session = Session(self._isolation, self._reference, self._folder)
        try:
            description = session.describe(list(self._sets.values()))
        except LpbError as error:
            place = self._isolation.place
            raise ConfigurationError(f"planner {self._reference!r} cannot be had from {place}: {error}") from None
        finally:
            session.close()
        return {**description, "sets": dict(zip(self._sets, description["sets"], strict=True))}

    @property
    def _folder(self) -> Path | None:
        """Where the module lies here, unless it is installed: then it is for this interpreter."""
        if self._isolation.ssh:
            return None
        try:
            spec = find_spec(self._reference.partition(":")[0].partition(".")[0])
        except (ImportError, ValueError):
            return None
        file = Path(spec.origin) if spec is not None and spec.origin and spec.has_location else None
        if file is None or {"site-packages", "dist-packages"} & set(file.parts):
            return None
        return file.parent.parent if file.name == "__init__.py" else file.parent

    @property
    def identity(self) -> str:
        """Module and name of the class."""
        return str(self._description["class"])

    @property
    def source_hash(self) -> str:
        """SHA-256 of its source over there."""
        return str(self._description["source_hash"])

    @property
    def about(self) -> dict[str, Any]:
        """Versions of Python and NumPy."""
        return dict(self._description["about"])

    def checked(self, values: Mapping[str, Any], loc: tuple[str, ...], place: Place) -> FarParameters:
        """The values, checked over there. Raises ConfigurationError."""
        key = _key(values)
        if key not in self._sets:
            self._sets[key] = values
            self.__dict__.pop("_description", None)
        _check_names(values, self._description["fields"], self.identity, loc, place)
        found = self._description["sets"][key]
        if "fault" in found:
            raise ConfigurationError(f"{place(*loc)}: {found['fault']}")
        preview = found["preview"]
        return FarParameters(dict(values), found["parameters"], None if preview is None else Preview(*preview))

    def preview_for(self, parameters: FarParameters) -> Preview | None:
        """What the class wants to see of the future."""
        return parameters.preview

    def build(self, parameters: FarParameters) -> Planner:
        """The planner in its process."""
        return IsolatedPlanner(parameters, self._isolation, self._reference, self._folder)


class Command:
    """A program; its parameters are its own business."""

    source: dict[str, str] | None = None

    def __init__(self, isolation: Isolation) -> None:
        self._isolation = isolation
        self.about: dict[str, Any] = {}
        if which(isolation.command[0]) is None:
            raise ConfigurationError(f"command: {isolation.command[0]} is no program that can be run")

    @property
    def identity(self) -> str:
        """The program's name."""
        return Path(self._isolation.command[0]).name

    @property
    def source_hash(self) -> str:
        """SHA-256 of the program's file, and of files among its arguments."""
        digest = hashlib.sha256()
        for word in (which(self._isolation.command[0]) or "", *self._isolation.command[1:]):
            if Path(word).is_file():
                digest.update(Path(word).read_bytes())
        return digest.hexdigest()

    def foresee(self, sets: Iterable[Mapping[str, Any]]) -> None:
        """Nothing to prepare."""

    def checked(self, values: Mapping[str, Any], loc: tuple[str, ...], place: Place) -> FarParameters:  # noqa: ARG002
        """The values as they are."""
        return FarParameters(dict(values), dict(values))

    def preview_for(self, parameters: FarParameters) -> Preview | None:
        """None: programs see the present."""
        return parameters.preview

    def build(self, parameters: FarParameters) -> Planner:
        """The program, to be started by its first setup."""
        return IsolatedPlanner(parameters, self._isolation, "", None)


def definition_of(reference: str, isolation: Isolation | None) -> Definition:
    """The definition of a planner file. Raises ConfigurationError when there is no such class or program."""
    if isolation is None:
        return ClassHere(reference)
    if isolation.command:
        return Command(isolation)
    if isolation.same_interpreter:
        return IsolatedClass(reference, isolation)
    return ClassElsewhere(reference, isolation)


def _key(values: Mapping[str, Any]) -> str:
    return json.dumps(dict(values), sort_keys=True)


def _check_names(
    values: Iterable[str], allowed: Iterable[str], identity: str, loc: tuple[str, ...], place: Place
) -> None:
    allowed = list(allowed)
    for key in values:
        if key not in allowed:
            raise ConfigurationError(
                f"{place(*loc, key)}: unknown parameter{suggestion(key, allowed)}; "
                f"{identity.rpartition(':')[2].rpartition('.')[2]} has {listed(allowed)}"
            )


@cache
def _adapter(place: str, parameters: Any) -> TypeAdapter[Any]:
    """What reads a planner's Parameters. Raises ConfigurationError for a class that no YAML can be read into."""
    if not (isinstance(parameters, type) and dataclasses.is_dataclass(parameters)):
        raise ConfigurationError(f"{place}: Parameters must be a dataclass: put @dataclass(frozen=True) above it")
    try:
        return TypeAdapter(parameters)
    except (PydanticUserError, NameError) as error:
        text = str(error).partition("\n")[0]
        raise ConfigurationError(
            f"{place}: Parameters has a field of a type that no YAML value fits: {text}; "
            "use numbers, text, booleans, lists and the like"
        ) from error
