"""Faults of a scenario file: where, what was found, what is allowed."""

from collections.abc import Sequence
from typing import Any, NamedTuple

MAX_FAULTS = 20

Key = str | int
Loc = tuple[Key, ...]


class Fault(NamedTuple):
    """One fault at a key path."""

    loc: Loc
    message: str


def key_path(loc: Sequence[Key]) -> str:
    """A key path as messages show it, such as `goal[0].target`."""
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in loc)
    return text.removeprefix(".")


def described(value: Any) -> str:
    """A value of a scenario file as messages call it, such as `the text '1.0'`."""
    match value:
        case None:
            return "nothing (null)"
        case bool():
            return f"the boolean {str(value).lower()}"
        case str():
            return f"the text {value!r}" if len(value) <= 60 else f"the text {value[:57]!r}..."
        case list():
            return f"a list of {len(value)}"
        case dict():
            return "a mapping"
    return repr(value)


def capped(lines: Sequence[str]) -> tuple[str, ...]:
    """The first `MAX_FAULTS` lines, and how many more there are."""
    if len(lines) <= MAX_FAULTS:
        return tuple(lines)
    return (*lines[:MAX_FAULTS], f"and {len(lines) - MAX_FAULTS} more")
