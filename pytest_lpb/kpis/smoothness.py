"""KPIs about smoothness and effort: jerk, spectral arc length, curvature, and how the actions vary."""

from __future__ import annotations

import math

import numpy as np

from pytest_lpb.kpis.derived import actions, measured, norms, positions
from pytest_lpb.kpis.filtering import SAMPLING_HZ, STILL_SPEED, filtered_positions, filtered_speed
from pytest_lpb.kpis.registry import kpi
from pytest_lpb.kpis.units import BY_CONTROL_MODE
from pytest_lpb.trajectory import FloatArray, Trajectory

SPECTRUM_ZERO_PADDING = 4  # the spectrum has 2^4 times the samples of the next power of two
SPECTRUM_CUTOFF_HZ = 10.0
SPECTRUM_THRESHOLD = 0.05  # of the normalised magnitude

SAME_ACTION = 1e-9  # a limiter that did nothing may still round

CURVATURE_SPEED_SHARE = 0.05  # of the peak speed; slower rows have no reliable direction


@kpi("jerk_rms_m_per_s3", "m/s^3", "lower", "solved", group="smoothness")
def jerk_rms(trajectory: Trajectory) -> float:
    """Root mean square of the third difference of the filtered positions [m/s^3]; NaN under 1 s."""
    filtered = filtered_positions(trajectory)
    if filtered is None:
        return math.nan
    jerk = np.diff(filtered, 3, axis=0) * SAMPLING_HZ**3
    return math.sqrt(float(np.einsum("ij,ij->", jerk, jerk)) / len(jerk))


@kpi("ldj", "1", "higher", "solved", group="smoothness")
def ldj(trajectory: Trajectory) -> float:
    """Log dimensionless jerk of the filtered speed; NaN under 1 s and without motion."""
    speed = filtered_speed(trajectory)
    return math.nan if speed is None else log_dimensionless_jerk(speed, SAMPLING_HZ)


@kpi("sparc", "1", "higher", "solved", group="smoothness")
def sparc(trajectory: Trajectory) -> float:
    """Spectral arc length of the filtered speed; NaN under 1 s and without motion."""
    speed = filtered_speed(trajectory)
    return math.nan if speed is None else spectral_arc_length(speed, SAMPLING_HZ)


def log_dimensionless_jerk(speed: FloatArray, frequency_hz: float) -> float:
    """Log dimensionless jerk of a speed profile, −ln(D³/v_peak² ∫ v̈² dt); nearer to 0 is smoother.

    Hogan & Sternad 2009, "Sensitivity of Smoothness Measures to Movement Duration, Amplitude, and Arrests";
    Balasubramanian, Melendez-Calderon & Burdet 2012, "A Robust and Sensitive Metric for Quantifying Movement
    Smoothness".

    Args:
        speed: samples of the speed, (n,), n >= 3 [m/s].
        frequency_hz: samples per second.

    Returns:
        The value [1]; NaN for a speed that is zero, or whose slope never changes (its logarithm is infinite).
    """
    peak = float(np.abs(speed).max())
    second = np.diff(speed, 2) * frequency_hz**2
    integral = float(second @ second) / frequency_hz
    if peak == 0.0 or integral == 0.0:
        return math.nan
    duration = len(speed) / frequency_hz
    return -math.log(duration**3 / peak**2 * integral)


def spectral_arc_length(speed: FloatArray, frequency_hz: float) -> float:
    """Spectral arc length (SPARC) of a speed profile; nearer to 0 is smoother.

    Balasubramanian, Melendez-Calderon, Roby-Brami & Burdet 2015, "On the analysis of movement smoothness":
    length of the normalised Fourier magnitude spectrum up to 10 Hz or to where it last reaches 0.05.

    Args:
        speed: samples of the speed, (n,) [m/s].
        frequency_hz: samples per second.

    Returns:
        The value [1]; NaN for a speed that is zero.
    """
    from scipy.fft import rfft

    length = 2 ** (math.ceil(math.log2(len(speed))) + SPECTRUM_ZERO_PADDING)
    last = min(math.floor(SPECTRUM_CUTOFF_HZ * length / frequency_hz), length // 2)
    magnitude = np.abs(rfft(speed, length))
    peak = float(magnitude.max())
    if peak == 0.0:
        return math.nan
    selected = magnitude[: last + 1] / peak
    above = np.flatnonzero(selected >= SPECTRUM_THRESHOLD)
    if len(above) == 0 or above[0] == above[-1]:
        return math.nan
    heights = np.diff(selected[above[0] : above[-1] + 1])
    return -float(np.sqrt(heights**2 + 1.0 / len(heights) ** 2).sum())


@kpi("curvature_max_per_m", "1/m", "lower", "solved", group="smoothness")
def curvature_max(trajectory: Trajectory) -> float:
    """Largest curvature through three rows, 4 A / (a b c), where speed > 5 % of its peak [1/m]."""
    path = positions(trajectory)
    if len(path) < 3:
        return math.nan
    before, after = path[1:-1] - path[:-2], path[2:] - path[1:-1]
    chord = norms(path[2:] - path[:-2])
    speed = chord / (2.0 * trajectory.problem.dt)
    peak = float(speed[np.isfinite(speed)].max(initial=0.0))
    product = norms(before) * norms(after) * chord
    usable = (speed > CURVATURE_SPEED_SHARE * peak) & (product > 0.0)
    if peak < STILL_SPEED or not usable.any():
        return math.nan
    doubled_area = norms(np.cross(before[usable], after[usable]))
    return float((2.0 * doubled_area / product[usable]).max())


@kpi("action_total_variation", BY_CONTROL_MODE, "lower", "solved", group="smoothness")
def action_total_variation(trajectory: Trajectory) -> float:
    """Sum of ‖a_k − a_{k−1}‖ of the planner's actions; NaN without any."""
    given = actions(trajectory)
    return float(norms(np.diff(given, axis=0)).sum()) if len(given) else math.nan


@kpi("action_squared_integral", BY_CONTROL_MODE, "lower", "solved", group="smoothness")
def action_squared_integral(trajectory: Trajectory) -> float:
    """Integral of ‖a‖² over time; exact, since an action is held for its step; NaN without any action."""
    given = actions(trajectory)
    return float(np.einsum("ij,ij->", given, given)) * trajectory.problem.dt if len(given) else math.nan


@kpi("saturated_steps", "steps", "lower", "all", group="smoothness")
def saturated_steps(trajectory: Trajectory) -> float:
    """Steps in which the robot's limits changed the action; NaN without any action."""
    given, applied = measured(trajectory.action), measured(trajectory.applied)
    comparable = np.isfinite(given).all(axis=1) & np.isfinite(applied).all(axis=1)
    if not comparable.any():
        return math.nan
    differs = ~np.isclose(applied[comparable], given[comparable], rtol=SAME_ACTION, atol=SAME_ACTION)
    return float(np.count_nonzero(differs.any(axis=1)))
