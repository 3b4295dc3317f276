"""Planner classes by name: built-in, from entry points, from conftest.py, or `module:Class`."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from pytest_lpb.errors import ConfigurationError, in_one_line
from pytest_lpb.names import is_name, listed, suggestion

if TYPE_CHECKING:
    from pytest_lpb.planner.base import Planner

ENTRY_POINT_GROUP = "pytest_lpb.planners"

# Built-in planners: name -> module, imported when asked for.
BUILT_IN = {
    "fabrics": "pytest_lpb.planner.fabrics.planner",
    "mpc": "pytest_lpb.planner.mpc.planner",
    "pd": "pytest_lpb.planner.pd",
    "potential_field": "pytest_lpb.planner.potential_field",
}

_classes: dict[str, type[Planner]] = {}


def register(cls: type[Planner]) -> None:
    """Make a planner class known by its `name`.

    Raises ConfigurationError for a bad name, or one that another class has.
    """
    if not isinstance(cls.name, str) or not is_name(cls.name):
        raise ConfigurationError(
            f"planner class {_place(cls)}: name {cls.name!r} is not allowed; use letters, digits, _ . -"
        )
    other = _classes.get(cls.name)
    if other is not None and _place(other) != _place(cls):
        raise ConfigurationError(
            f"planner name {cls.name!r} is taken: {_place(other)} and {_place(cls)} both register it"
        )
    _classes[cls.name] = cls


def registered_names() -> set[str]:
    """Names that `planner_class` finds without an import path."""
    return {*BUILT_IN, *_classes, *(point.name for point in entry_points(group=ENTRY_POINT_GROUP))}


def planner_class(reference: str) -> type[Planner]:
    """The class of a registered name, or of `module:Class`.

    Raises ConfigurationError when there is none, or its module cannot be imported.
    """
    if ":" in reference:
        module, _, attribute = reference.partition(":")
        return _checked(_imported(module, reference, attribute), reference)
    if reference in BUILT_IN:
        import_module(BUILT_IN[reference])
    elif reference not in _classes:
        for point in entry_points(group=ENTRY_POINT_GROUP, name=reference):
            return _checked(_imported(point.module, reference, point.attr), reference)
    if reference not in _classes:
        names = registered_names()
        raise ConfigurationError(
            f"unknown planner {reference!r}{suggestion(reference, names)}; registered: {listed(names)}"
        )
    return _classes[reference]


def _imported(module: str, reference: str, attribute: str) -> Any:
    if not all(part.isidentifier() for part in (*module.split("."), *attribute.split("."))):
        raise ConfigurationError(f"planner {reference!r}: write it as module:Class, such as my_package.planners:Mine")
    try:
        value: Any = import_module(module)
    except Exception as error:
        # A module of a user may fail in any way while it is imported.
        raise ConfigurationError(f"planner {reference!r}: cannot import {module!r}: {in_one_line(error)}") from error
    for part in attribute.split("."):
        if not hasattr(value, part):
            raise ConfigurationError(f"planner {reference!r}: {module!r} has no {part!r}{suggestion(part, dir(value))}")
        value = getattr(value, part)
    return value


def _checked(value: Any, reference: str) -> type[Planner]:
    from pytest_lpb.planner.base import Planner

    if not (isinstance(value, type) and issubclass(value, Planner)):
        raise ConfigurationError(f"planner {reference!r} is {value!r}, not a subclass of pytest_lpb.Planner")
    return value


def _place(cls: type) -> str:
    return f"{cls.__module__}:{cls.__qualname__}"
