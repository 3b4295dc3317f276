"""Mappings handed to planners: to be read only, and an attempt to change one says which it is."""

from __future__ import annotations

from typing import Any, NoReturn


class ReadOnlyDict(dict[str, Any]):
    """A dict that refuses to be changed; copies and pickles of it are plain dicts.

    Args:
        path: what the error calls it, such as `problem.goal[0].entry`.
        content: its items.
    """

    def __init__(self, path: str, content: dict[str, Any]) -> None:
        super().__init__(content)
        self._path = path

    def _refuse(self, *_arguments: Any, **_keywords: Any) -> NoReturn:
        key = f"[{_arguments[0]!r}]" if _arguments and isinstance(_arguments[0], str) else ""
        raise TypeError(f"{self._path}{key} is read-only: copy what you change")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type[dict[str, Any]], tuple[dict[str, Any]]]:
        return dict, (dict(self),)
