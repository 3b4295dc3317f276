"""Random streams of problems: one per seed and part, whatever else a scenario file says."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from pytest_lpb.problem.hashing import canonical_json
from pytest_lpb.problem.robot import FloatArray

# Numbers of the parts in the seed sequence; never change one, it would change every drawn problem.
PART_NUMBERS = {"start": 1, "goal": 2, "obstacles": 3}


class Stream:
    """Numbers in [0, 1) for one part of one problem: PCG64(SeedSequence of seed, part, hash of its ranges).

    A list of groups has one stream per group, so that one group's redraws do not shift the next: all but the first add
    their index to the sequence. Only `Generator.random` is used:
    other distributions may change between versions of NumPy.
    """

    def __init__(self, seed: int, part: str, ranges: Any, index: int = 0) -> None:
        digest = hashlib.sha256(canonical_json(ranges).encode()).digest()
        words = [int.from_bytes(digest[i : i + 4], "little") for i in range(0, len(digest), 4)]
        sequence = np.random.SeedSequence([seed, PART_NUMBERS[part], *words, *([index] if index else [])])
        self._generator = np.random.Generator(np.random.PCG64(sequence))

    def uniform(self, ranges: list[list[float]]) -> list[float]:
        """One number per range [lower, upper]."""
        return [lower + (upper - lower) * float(self._generator.random()) for lower, upper in ranges]

    def integer(self, lower: int, upper: int) -> int:
        """A whole number from lower to upper, both included."""
        return lower + int((upper - lower + 1) * float(self._generator.random()))

    def rows(self, count: int, ranges: list[list[float]]) -> list[list[float]]:
        """`count` rows of one number per range."""
        if not count:
            return []
        bounds = np.array(ranges, dtype=float)
        numbers: FloatArray = self._generator.random((count, len(bounds)))
        values: list[list[float]] = (bounds[:, 0] + (bounds[:, 1] - bounds[:, 0]) * numbers).tolist()
        return values
