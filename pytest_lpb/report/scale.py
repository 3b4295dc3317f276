"""Axes: from values to places, with ticks at round numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.kpis.derived import DIVERGED
from pytest_lpb.report.numbers import minus, show
from pytest_lpb.report.view import Tick

FloatArray = NDArray[np.float64]

LARGEST = DIVERGED  # beyond, values are told but not drawn
SMALLEST = 1.0 / LARGEST  # below, they are drawn as zero
SAME = 1e-9  # values that differ by less than this share of them are drawn as one

LOG_FROM_RATIO = 100.0  # largest over smallest value from which an axis is logarithmic


@dataclass(frozen=True)
class Scale:
    """An axis from `low` to `high`, linear or logarithmic."""

    low: float
    high: float
    logarithmic: bool = False

    def place(self, values: FloatArray) -> FloatArray:
        """Where values lie: 0 at `low`, 1 at `high`, and -1 or 2 for those far outside; NaN for NaN."""
        if self.logarithmic:
            logarithms = np.log(np.clip(values, self.low, self.high))
            return np.asarray((logarithms - math.log(self.low)) / (math.log(self.high) - math.log(self.low)))
        length = self.high - self.low
        within = np.clip(values, self.low - length, self.high + length)
        return np.asarray((within - self.low) / length, dtype=np.float64)

    def ticks(self, most: int = 6) -> list[Tick]:
        """At most about `most` ticks, places in [%]."""
        values = _log_values(self.low, self.high, most) if self.logarithmic else round_values(self.low, self.high, most)
        places = 100 * self.place(np.asarray(values))
        labels = [show(value, 1) for value in values] if self.logarithmic else tick_labels(values)
        return [Tick(round(float(at), 2), label) for at, label in zip(places, labels, strict=True)]


def drawable(values: FloatArray) -> NDArray[np.bool_]:
    """Which values an axis can hold: no NaN, no infinity, nothing beyond `LARGEST`."""
    return np.asarray(np.abs(values) <= LARGEST)


def scale_for(values: FloatArray, *, may_be_logarithmic: bool = False) -> Scale:
    """An axis that holds all drawable values (at least one), with a little room."""
    values = values[drawable(values)]
    values = np.where(np.abs(values) < SMALLEST, 0.0, values)
    low, high = float(values.min()), float(values.max())
    if may_be_logarithmic and low > 0 and high / low > LOG_FROM_RATIO:
        return Scale(low / 1.2, high * 1.2, logarithmic=True)
    largest = max(abs(low), abs(high))
    room = 0.04 * (high - low) if high - low > SAME * largest else 0.1 * largest or 1.0
    if low >= 0 and low < 0.5 * high:
        return Scale(0.0, high + room)
    return Scale(low - room, high + room)


def round_values(low: float, high: float, most: int) -> list[float]:
    """Multiples of 1, 2 or 5 times a power of ten between low and high."""
    rough = (high - low) / max(most - 1, 1)
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough * 0.999)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [number * step for number in range(first, last + 1)]


def tick_labels(values: list[float]) -> list[str]:
    """Labels with the same number of decimals, no more than needed."""
    if not values:
        return []
    step = min(np.diff(values), default=abs(values[0]) or 1.0)
    largest = max(abs(value) for value in values)
    if largest >= 1e7 or step < 1e-5:
        digits = math.ceil(math.log10(largest / step) - 1e-9) + 1 if largest > 0 else 2
        return [show(value, max(digits, 2)) for value in values]
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return [minus(f"{value + 0.0:.{decimals}f}") if abs(value) > step / 2 else "0" for value in values]


def _log_values(low: float, high: float, most: int) -> list[float]:
    """Powers of ten; with 2 and 5, or 3, between them where they are few."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    stride = max(1, math.ceil((last - first) / most))
    decades = math.log10(high / low)
    factors = (1, 2, 5) if decades <= 2 else (1, 3) if decades <= 3 else (1,)
    candidates = [factor * 10.0**exponent for exponent in range(first, last + 1, stride) for factor in factors]
    return [value for value in candidates if low <= value <= high]
