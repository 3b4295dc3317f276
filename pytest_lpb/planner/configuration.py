"""Planner configuration files: which class, with which parameters, for which robots."""

from __future__ import annotations

import dataclasses
import fnmatch
import hashlib
import inspect
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError
from pydantic.errors import PydanticUserError

from pytest_lpb.documents.reader import Document
from pytest_lpb.errors import ConfigurationError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.registry import planner_class
from pytest_lpb.problem.hashing import hash_of, plain

MAX_STEPS = 1_000_000
ROUNDING = 1e-6  # relative slack of "a multiple of dt"


@dataclass(frozen=True)
class PlannerConfiguration:
    """A configured planner. Picklable: any process can build the planner from it.

    Raises ConfigurationError for parameters that the class does not have or that have the wrong type.
    """

    name: str  # as users call it; the stem of its file
    planner: str  # registered name or module:Class
    parameters: Mapping[str, Any] = field(default_factory=dict)
    per_robot: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    period: float | None = None  # [s]; None: every step
    delay: float = 0.0  # [s]
    xfail: Mapping[str, Any] = field(default_factory=dict)  # by scenario glob
    path: Path | None = None
    document: Document | None = field(default=None, repr=False, compare=False)  # for the lines of faults

    @cached_property
    def planner_class(self) -> type[Planner]:
        """The planner's class."""
        return planner_class(self.planner)

    # Parameters by (robot, control): every trial asks, and validation costs more than a trial step.
    _resolved: dict[tuple[str, str], Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def check(self) -> None:
        """Check the parameters of every robot against the class. Raises ConfigurationError."""
        self._validated(dict(self.parameters), "parameters")
        for robot, parameters in self.per_robot.items():
            self._validated({**self.parameters, **parameters}, "per_robot", robot)

    def parameters_for(self, robot: str, control: str) -> Any:
        """The class's Parameters for a robot; the most specific entry of `per_robot` wins, key by key."""
        known = self._resolved.get((robot, control))
        if known is not None:
            return known
        merged = dict(self.parameters)
        for key in (f"@{control}", robot, f"{robot}@{control}"):
            merged.update(self.per_robot.get(key, {}))
        self._resolved[robot, control] = parameters = self._validated(merged, "parameters")
        return parameters

    def build(self) -> Planner:
        """A new planner with the parameters that hold for no robot in particular."""
        return self.planner_class(self._validated(dict(self.parameters), "parameters"))

    def steps_per_call(self, dt: float) -> int:
        """Steps between two calls. Raises ConfigurationError when the period is no multiple of dt [s]."""
        return 1 if self.period is None else self._multiple("period", self.period, dt, least=1)

    def steps_of_delay(self, dt: float) -> int:
        """Steps by which actions act later. Raises ConfigurationError when the delay is no multiple of dt [s]."""
        return self._multiple("delay", self.delay, dt, least=0)

    def _multiple(self, key: str, value: float, dt: float, least: int) -> int:
        if value > MAX_STEPS * dt:
            raise ConfigurationError(
                f"{self._place(key)}: found {value:g} s; allowed are at most {MAX_STEPS} steps of dt"
            )
        steps = round(value / dt)
        if steps < least or abs(steps * dt - value) > ROUNDING * dt:
            raise ConfigurationError(
                f"{self._place(key)}: {value:g} s is no multiple of this scenario's dt = {dt:g} s; "
                f"use {max(steps, least) * dt:g}"
            )
        return steps

    @cached_property
    def parameters_hash(self) -> str:
        """SHA-256 of everything that decides what the planner does, wherever its file lies."""
        defaults = plain(dataclasses.asdict(self._validated(dict(self.parameters), "parameters")))
        per_robot = plain(self.per_robot)
        cls = self.planner_class
        return hash_of(
            {
                "class": f"{cls.__module__}:{cls.__qualname__}",
                "parameters": defaults,
                "per_robot": per_robot,
                "period": self.period,
                "delay": self.delay,
            }
        )

    @cached_property
    def source_hash(self) -> str:
        """SHA-256 of the file of the planner's class, or of all in its folder if that is a package; empty when none."""
        try:
            source = inspect.getsourcefile(self.planner_class)
        except TypeError:
            return ""
        if source is None or not Path(source).is_file():
            return ""
        file = Path(source)
        packaged = (file.parent / "__init__.py").is_file()
        files = sorted(path for path in file.parent.rglob("*.py") if path.is_file()) if packaged else [file]
        digest = hashlib.sha256()
        for path in files:
            digest.update(path.relative_to(file.parent).as_posix().encode() + b"\0" + path.read_bytes())
        return digest.hexdigest()

    @property
    def source(self) -> dict[str, str] | None:
        """Module and file of the planner's class, to load it again elsewhere; None for those of this package."""
        cls = self.planner_class
        if cls.__module__.partition(".")[0] == "pytest_lpb":
            return None
        try:
            file = inspect.getsourcefile(cls)
        except (OSError, TypeError):
            file = None
        return {"module": cls.__module__, "file": str(Path(file).resolve()) if file else ""}

    def to_dict(self) -> dict[str, Any]:
        """What run.json says of the planner: resolved parameters, hashes, timing."""
        defaults = plain(dataclasses.asdict(self._validated(dict(self.parameters), "parameters")))
        return {
            "planner": self.planner,
            "file": str(self.path) if self.path else None,
            "parameters": defaults,
            "per_robot": plain(self.per_robot),
            "parameters_hash": self.parameters_hash,
            "source_hash": self.source_hash,
            "source": self.source,
            "period": self.period,
            "delay": self.delay,
        }

    def expected_failure(self, scenario: str) -> Any:
        """The xfail entry of this planner's file for a scenario, or None."""
        return next((entry for glob, entry in self.xfail.items() if fnmatch.fnmatchcase(scenario, glob)), None)

    def _place(self, *loc: str) -> str:
        """How messages call a part of the configuration: its file and line, where it has one."""
        key = ": ".join(loc)
        if self.document is None:
            return f"planner {self.name!r}: {key}"
        return f"{self.path}:{self.document.line_of(loc)}: {key}"

    def _validated(self, parameters: dict[str, Any], *loc: str) -> Any:
        cls = self.planner_class
        adapter = _adapter(f"{cls.__module__}:{cls.__qualname__}", cls.Parameters)
        allowed = {item.name for item in dataclasses.fields(cls.Parameters)}
        for key in parameters:
            if key not in allowed:
                raise ConfigurationError(
                    f"{self._place(*loc, key)}: unknown parameter{suggestion(key, allowed)}; "
                    f"{cls.__name__} has {listed(allowed)}"
                )
        try:
            return adapter.validate_json(json.dumps(parameters), strict=True)
        except ValidationError as error:
            raise ConfigurationError(
                "\n".join(
                    f"{self._place(*loc, *map(str, fault['loc']))}: {fault['msg']}, found {fault['input']!r}"
                    for fault in error.errors()
                )
            ) from None


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
