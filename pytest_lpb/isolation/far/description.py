"""What a planner's class says of itself: its parameters, the preview it wants, its source."""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import json
import os
import typing
from collections.abc import Mapping
from typing import Any

KINDS = {int: (int,), float: (int, float), str: (str,), bool: (bool,)}  # what a field of a plain type accepts


def described(cls: Any, sets: list[Mapping[str, Any]]) -> dict[str, Any]:
    """What is to be known of a class before any trial, with each of several sets of parameters."""
    return {
        "class": cls.__module__ + ":" + cls.__qualname__,
        "fields": [field.name for field in dataclasses.fields(cls.Parameters)],
        "source_hash": source_hash(cls),
        "sets": [_with(cls, values) for values in sets],
    }


def _with(cls: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    try:
        parameters = parameters_of(cls, values)
    except (TypeError, ValueError) as error:
        return {"fault": str(error)}
    preview = cls.preview_for(parameters)
    return {
        "parameters": dataclasses.asdict(parameters),
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
    return TypeAdapter(cls.Parameters).validate_json(json.dumps(dict(values)), strict=True)


def _plainly_checked(parameters: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values of fields of plain types checked; lists for tuples made tuples."""
    try:
        hints = typing.get_type_hints(parameters)
    except Exception:
        hints = {}  # written for a newer Python: the class itself will say what it does not take
    checked = {}
    for name, value in values.items():
        hint = hints.get(name)
        kinds = KINDS.get(hint)  # type: ignore[arg-type] # what is no plain type is not in it
        if kinds and not (isinstance(value, kinds) and (hint is bool or not isinstance(value, bool))):
            raise ValueError(name + ": found " + repr(value) + "; its type is " + hint.__name__)  # type: ignore[union-attr] # a class
        of_tuple = getattr(hint, "__origin__", hint) is tuple and isinstance(value, list)
        checked[name] = tuple(value) if of_tuple else value
    return checked


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
