"""What a planner file's `planner` is: a class here, a class in a process of its own, or a program."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, Protocol

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.class_elsewhere import ClassElsewhere, Command
from pytest_lpb.planner.class_here import ClassHere, IsolatedClass
from pytest_lpb.planner.parameter_names import Place
from pytest_lpb.problem.preview import Preview

POSIX = os.name == "posix"


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
    def supports(self) -> Any:
        """What it declares to support; nothing: anything."""

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


def definition_of(reference: str, isolation: Isolation | None) -> Definition:
    """The definition of a planner file. Raises ConfigurationError when there is no such class or program."""
    if isolation is None:
        return ClassHere(reference)
    if not POSIX:
        raise ConfigurationError(f"{reference or isolation.place}: a process of its own needs Linux, macOS or the like")
    if isolation.command:
        return Command(isolation)
    if isolation.same_interpreter:
        return IsolatedClass(reference, isolation)
    return ClassElsewhere(reference, isolation)
