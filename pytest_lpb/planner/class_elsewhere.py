"""A planner class of another interpreter, or a program: what is known of it here."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from types import MappingProxyType
from typing import Any

from pytest_lpb.errors import ConfigurationError, LpbError
from pytest_lpb.isolation.far.values import encoded
from pytest_lpb.isolation.session import Session
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.elsewhere import FarParameters, IsolatedPlanner
from pytest_lpb.planner.parameter_names import Place, check_names
from pytest_lpb.problem.preview import Preview


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
            reason = str(error).removeprefix(f"{place} ")
            raise ConfigurationError(f"{self._reference!r} cannot be had from {place}: {reason}") from None
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
    def supports(self) -> Any:
        """What the class declares over there."""
        return self._description.get("supports") or {}

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
        try:
            description = self._description
        except ConfigurationError as error:
            raise ConfigurationError(f"{place('planner')}: {error}") from None
        check_names(values, description["fields"], self.identity, loc, place)
        found = description["sets"][key]
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
    supports: Any = MappingProxyType({})  # its planner file may declare something, and it answers setups

    def __init__(self, isolation: Isolation) -> None:
        self._isolation = isolation
        self._preview = Preview(**isolation.preview) if isolation.preview else None
        self.about: dict[str, Any] = {}

    @property
    def identity(self) -> str:
        """The program's name."""
        return Path(self._isolation.command[0]).name

    @property
    def source_hash(self) -> str:
        """SHA-256 of the program's file, and of files among its arguments."""
        digest = hashlib.sha256()
        folder = Path(self._isolation.working_dir or "")  # what the program's arguments are relative to
        program, *words = self._isolation.command
        for path in (Path(which(program) or ""), *(folder / word for word in words)):
            if path.is_file():
                digest.update(path.read_bytes())
        return digest.hexdigest()

    def foresee(self, sets: Iterable[Mapping[str, Any]]) -> None:
        """Nothing to prepare."""

    def checked(self, values: Mapping[str, Any], loc: tuple[str, ...], place: Place) -> FarParameters:  # noqa: ARG002
        """The values as they are."""
        return FarParameters(dict(values), dict(values), self._preview)

    def preview_for(self, parameters: FarParameters) -> Preview | None:
        """What the planner file says that it wants to see of the future."""
        return parameters.preview

    def build(self, parameters: FarParameters) -> Planner:
        """The program, to be started by its first setup."""
        return IsolatedPlanner(parameters, self._isolation, "", None)


def _key(values: Mapping[str, Any]) -> str:
    return json.dumps(dict(values), sort_keys=True, default=encoded)
