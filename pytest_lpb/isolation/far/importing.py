"""Where planner modules, and our own package for them, come from in the far process."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from importlib import import_module
from typing import Any

from pytest_lpb.isolation.far import shipped, stand_in

OLDEST_OF_OURS = (3, 10)  # our own sources may ask for it
PACKAGE = "pytest_lpb"

_ours: Any = None  # the package as it is used here; None: the stand-in
_reason = ""  # why the stand-in is used


def begin() -> None:
    """Leave the name of our package to what planners are to see of it."""
    shipped.forget(PACKAGE)


def prepare(path: list[str], whole: bool, sources: Mapping[str, str] | None) -> None:
    """Set up where modules are found, and `pytest_lpb`: installed, else sent, else the stand-in.

    Args:
        path: folders; before all others if they are not all.
        whole: whether they are all of sys.path.
        sources: of our package, for when it is not installed; None: it is there.
    """
    sys.path[:] = path if whole else [*path, *(entry for entry in sys.path if entry not in ("", *path))]
    if not (_imported({}) or (sources is not None and _imported(sources))):
        stand_in.install()


def _imported(sources: Mapping[str, str]) -> bool:
    global _ours, _reason
    if sys.version_info < OLDEST_OF_OURS:
        _reason = "this is Python %d.%d, and pytest_lpb needs 3.11" % sys.version_info[:2]  # noqa: UP031
        return False
    if sources:
        shipped.install(sources)
    try:
        package = import_module(PACKAGE)
        package.Planner  # noqa: B018 - imports it
    except Exception as error:
        # Of another version, or missing something: the planner may do without.
        _reason = "pytest_lpb cannot be imported here (" + str(error).replace("\n", " ") + ")"
        shipped.forget(PACKAGE)
        return False
    _ours = package
    return True


def is_ours(file: str) -> bool:
    """Whether a file is one of our package, installed here."""
    init: str = getattr(_ours, "__file__", None) or ""
    return bool(init) and os.path.abspath(file).startswith(os.path.dirname(init) + os.sep)  # noqa: PTH100, PTH120


def class_of(reference: str) -> Any:
    """The planner's class: `module:Class`, or a name that our package knows."""
    module, _, name = reference.partition(":")
    if not name:
        if _ours is None:
            raise LookupError("planner " + repr(reference) + " is one of pytest_lpb: " + _reason)
        return import_module(PACKAGE + ".planner.registry").planner_class(reference)
    value: Any = import_module(module)
    for part in name.split("."):
        value = getattr(value, part)
    base = import_module(PACKAGE).Planner
    if not (isinstance(value, type) and issubclass(value, base)):
        raise TypeError("planner " + repr(reference) + " is " + repr(value) + ", not a subclass of pytest_lpb.Planner")
    return value


def problem_of(entry: Mapping[str, Any], description: Mapping[str, Any] | None) -> Any:
    """The problem with a robot that computes its kinematics, else one that is described; None without description."""
    reason = _reason
    if _ours is not None:
        try:
            return sys.modules[_ours.Planner.__module__].PlannerProblem(entry)
        except Exception as error:
            # Such as a robot whose files are not on this host.
            reason = "the robot cannot be built here (" + str(error).replace("\n", " ") + ")"
    return None if description is None else stand_in.PlannerProblem(entry, description, reason)


def hint(error: BaseException, observation: Mapping[str, Any], problem: Any) -> str:
    """Which array was written into, if that was the fault."""
    if _ours is None or not isinstance(error, ValueError):
        return ""
    said: str = import_module(PACKAGE + ".trial.read_only").hint(error, observation, problem)
    return said
