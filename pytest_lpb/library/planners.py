"""A planner by whatever names it: a name, a file, a class, an instance."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from pytest_lpb.documents.recognition import SUFFIXES
from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.class_here import ClassHere
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.definition import Definition
from pytest_lpb.planner.files import find_planners
from pytest_lpb.planner.parameter_names import Place
from pytest_lpb.planner.registry import planner_class

AnyPlanner = str | Path | PlannerConfiguration | type[Planner] | Planner

ALLOWED = (
    "a name such as 'pd', the path of a planner file, 'module:Class', a subclass of pytest_lpb.Planner, "
    "an instance of one, or what load_planner returned"
)


def load_planner(planner: AnyPlanner, parameters: Mapping[str, Any] | None = None) -> PlannerConfiguration:
    """A configured planner, ready for `run_trial`.

    Args:
        planner: a name (`planners/NAME.yaml` in the working folder, a shipped or a registered one), the path of a
            planner file, `NAME=PATH`, `module:Class`, a class, or an instance. Modules are looked up in the working
            folder too, as pytest does.
        parameters: values that replace those of the file, or the defaults of the class.

    Raises ConfigurationError with file and line for what is wrong with a file, its class or its parameters.
    """
    if str(Path.cwd()) not in sys.path and "" not in sys.path:
        sys.path.insert(0, str(Path.cwd()))
    configuration = _configuration(planner)
    if parameters is not None:
        if isinstance(planner, Planner):
            raise ConfigurationError(f"planner {configuration.name!r}: an instance has its parameters already")
        merged = {**configuration.parameters, **parameters}
        # Without its file: what is wrong with these values, or repeats a trial, is not in it.
        configuration = replace(configuration, parameters=merged, path=None, document=None)
    configuration.check()
    return configuration


def _configuration(planner: AnyPlanner) -> PlannerConfiguration:
    if isinstance(planner, PlannerConfiguration):
        return planner
    if isinstance(planner, Planner) or (isinstance(planner, type) and issubclass(planner, Planner)):
        return _given(planner)
    if not isinstance(planner, str | Path):
        raise ConfigurationError(f"planner: found {planner!r}; allowed: {ALLOWED}")
    reference = str(planner)
    if ":" in reference and "=" not in reference and not reference.endswith(SUFFIXES):
        return PlannerConfiguration(_name_of(planner_class(reference)), reference)
    return find_planners([reference], [Path.cwd() / "planners"])[0]


def _name_of(cls: type[Planner]) -> str:
    return getattr(cls, "name", cls.__name__)


def _given(planner: type[Planner] | Planner) -> PlannerConfiguration:
    cls = planner if isinstance(planner, type) else type(planner)
    given = {} if isinstance(planner, type) else dataclasses.asdict(_parameters_of(planner))
    return GivenConfiguration(_name_of(cls), f"{cls.__module__}:{cls.__qualname__}", given, given=planner)


def _parameters_of(planner: Planner) -> Any:
    """An instance's parameters. Raises ConfigurationError unless they are of its class."""
    cls, parameters = type(planner), getattr(planner, "parameters", None)
    if not dataclasses.is_dataclass(parameters) or not isinstance(parameters, cls.Parameters):
        raise ConfigurationError(
            f"planner {cls.__module__}:{cls.__qualname__}: parameters: found {parameters!r}; an instance of "
            f"{cls.__name__}.Parameters is needed: call super().__init__(parameters)"
        )
    return parameters


@dataclass(frozen=True)
class GivenConfiguration(PlannerConfiguration):
    """The configuration of a class or an instance that is at hand, wherever it was defined."""

    given: type[Planner] | Planner | None = field(default=None, repr=False)

    @cached_property
    def definition(self) -> Definition:
        """The class, or the instance."""
        assert self.given is not None, "made with one only"
        return _GivenClass(self.given) if isinstance(self.given, type) else _GivenInstance(self.given)


class _GivenClass(ClassHere):
    """A class that need not be imported."""

    def __init__(self, cls: type[Planner]) -> None:
        self.cls = cls
        self.about = {}


class _GivenInstance(_GivenClass):
    """An instance: it is used as it is, with its own parameters, and left open."""

    def __init__(self, planner: Planner) -> None:
        super().__init__(type(planner))
        self._planner = planner

    def checked(self, values: Mapping[str, Any], loc: tuple[str, ...], place: Place) -> Any:  # noqa: ARG002
        """The instance's own parameters."""
        return _parameters_of(self._planner)

    def build(self, parameters: Any) -> Planner:  # noqa: ARG002 - they are its own
        """The instance."""
        return self._planner
