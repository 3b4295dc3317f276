"""What planners declare to support: robots, bases and control modes. Trials of others are skipped."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping
from typing import Any

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.names import listed, suggestion

Support = Mapping[str, tuple[str, ...]]  # values by key; a key that is not there: any

CONTROLS = ("acceleration", "velocity", "torque")
BASES = ("fixed", "holonomic", "differential_drive", "bicycle")
# Allowed values by key; None: any name, or a pattern such as `planar_arm_*`.
KEYS: dict[str, tuple[str, ...] | None] = {"robots": None, "base": BASES, "control": CONTROLS}


def checked_support(declared: Any, place: str) -> Support:
    """A declaration with a tuple for each key.

    Args:
        declared: a value or a list of values for each of `robots`, `base` and `control`.
        place: how messages call it.

    Raises ConfigurationError for unknown keys and values.
    """
    if not isinstance(declared, Mapping):
        raise ConfigurationError(
            f"{place}: found {declared!r}; a mapping such as {{'control': ['velocity']}} or a method "
            "supports(self, problem) is needed"
        )
    support = {}
    for key, value in declared.items():
        if key not in KEYS:
            raise ConfigurationError(
                f"{place}: {key}: unknown key{suggestion(str(key), KEYS)}; allowed: {listed(KEYS)}"
            )
        support[key] = _values(value, KEYS[key], f"{place}: {key}")
    return support


def _values(value: Any, allowed: tuple[str, ...] | None, place: str) -> tuple[str, ...]:
    values = [value] if isinstance(value, str) else value
    if not isinstance(values, list | tuple | set | frozenset) or not values:
        raise ConfigurationError(f"{place}: found {value!r}; a name or a list of names is needed")
    for name in values:
        if not isinstance(name, str) or (allowed is not None and name not in allowed):
            known = "names" if allowed is None else listed(allowed)
            hint = "" if allowed is None else suggestion(str(name), allowed)
            raise ConfigurationError(f"{place}: unknown value {name!r}{hint}; allowed: {known}")
    return tuple(sorted(values) if isinstance(values, set | frozenset) else values)


def why_unsupported(support: Support, robot: Mapping[str, Any]) -> str:
    """Why a declaration leaves a robot out; empty when it does not.

    Args:
        support: what is supported.
        robot: the `robot` section of a concrete problem: its name, model, base and control mode.
    """
    robots = support.get("robots")
    names = [str(robot[key]) for key in ("name", "model") if robot.get(key)]
    if robots and not any(fnmatch.fnmatchcase(name, pattern) for name in names for pattern in robots):
        return f"it supports robots {', '.join(robots)}, and this one is {names[0]}{suggestion(names[0], robots)}"
    for key in ("base", "control"):
        if key in support and robot[key] not in support[key]:
            return f"it supports {key} {', '.join(support[key])}, and this is {robot[key]}"
    return ""
