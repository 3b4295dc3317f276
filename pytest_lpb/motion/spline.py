"""Motion along a cubic spline through given points."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion.jets import FloatArray
from pytest_lpb.motion.motion import Motion

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline


class SplineMotion(Motion):
    """A cubic spline through rows [t, x, y, ...], held with zero velocity outside its time span.

    Clamped: it starts and ends at rest. Periodic: the last row repeats the first position, time wraps around.

    Args:
        rows: (K, 1 + m), K >= 2 (periodic: 3), times strictly increasing [s].
        periodic: whether the motion repeats.

    Raises:
        ScenarioError: too few rows, rows of unequal length, times that do not increase, or a periodic
            spline that does not close.
    """

    def __init__(self, rows: Sequence[Sequence[float]], periodic: bool = False) -> None:
        _check(rows, periodic)
        table = np.array(rows, dtype=np.float64)
        self.times: FloatArray = table[:, 0]
        self.points: FloatArray = table[:, 1:]
        self.periodic = periodic
        self.size = self.points.shape[1]
        self.moving = bool(np.any(self.points != self.points[0]))

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key not in ("_spline", "_jerk_bound")}

    @cached_property
    def _spline(self) -> CubicSpline[np.float64]:
        # Imported late: SciPy takes longer to import than a scenario takes to load.
        from scipy.interpolate import CubicSpline

        return CubicSpline(self.times, self.points, bc_type="periodic" if self.periodic else "clamped")

    def evaluate(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The spline and its derivatives, see `Motion.evaluate`."""
        t = np.asarray(t, dtype=np.float64)
        first, last = self.times[0], self.times[-1]
        inside = np.full(t.shape, True) if self.periodic else (t >= first) & (t <= last)
        when = first + np.mod(t - first, last - first) if self.periodic else np.clip(t, first, last)
        position, velocity, acceleration = (np.asarray(self._spline(when, order)) for order in range(3))
        velocity[~inside] = 0.0
        acceleration[~inside] = 0.0
        return position, velocity, acceleration

    def speed_bound(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Of the piecewise quadratic velocity, see `Motion.speed_bound`.

        Within a span of length h a coordinate's velocity leaves the chord between its ends by at most J h^2 / 8, where
        J bounds the jerk, which is constant in each piece.
        """
        start, end = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
        first, last = self.times[0], self.times[-1]
        if not self.periodic:
            # Outside of its span of time it stands, and at both ends its velocity is zero.
            start, end = np.clip(start, first, last), np.clip(end, first, last)
        ends = np.maximum(np.abs(self.evaluate(start)[1]), np.abs(self.evaluate(end)[1]))
        rates = ends + self._jerk_bound * (0.125 * (end - start) ** 2)[:, None]
        speed: FloatArray = np.sqrt((rates * rates).sum(axis=1))
        return speed

    @cached_property
    def _jerk_bound(self) -> FloatArray:
        """Largest |d3/dt3| of each coordinate over all pieces, (m,)."""
        jerk: FloatArray = np.abs(np.asarray(self._spline(self.times[:-1], 3))).max(axis=0)
        return jerk


def _check(rows: Sequence[Sequence[float]], periodic: bool) -> None:
    fewest = 3 if periodic else 2
    if len(rows) < fewest:
        raise ScenarioError(f"found {len(rows)} rows; a {'periodic ' * periodic}spline needs at least {fewest}")
    for index, row in enumerate(rows):
        if len(row) != len(rows[0]) or len(row) < 2:
            raise ScenarioError(f"row {index} has {len(row)} numbers; every row is [t, x, ...] as long as the first")
        if index and row[0] <= rows[index - 1][0]:
            raise ScenarioError(
                f"row {index} has the time {row[0]}, not after {rows[index - 1][0]}; times must increase"
            )
    if periodic and list(rows[0][1:]) != list(rows[-1][1:]):
        raise ScenarioError(
            f"the last row {list(rows[-1][1:])} differs from the first {list(rows[0][1:])}; "
            "a periodic spline ends where it begins"
        )
