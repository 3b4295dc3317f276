"""Text of strangers where it is shown: terminals obey control characters, plots take dollar signs for formulas."""

from __future__ import annotations

import re
from typing import Any, TextIO

# All but tab and newline: C0 with escape, delete, C1, and what turns the direction of writing.
_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def visible(text: str) -> str:
    """A text whose control characters are written out, such as \\x1b, so that a terminal shows them."""
    return _CONTROLS.sub(lambda match: match.group().encode("unicode_escape").decode(), text)


def literal(text: str) -> str:
    """A text for matplotlib without formulas: a dollar sign is one."""
    return text.replace("$", r"\$")


class VisibleStream:
    """A stream that shows control characters instead of obeying them."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write a text, made visible."""
        self._stream.write(visible(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)
