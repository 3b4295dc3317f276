"""Messages between the two processes: one line of JSON, then numbers as raw little-endian float64."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

PROTOCOL = 1
NUMBER = np.dtype("<f8")


def encode(header: Mapping[str, Any], payload: bytes = b"") -> bytes:
    """A message; its header says how many bytes follow the line."""
    line = json.dumps(dict(header, bytes=len(payload)), separators=(",", ":"))
    return line.encode() + b"\n" + payload


def decode(message: bytes) -> tuple[dict[str, Any], bytes]:
    """Header and payload of a whole message. Raises ValueError for a header that is no JSON mapping."""
    line, _, payload = message.partition(b"\n")
    try:
        header = json.loads(line)
    except RecursionError:
        raise ValueError("its header goes too deep") from None
    if not isinstance(header, dict):
        raise ValueError("a header is a JSON mapping")
    return header, payload


def layout_of(arrays: Mapping[str, Any]) -> dict[str, Any]:
    """Where each array lies among a payload's numbers: its offset, its length and its shape."""
    layout: dict[str, Any] = {}
    offset = 0
    for name, array in arrays.items():
        layout[name] = [offset, int(array.size), list(array.shape)]
        offset += int(array.size)
    return layout


def packed(arrays: Mapping[str, Any]) -> bytes:
    """All numbers of an observation, array after array."""
    return b"".join([array.tobytes() for array in arrays.values()])
