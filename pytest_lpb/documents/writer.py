"""Write plain data as YAML that `read_yaml`, and any other YAML reader, reads back as the same data.

A concrete problem is written in every trial, so this is no place for a general emitter: PyYAML's takes milliseconds.
"""

import json
import re
from math import isfinite
from typing import Any

# Words that YAML 1.1 or 1.2 would not take for text.
_NOT_TEXT = frozenset(("null", "true", "false", "yes", "no", "on", "off", "y", "n"))
_WORDS = {None: "null", True: "true", False: "false"}
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def dump_yaml(data: dict[str, Any]) -> str:
    """Plain data (mappings, lists, text, finite numbers, booleans, None) as YAML in the order given.

    Each part of the top level is a line in flow style; a list of mappings is a line per item.
    """
    lines = []
    for key, value in data.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            lines.append(f"{_text(key)}:")
            lines += [f"  - {_flow(item)}" for item in value]
        else:
            lines.append(f"{_text(key)}: {_flow(value)}")
    return "\n".join(lines) + "\n" if lines else "{}\n"


def _flow(value: Any) -> str:
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_text(key)}: {_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if value is None or isinstance(value, bool):
        return _WORDS[value]
    number = repr(value)
    if isinstance(value, float):
        if not isfinite(value):
            raise ValueError(f"{number} cannot be written as YAML that JSON readers read too")
        if "e" in number and "." not in number:
            # YAML 1.1 takes 1e+16 for text, 1.0e+16 for the number.
            return number.replace("e", ".0e")
    return number


def _text(text: str) -> str:
    """Text as it is where every reader takes it for text, else in double quotes."""
    if _PLAIN.fullmatch(text) and text.lower() not in _NOT_TEXT:
        return text
    quoted = json.dumps(text, ensure_ascii=False)
    if quoted.isprintable():
        return quoted
    return "".join(char if char.isprintable() else _escaped(char) for char in quoted)


def _escaped(char: str) -> str:
    code = ord(char)
    return f"\\u{code:04x}" if code <= 0xFFFF else f"\\U{code:08x}"
