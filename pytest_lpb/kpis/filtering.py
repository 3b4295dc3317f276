"""The motion signal of the smoothness KPIs: positions at 100 Hz, low-pass filtered without delay."""

from __future__ import annotations

from functools import cache

import numpy as np

from pytest_lpb.kpis.derived import norms, once, positions
from pytest_lpb.trajectory import FloatArray, Trajectory

SAMPLING_HZ = 100.0
CUTOFF_HZ = 5.0
FILTER_ORDER = 4
SHORTEST_S = 1.0  # [s] below this the spectrum has too few samples under the cutoff

# [m/s] A robot whose speed stays below this has not moved: the outcome `stalled` draws the same line. Such a
# speed profile would have the shape of rounding errors.
STILL_SPEED = 1e-3


@once
def filtered_positions(trajectory: Trajectory) -> FloatArray | None:
    """Positions p relative to p_0, resampled and filtered, (n, 3) [m]; None under 1 s.

    A cubic spline through the rows, sampled at 100 Hz, then a 4th-order Butterworth low-pass at 5 Hz run
    forwards and backwards, as before any differentiation of measured motion (Winter 2009, "Biomechanics and
    Motor Control of Human Movement"). None too where a position is missing.
    """
    path, dt = positions(trajectory), trajectory.problem.dt
    duration = (len(path) - 1) * dt
    if duration < SHORTEST_S * (1.0 - 1e-9) or len(path) < 4 or not np.isfinite(path).all():
        return None
    from scipy.interpolate import CubicSpline
    from scipy.signal import filtfilt

    # Relative to the start, so that rounding errors do not grow with the distance to the world's origin.
    spline = CubicSpline(np.arange(len(path)) * dt, path - path[0])
    samples = np.arange(int(duration * SAMPLING_HZ + 1e-6) + 1) / SAMPLING_HZ
    return np.asarray(filtfilt(*_low_pass(), spline(samples), axis=0), dtype=np.float64)


@once
def filtered_speed(trajectory: Trajectory) -> FloatArray | None:
    """Speed from the filtered positions, (n - 1,) [m/s] at 100 Hz; None without a second of motion."""
    filtered = filtered_positions(trajectory)
    if filtered is None:
        return None
    speed = norms(np.diff(filtered, axis=0)) * SAMPLING_HZ
    return speed if speed.max() >= STILL_SPEED else None


@cache
def _low_pass() -> tuple[FloatArray, FloatArray]:
    from scipy.signal import butter

    numerator, denominator = butter(FILTER_ORDER, CUTOFF_HZ, fs=SAMPLING_HZ)
    return np.asarray(numerator), np.asarray(denominator)
