"""A planner class that is imported into this process."""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError
from pydantic.errors import PydanticUserError

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.far.support import declaration
from pytest_lpb.isolation.far.values import decoded
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.elsewhere import FarParameters, IsolatedPlanner
from pytest_lpb.planner.parameter_names import Place, check_names
from pytest_lpb.planner.registry import planner_class
from pytest_lpb.problem.preview import Preview


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

    @property
    def supports(self) -> Any:
        """What the class declares."""
        return declaration(self.cls)

    def _file(self) -> Path | None:
        try:
            file = inspect.getsourcefile(self.cls)
        except (OSError, TypeError):
            return None
        return Path(file) if file is not None and Path(file).is_file() else None

    def checked(self, values: Mapping[str, Any], loc: tuple[str, ...], place: Place) -> Any:
        """An instance of the class's Parameters. Raises ConfigurationError."""
        adapter = _adapter(self.identity, self.cls.Parameters)
        check_names(values, [item.name for item in dataclasses.fields(self.cls.Parameters)], self.identity, loc, place)
        try:
            return decoded(values, lambda text: adapter.validate_json(text, strict=True), _places)
        except ValidationError as error:
            raise ConfigurationError(
                "\n".join(f"{place(*loc, *map(str, fault['loc']))}: {_told(fault)}" for fault in error.errors())
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


def _told(fault: Any) -> str:
    if fault["type"] == "finite_number":
        return f"found {fault['input']}; a finite number is required"
    return f"{fault['msg']}, found {fault['input']!r}"


def _places(error: Any) -> list[Any]:
    """Where in the values pydantic's faults are."""
    return [fault["loc"] for fault in error.errors()] if isinstance(error, ValidationError) else []


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
