"""Planner configuration files: which class, with which parameters, for which robots."""

from __future__ import annotations

import dataclasses
import fnmatch
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from pytest_lpb.documents.reader import Document
from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.far.values import encoded
from pytest_lpb.isolation.settings import Isolation, faults_here
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.definition import Definition, definition_of
from pytest_lpb.planner.elsewhere import FarParameters
from pytest_lpb.planner.support import Support, checked_support, why_unsupported
from pytest_lpb.problem.hashing import hash_of, plain
from pytest_lpb.problem.preview import Preview

MAX_STEPS = 1_000_000
ROUNDING = 1e-6  # relative slack of "a multiple of dt"


@dataclass(frozen=True)
class PlannerConfiguration:
    """A configured planner. Picklable: any process can build the planner from it.

    Raises ConfigurationError for parameters that the class does not have or that have the wrong type.
    """

    name: str  # as users call it; the stem of its file
    planner: str  # registered name or module:Class; empty for a program
    parameters: Mapping[str, Any] = field(default_factory=dict)
    per_robot: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    period: float | None = None  # [s]; None: every step
    delay: float = 0.0  # [s]
    xfail: Mapping[str, Any] = field(default_factory=dict)  # by scenario glob
    supports: Mapping[str, Any] = field(default_factory=dict)  # what the file declares, besides the class
    isolation: Isolation | None = None  # None: in this process
    path: Path | None = None
    document: Document | None = field(default=None, repr=False, compare=False)  # for the lines of faults

    @cached_property
    def definition(self) -> Definition:
        """What the planner is, and where. Raises ConfigurationError when there is no such thing."""
        faults = () if self.isolation is None else faults_here(self.isolation)
        if told := "\n".join(f"{self._place(key)}: {text}" for key, text in faults):
            raise ConfigurationError(told)
        try:
            definition = definition_of(self.planner, self.isolation)
        except ConfigurationError as error:
            if self.document is None:
                raise
            raise ConfigurationError(f"{self._place('planner')}: {error}") from error
        definition.foresee(self._merges())
        return definition

    def _merges(self) -> Iterator[dict[str, Any]]:
        """All parameters that some robot may get."""
        names = {key.partition("@")[0] for key in self.per_robot}
        controls = {key.partition("@")[2] for key in self.per_robot}
        for robot in sorted(names | {""}):
            for control in sorted(controls | {""}):
                yield self._merged(robot, control)
        for own in self.per_robot.values():
            yield {**self.parameters, **own}

    # Parameters by (robot, control): every trial asks, and validation costs more than a trial step.
    _resolved: dict[tuple[str, str], Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def check(self) -> None:
        """Check the parameters of every robot against the class, and what it supports. Raises ConfigurationError."""
        self._validated(dict(self.parameters), "parameters")
        for robot, parameters in self.per_robot.items():
            self._validated({**self.parameters, **parameters}, "per_robot", robot)
        self.support  # noqa: B018 - is checked when it is read, which a class that cannot be had prevents

    @cached_property
    def support(self) -> tuple[Support, Support]:
        """What the class declares to support, and what its file does: both hold. Raises ConfigurationError."""
        cls = self.definition.identity
        return (
            checked_support(self.definition.supports, f"planner {self.name!r}: {cls}.supports"),
            checked_support(self.supports, self._place("supports")),
        )

    def unsupported(self, robot: Mapping[str, Any]) -> str:
        """Why a robot is not supported, as declared; empty when it is.

        Args:
            robot: the `robot` section of a concrete problem.
        """
        return next(filter(None, (why_unsupported(support, robot) for support in self.support)), "")

    def parameters_for(self, robot: str, control: str) -> Any:
        """The class's Parameters for a robot; the most specific entry of `per_robot` wins, key by key."""
        known = self._resolved.get((robot, control))
        if known is not None:
            return known
        self._resolved[robot, control] = parameters = self._validated(self._merged(robot, control), "parameters")
        return parameters

    def _merged(self, robot: str, control: str) -> dict[str, Any]:
        merged = dict(self.parameters)
        for key in (f"@{control}", robot, f"{robot}@{control}"):
            merged.update(self.per_robot.get(key, {}))
        return merged

    def preview_for(self, parameters: Any) -> Preview | None:
        """What the planner wants to see of the future with these parameters."""
        return self.definition.preview_for(parameters)

    def build(self) -> Planner:
        """A new planner with the parameters that hold for no robot in particular."""
        return self.definition.build(self._validated(dict(self.parameters), "parameters"))

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
        content = {
            "class": self.definition.identity,
            "parameters": plain(resolved(self._validated(dict(self.parameters), "parameters"))),
            "per_robot": plain(self.per_robot),
            "period": self.period,
            "delay": self.delay,
        }
        elsewhere = plain(self.isolation.hashed()) if self.isolation else None
        return hash_of(content | {"isolation": elsewhere} if elsewhere else content)

    @cached_property
    def source_hash(self) -> str:
        """SHA-256 of the file of the planner's class, or of all in its folder if that is a package; empty when none."""
        return self.definition.source_hash

    @property
    def source(self) -> dict[str, str] | None:
        """Module and file of the planner's class, to load it again elsewhere; None for those of this package."""
        return self.definition.source

    def _defaults(self) -> Any:
        return recorded(self._validated(dict(self.parameters), "parameters"))

    def to_dict(self) -> dict[str, Any]:
        """What run.json says of the planner: resolved parameters, hashes, timing."""
        isolation = self.isolation
        isolated = {"isolation": plain(isolation.to_dict()), "runs": self.definition.about} if isolation else {}
        return {
            "planner": self.planner,
            "file": str(self.path) if self.path else None,
            "parameters": self._defaults(),
            "per_robot": encoded(self.per_robot),
            "parameters_hash": self.parameters_hash,
            "source_hash": self.source_hash,
            "source": self.source,
            "period": self.period,
            "delay": self.delay,
            **({"supports": supports} if any(supports := [encoded(one) for one in self.support]) else {}),
            **isolated,
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
        return self.definition.checked(parameters, loc, self._place)


def recorded(parameters: Any) -> Any:
    """Parameters as records hold them, with all defaults: in JSON's types, from which they can be loaded again."""
    return encoded(resolved(parameters))


def resolved(parameters: Any) -> Mapping[str, Any]:
    """Parameters by name, with all defaults."""
    return parameters.resolved if isinstance(parameters, FarParameters) else dataclasses.asdict(parameters)
