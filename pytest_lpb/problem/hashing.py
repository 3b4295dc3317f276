"""Hashes that identify a problem, a configuration or a trajectory, whatever file or process they came from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

HASHED_SECTIONS = ("robot", "environment", "start", "goal", "obstacles")


def canonical_json(value: Any) -> str:
    """JSON with sorted keys, no blanks, and floats as their shortest exact text."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def hash_of(value: Any) -> str:
    """SHA-256 of a value's canonical JSON, in hexadecimal."""
    return hashlib.sha256(canonical_json(value).encode()).hexdigest()


def hash_of_arrays(arrays: Iterable[NDArray[np.float64]]) -> str:
    """SHA-256 of the bytes of float64 arrays (little endian, C order), shapes included."""
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(repr(array.shape).encode())
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()
