import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.kpis.filtering import filtered_positions, filtered_speed
from pytest_lpb.kpis.smoothness import curvature_max, jerk_rms, log_dimensionless_jerk, spectral_arc_length

from .trials import Array, make_problem, make_trial


def bell(step: float = 0.01) -> Array:
    t = np.arange(-1.0, 1.0, step)
    values: Array = np.exp(-5.0 * t**2)
    return values


def test_published_reference_values() -> None:
    """Speed exp(−5 t²), t = −1..1 step 0.01 s: the values that the functions of the papers' authors give."""
    assert spectral_arc_length(bell(), 100.0) == pytest.approx(-1.41403, abs=5e-6)
    assert log_dimensionless_jerk(bell(), 100.0) == pytest.approx(-5.81636, abs=5e-6)


def plain_spectral_arc_length(speed: Array, frequency_hz: float) -> float:
    """The algorithm as Balasubramanian et al. 2015 publish it, step by step."""
    length = int(2 ** (np.ceil(np.log2(len(speed))) + 4))
    frequencies = np.arange(0, frequency_hz, frequency_hz / length)
    magnitude = np.abs(np.fft.fft(speed, length))
    magnitude = magnitude / magnitude.max()
    below = frequencies <= 10.0
    frequencies, magnitude = frequencies[below], magnitude[below]
    above = np.nonzero(magnitude >= 0.05)[0]
    chosen = slice(above[0], above[-1] + 1)
    frequencies, magnitude = frequencies[chosen], magnitude[chosen]
    along = np.diff(frequencies) / (frequencies[-1] - frequencies[0])
    return -float(np.sum(np.sqrt(along**2 + np.diff(magnitude) ** 2)))


@given(st.lists(st.floats(0.0, 3.0), min_size=4, max_size=300), st.sampled_from([50.0, 100.0, 250.0]))
def test_spectral_arc_length_agrees_with_the_published_algorithm(speed: list[float], hertz: float) -> None:
    samples = np.array(speed) + 0.01
    assert spectral_arc_length(samples, hertz) == pytest.approx(plain_spectral_arc_length(samples, hertz))


@given(st.floats(0.01, 100.0))
def test_both_ignore_the_scale_of_the_speed(scale: float) -> None:
    assert spectral_arc_length(scale * bell(), 100.0) == pytest.approx(spectral_arc_length(bell(), 100.0))
    assert log_dimensionless_jerk(scale * bell(), 100.0) == pytest.approx(log_dimensionless_jerk(bell(), 100.0))


def test_tremor_is_less_smooth() -> None:
    tremor = bell() * (1.0 + 0.2 * np.sin(40.0 * np.arange(200) / 100.0))
    assert spectral_arc_length(tremor, 100.0) < spectral_arc_length(bell(), 100.0)
    assert log_dimensionless_jerk(tremor, 100.0) < log_dimensionless_jerk(bell(), 100.0)


def test_no_speed_has_no_smoothness() -> None:
    assert math.isnan(spectral_arc_length(np.zeros(200), 100.0))
    assert math.isnan(log_dimensionless_jerk(np.zeros(200), 100.0))
    assert math.isnan(log_dimensionless_jerk(np.ones(200), 100.0))


def wave(dt: float, seconds: float, hertz: float) -> Array:
    t = np.arange(round(seconds / dt) + 1) * dt
    return np.column_stack([np.sin(2.0 * np.pi * hertz * t), np.cos(2.0 * np.pi * hertz * t)])


def test_filter_passes_slow_motion_and_stops_tremor_without_delay() -> None:
    problem = make_problem(dt=0.01)
    slow = wave(0.01, 6.0, 0.5)
    path = filtered_positions(make_trial(problem, slow + 0.01 * wave(0.01, 6.0, 20.0)))
    assert path is not None
    middle = slice(100, -100)
    assert np.abs(path[middle, :2] - (slow - slow[0])[middle]).max() < 0.011  # p_0 itself has the tremor


def test_five_hertz_loses_half_its_amplitude() -> None:
    """A Butterworth filter has 1/sqrt(2) at its cutoff; run forwards and backwards, 1/2."""
    path = filtered_positions(make_trial(make_problem(dt=0.005), wave(0.005, 6.0, 5.0)))
    assert path is not None
    assert np.ptp(path[150:-150, 0]) / 2.0 == pytest.approx(0.5, abs=0.01)


def test_resampling_gives_100_hz_whatever_the_step() -> None:
    for dt, rows in ((0.05, 101), (0.01, 501), (0.002, 2501), (0.03, 101)):
        path = filtered_positions(make_trial(make_problem(dt=dt), np.zeros((rows, 2))))
        assert path is not None
        assert len(path) == round((rows - 1) * dt * 100) + 1


@pytest.mark.parametrize(("rows", "applies"), [(11, True), (10, False)])
def test_nan_under_one_second(rows: int, applies: bool) -> None:
    q = np.linspace(0.0, 1.0, rows)[:, None] * [1.0, 0.0]
    trial = make_trial(make_problem(dt=0.1), q)
    assert math.isfinite(jerk_rms(trial)) is applies
    assert (filtered_speed(trial) is not None) is applies


def test_curvature_of_a_straight_path_is_zero_and_standing_still_has_none() -> None:
    along = np.linspace(0.0, 1.0, 50)[:, None] * [0.6, 0.8]
    assert curvature_max(make_trial(make_problem(), along)) == pytest.approx(0.0, abs=1e-9)
    assert math.isnan(curvature_max(make_trial(make_problem(), np.tile([0.1, 0.2], (50, 1)))))


def test_curvature_leaves_out_slow_rows() -> None:
    """A corner taken at a hundredth of the peak speed does not count."""
    steps = np.concatenate([np.full(20, 0.1), np.full(4, 0.001)])
    leg = np.concatenate([[0.0], np.cumsum(steps)])
    out = np.column_stack([leg, np.zeros_like(leg)])
    back = out[-1] + np.column_stack([np.zeros_like(leg), leg[-1] - leg[::-1]])
    trial = make_trial(make_problem(), np.vstack([out, back[1:]]))
    assert curvature_max(trial) == pytest.approx(0.0, abs=1e-9)
