"""What a planner's class says of itself: its parameters, the preview it wants, its source."""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import os
import typing
from collections.abc import Mapping
from enum import Enum
from pathlib import PurePath
from typing import Any

from pytest_lpb.isolation.far.support import declaration
from pytest_lpb.isolation.far.values import NOT_FINITE, decoded, encoded

COLLECTIONS = (tuple, set, frozenset)  # that JSON has as lists
KINDS = {int: (int,), float: (int, float), str: (str,), bool: (bool,)}  # what a field of a plain type accepts


def described(cls: Any, sets: list[Mapping[str, Any]]) -> dict[str, Any]:
    """What is to be known of a class before any trial, with each of several sets of parameters."""
    return {
        "class": cls.__module__ + ":" + cls.__qualname__,
        "fields": [field.name for field in dataclasses.fields(cls.Parameters)],
        "source_hash": source_hash(cls),
        "supports": encoded(declaration(cls)),
        "sets": [_with(cls, values) for values in sets],
    }


def _with(cls: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    try:
        parameters = parameters_of(cls, values)
    except (TypeError, ValueError) as error:
        return {"fault": str(error)}
    preview = cls.preview_for(parameters)
    return {
        "parameters": encoded(dataclasses.asdict(parameters)),
        "preview": None if preview is None else [preview.steps, preview.step_s],
    }


def parameters_of(cls: Any, values: Mapping[str, Any]) -> Any:
    """The class's Parameters. Raises TypeError or ValueError for values that it does not take."""
    known = {field.name: field for field in dataclasses.fields(cls.Parameters)}
    for name in values:
        if name not in known:
            raise ValueError(name + ": unknown parameter; " + cls.__name__ + " has " + (", ".join(known) or "none"))
    try:
        from pydantic import TypeAdapter
    except Exception:
        return cls.Parameters(**_plainly_checked(cls.Parameters, values))
    adapter = TypeAdapter(cls.Parameters)
    return decoded(values, lambda text: adapter.validate_json(text, strict=True), _places)


def _places(error: Any) -> list[Any]:
    """Places of pydantic's faults."""
    return [fault["loc"] for fault in error.errors()] if hasattr(error, "errors") else []


def _plainly_checked(parameters: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values of fields of plain types checked; those that JSON has as lists and texts made what they are."""
    try:
        hints = typing.get_type_hints(parameters)
    except Exception:
        hints = {}  # written for a newer Python: the class itself will say what it does not take
    return {name: _converted(name, hints.get(name), value) for name, value in values.items()}


def _converted(name: str, hint: Any, value: Any) -> Any:
    """A value as a field's type has it. Raises ValueError for one that a field of a plain type does not take."""
    if hint is float and isinstance(value, str) and value in NOT_FINITE:
        return float(value)
    kinds = KINDS.get(hint) if isinstance(hint, type) else None
    if kinds and not (isinstance(value, kinds) and (hint is bool or not isinstance(value, bool))):
        raise ValueError(name + ": found " + repr(value) + "; its type is " + hint.__name__)
    if isinstance(hint, type) and issubclass(hint, Enum):
        allowed = [member.value for member in hint]
        if value not in allowed:
            raise ValueError(name + ": found " + repr(value) + "; allowed are " + ", ".join(map(repr, allowed)))
        return hint(value)
    if isinstance(hint, type) and issubclass(hint, PurePath) and isinstance(value, str):
        return hint(value)
    kind = getattr(hint, "__origin__", hint)
    if kind in COLLECTIONS and isinstance(value, list):
        inner = [item for item in getattr(hint, "__args__", ()) if item is not Ellipsis]
        of_each = inner if len(inner) == len(value) else inner[:1] * len(value) or [None] * len(value)
        return kind(_converted(name, item, each) for item, each in zip(of_each, value))  # noqa: B905 - Python 3.8
    return value


def source_hash(cls: Any) -> str:
    """SHA-256 of the file of the class, or of all in its folder if that is a package; empty when there is none."""
    try:
        source = inspect.getsourcefile(cls)
    except TypeError:
        source = None
    if source is None or not os.path.isfile(source):  # noqa: PTH113
        return ""
    folder = os.path.dirname(os.path.abspath(source))  # noqa: PTH100, PTH120
    files = [os.path.abspath(source)]  # noqa: PTH100
    if os.path.isfile(os.path.join(folder, "__init__.py")):  # noqa: PTH113, PTH118
        files = [os.path.join(top, name) for top, _, names in os.walk(folder) for name in names if name.endswith(".py")]  # noqa: PTH118
    digest = hashlib.sha256()
    for file in sorted(files):
        with open(file, "rb") as stream:  # noqa: PTH123
            digest.update(os.path.relpath(file, folder).replace(os.sep, "/").encode() + b"\0" + stream.read())
    return digest.hexdigest()
