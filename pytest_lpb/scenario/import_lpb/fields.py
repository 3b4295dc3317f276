"""Typed access to an experiment file: whatever it holds, an error names file, line, key, and what is allowed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

from pytest_lpb.documents.faults import described
from pytest_lpb.documents.reader import Document
from pytest_lpb.errors import LpbError
from pytest_lpb.motion.motion import MAX_COORDINATE

Key = str | int
MAX_INTEGER = 1e9
_MISSING = object()


class Fields:
    """One mapping of the file, with the keys that lead to it.

    Attributes:
        path: the experiment file.
        keys: where the mapping stands in it.
        data: its content.
    """

    def __init__(self, document: Document, path: Path, keys: tuple[Key, ...] = (), data: Any = _MISSING) -> None:
        self._document = document
        self.path = path
        self.keys = keys
        self.data: Mapping[Any, Any] = document.data if data is _MISSING else data
        if not isinstance(self.data, Mapping):
            raise self.error(f"found {described(self.data)}; a mapping is required")

    def error(self, what: str, *keys: Key) -> LpbError:
        """An error about this mapping, or about what is below `keys` in it."""
        place = (*self.keys, *keys)
        name = f"{'.'.join(map(str, place))}: " if place else ""
        return LpbError(f"{self.path}:{self._document.line_of(place)}: {name}{what}")

    @property
    def name(self) -> str:
        """The keys that lead here, joined by dots."""
        return ".".join(map(str, self.keys))

    def __contains__(self, key: object) -> bool:
        return self.data.get(key) is not None

    def first(self, *keys: str) -> str:
        """The first of several spellings of a key that is there; the first spelling when none is."""
        return next((key for key in keys if key in self), keys[0])

    def get(self, key: str) -> Any:
        """The value of a key as it stands; None when it is missing or empty."""
        return self.data.get(key)

    def needed(self, key: str) -> Any:
        """The value of a key that every experiment has. Raises LpbError when it is missing or empty."""
        if key not in self:
            raise self.error("is missing; experiments of localPlannerBench have it", key)
        return self.data[key]

    def below(self, key: str) -> Fields:
        """The mapping of a key; an empty one when the key is missing or empty."""
        given = self.get(key)
        return Fields(self._document, self.path, (*self.keys, key), {} if given is None else given)

    def mappings(self) -> dict[str, Fields]:
        """All values, which must be mappings, by their names."""
        return {str(key): Fields(self._document, self.path, (*self.keys, key), data) for key, data in self.data.items()}

    def number(self, key: str, default: float | None = None) -> float:
        """A number in bounds; numbers written as text count, as in the original. Raises LpbError for anything else."""
        if default is not None and key not in self:
            return default
        return self._finite(self.needed(key), key)

    def positive(self, key: str) -> float:
        """A number above 0. Raises LpbError for anything else."""
        value = self.number(key)
        if value <= 0.0:
            raise self.error(f"found {value:g}; a number above 0 is required", key)
        return value

    def integer(self, key: str, default: int | None = None) -> int:
        """A whole number. Raises LpbError for anything else."""
        return default if default is not None and key not in self else self.checked_integer(self.needed(key), [key])

    def checked_integer(self, value: Any, keys: Sequence[Key]) -> int:
        """A value found below `keys` as a whole number. Raises LpbError for anything else."""
        number = self._finite(value, *keys, bound=MAX_INTEGER)
        if number != int(number):
            raise self.error(f"found {number:g}; a whole number is required", *keys)
        return int(number)

    def numbers(self, key: str, count: int | None = None) -> list[float]:
        """A list of finite numbers, `count` of them when given. Raises LpbError for anything else."""
        return self.checked_numbers(self.needed(key), (key,), count)

    def checked_numbers(self, value: Any, keys: Sequence[Key], count: int | None = None) -> list[float]:
        """A value found below `keys` as finite numbers. Raises LpbError for anything else."""
        if not isinstance(value, list):
            raise self.error(f"found {described(value)}; a list of numbers is required", *keys)
        if count is not None and len(value) != count:
            raise self.error(f"found {len(value)} numbers; {count} are required", *keys)
        return [self._finite(number, *keys, index) for index, number in enumerate(value)]

    def _finite(self, value: Any, *keys: Key, bound: float = MAX_COORDINATE) -> float:
        try:
            if isinstance(value, bool) or not isinstance(value, int | float | str):
                raise ValueError
            number = float(value)
            if not isfinite(number) or abs(number) > bound:
                raise ValueError
        except (OverflowError, ValueError):
            raise self.error(
                f"found {described(value)}; a number within ±{MAX_COORDINATE:g} is required", *keys
            ) from None
        return number


def ranges_between(lower: Fields, low: str, upper: Fields, high: str) -> list[list[float]]:
    """[lower, upper] of each entry of two lists, in this order whichever is larger, as numbers are drawn there.

    Raises LpbError unless both lists are of one length.
    """
    first = lower.numbers(low)
    return [sorted(pair) for pair in zip(first, upper.numbers(high, len(first)), strict=True)]
