"""Directions: vectors over their lengths, of length one however short or long the vectors are.

The length |v| = sqrt(v . v) loses its digits where squares leave the range of normal numbers: lengths below 1e-154
vanish, those above 1e154 overflow. So does v / |v| where |v| is no normal number itself: (5e-324, 5e-324) over its
rounded length is (1, 1). Such vectors are divided by their largest component first. All others are divided as they
are: their directions are bit-identical to the plain quotient.

A vector of zeros has no direction; the first axis stands for it, since any direction leads away from a point.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Lengths between which squares, and sums of a few, are normal numbers.
SHORTEST, LONGEST = 1e-140, 1e140


def lengths(vectors: FloatArray) -> FloatArray:
    """Euclidean lengths (..) of vectors (.., d); inf beyond the largest number."""
    with np.errstate(over="ignore"):
        if vectors.shape[-1] == 2:
            plane: FloatArray = np.hypot(vectors[..., 0], vectors[..., 1])
            return plane
        length: FloatArray = np.sqrt((vectors * vectors).sum(axis=-1))
    if ((length > SHORTEST) & (length < LONGEST)).all():
        return length
    return _lengths_over_largest(vectors, length)


def _lengths_over_largest(vectors: FloatArray, length: FloatArray) -> FloatArray:
    """Lengths whose squares may have been lost; those that were not stay as they are."""
    largest = np.abs(vectors).max(axis=-1)
    usual = (length > SHORTEST) & (length < LONGEST) | (largest == 0.0)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        reduced = vectors / largest[..., None]
        exact: FloatArray = np.where(usual, length, largest * np.sqrt((reduced * reduced).sum(axis=-1)))
    return exact


def unit(vectors: FloatArray, length: Any) -> FloatArray:
    """Unit vectors (.., d) along vectors (.., d) whose lengths (..) are known; the first axis for zeros."""
    vectors, length = scaled(vectors, length)
    direction: FloatArray = vectors / length[..., None]
    return direction


def scaled(vectors: FloatArray, length: Any) -> tuple[FloatArray, Any]:
    """Vectors (.., d) of the same directions, and their lengths (..), that can be divided by without loss.

    Both are what was given, but for vectors that are very short or long; zeros become the first axis.
    """
    usual = (length > SHORTEST) & (length < LONGEST)
    if usual.all():
        return vectors, length
    with np.errstate(invalid="ignore"):  # inf / inf: what has diverged has no direction, NaN
        largest = np.abs(vectors).max(axis=-1, keepdims=True)
        reduced = vectors / np.where(largest == 0.0, 1.0, largest)
    reduced[..., :1] = np.where(largest == 0.0, 1.0, reduced[..., :1])
    reduced_length = np.sqrt((reduced * reduced).sum(axis=-1))
    return np.where(usual[..., None], vectors, reduced), np.where(usual, length, reduced_length)


def rescaled(vector: Sequence[float]) -> tuple[float, ...]:
    """A vector over its largest component. Raises ZeroDivisionError for zeros."""
    largest = max(map(abs, vector))
    return tuple(value / largest for value in vector)
