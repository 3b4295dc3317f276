"""Values of parameters as JSON has them, and back: what a run records can be loaded again."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from math import isfinite
from pathlib import PurePath
from typing import Any

NOT_FINITE = ("inf", "-inf", "nan")  # JSON has no such numbers: as text


def encoded(value: Any) -> Any:
    """A value in JSON's own types, the same whatever the order of a set.

    An enumeration becomes its member's value, a tuple or set a list (a set's sorted), a path its text, and numbers that
    are not finite the text `inf`, `-inf` or `nan`.
    """
    if isinstance(value, Enum):
        return encoded(value.value)
    if isinstance(value, float) and not isfinite(value):
        return str(value)
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, Mapping):
        return {_key(key): encoded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [encoded(item) for item in value]
    if isinstance(value, (set, frozenset)):
        return sorted((encoded(item) for item in value), key=_order)
    if isinstance(value, PurePath):
        return str(value)
    # Dates and times, among others, say themselves how they are written.
    written: Any = value.isoformat() if hasattr(value, "isoformat") else str(value)
    return written


def as_json(values: Mapping[str, Any]) -> str:
    """Given parameters as JSON, with `Infinity` and `NaN` for such numbers."""
    return json.dumps(dict(values), default=encoded)


def decoded(values: Mapping[str, Any], read: Callable[[str], Any], faults: Callable[[Any], Iterable[Any]]) -> Any:
    """What `read` makes of parameters in JSON's types, where text such as `inf` may stand for a number.

    Only where `read` refuses such a text is it taken for the number: in a field of text it stays text.

    Args:
        values: by name of the parameter.
        read: from JSON; raises ValueError.
        faults: places of that error's faults, each a sequence of keys, in which some may be no keys of the values.
    """
    while True:
        try:
            return read(as_json(values))
        except ValueError as error:
            changed = values
            for place in faults(error):
                changed = _as_number(changed, list(place))
            if changed is values:
                raise
            values = changed


def _as_number(value: Any, place: list[Any]) -> Any:
    """The value with the text at a place, if it stands for a number that is not finite, as that number."""
    if isinstance(value, str):
        return float(value) if value in NOT_FINITE else value
    while place and not _has(value, place[0]):
        del place[0]  # such as the name of a union's member
    if not place:
        return value
    changed = _as_number(value[place[0]], place[1:])
    if changed is value[place[0]]:
        return value
    copy = dict(value) if isinstance(value, Mapping) else list(value)
    copy[place[0]] = changed
    return copy


def _has(value: Any, key: Any) -> bool:
    if isinstance(value, Mapping):
        return key in value
    return isinstance(value, (list, tuple)) and isinstance(key, int) and 0 <= key < len(value)


def _key(key: Any) -> str:
    return str(encoded(key))


def _order(value: Any) -> str:
    return json.dumps(value, sort_keys=True)
