"""Plain YAML scalars as the YAML 1.2 core schema means them, where they are unambiguous.

PyYAML follows YAML 1.1: it reads `1e-3` as text, `on` as a boolean, `012` as ten and `1:30` as ninety.
Here `1e-3` is a number; `on`, `yes`, `012` and `1:30` are text.
"""

import re
from typing import Final

MAX_NUMBER_LENGTH = 100  # characters

WORDS: Final[dict[str, bool | float | None]] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **{sign + word: float(sign + "inf") for sign in ("", "+", "-") for word in (".inf", ".Inf", ".INF")},
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
INTEGER = re.compile(r"[-+]?(?:0|[1-9][0-9]*)")
BASED_INTEGER = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
# Without leading zeros: 012 means ten, twelve or a text, depending on the reader.
FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|(?:0|[1-9][0-9]*)(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
NUMBER_START = frozenset("+-.0123456789")

Scalar = str | bool | int | float | None


def resolve(text: str) -> Scalar:
    """The value of a plain scalar.

    Raises:
        ValueError: a number of more than `MAX_NUMBER_LENGTH` characters.
    """
    if text in WORDS:
        return WORDS[text]
    if text[0] not in NUMBER_START:
        return text
    for pattern, convert in ((INTEGER, int), (FLOAT, float), (BASED_INTEGER, lambda digits: int(digits, 0))):
        if pattern.fullmatch(text):
            if len(text) > MAX_NUMBER_LENGTH:
                raise ValueError(f"found a number of {len(text)} characters; allowed are at most {MAX_NUMBER_LENGTH}")
            return convert(text)
    return text
