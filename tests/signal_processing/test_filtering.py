"""Filters against exact frequency responses, hand-made index lists and the published EMPS results."""

import os
from pathlib import Path

import numpy as np
import pytest
import scipy.signal
from hypothesis import given, settings, strategies as st

from symid.data import read_log
from symid.errors import SettingError
from symid.signal_processing import (
    LowPass,
    central_difference,
    central_difference_gain,
    decimation_filter,
    derivatives,
    kept_indices,
)
from symid.units import Unit

DATA = Path(__file__).parents[2] / "data"
GTAU = 35.15065188248547


def decimate(x, factor, workers=1):
    kept = kept_indices(x.shape[-1], factor)
    thinned = np.empty((*x.shape[:-1], -(-x.shape[-1] // factor)))
    decimation_filter(factor).apply_rows(x, thinned, kept, workers)
    return thinned


def emps_observation(name):
    """Rows of M, Fv, Fc, OF and of the force, made as the authors of the benchmark say."""
    log = read_log(
        DATA / "emps" / name,
        expected={"q": Unit.of("m"), "F": Unit.of("N")},
        alternatives={"F": ("vir", GTAU)},
        columns={"q": "qm"},
    )
    position = LowPass(100.0).apply(log["q"], log.sampling_frequency)
    speed, acceleration = derivatives(position, log.sampling_period, 2)
    rows = np.stack([acceleration, speed, np.sign(speed), np.ones_like(speed)])
    return decimate(rows[:, 49:], 10).T, decimate(log["F"][49:], 10)


def test_emps_matches_the_published_digits():
    W, y = emps_observation("DATA_EMPS.mat")
    assert W.shape == (2480, 4)
    found = np.linalg.lstsq(W, y, rcond=None)[0]
    error = np.linalg.norm(y - W @ found)
    assert [f"{value:.4f}" for value in found] == ["95.1089", "203.5034", "20.3935", "-3.1648"]
    assert f"{error:.4f}" == "108.7569"
    assert f"{100.0 * error / np.linalg.norm(y):.4f}" == "4.0834"
    assert f"{np.linalg.cond(W):.4f}" == "25.9883"

    W_pulses, y_pulses = emps_observation("DATA_EMPS_PULSES.mat")
    error = np.linalg.norm(y_pulses - W_pulses @ found)
    assert error == pytest.approx(169.4876, abs=2e-4)
    assert 100.0 * error / np.linalg.norm(y_pulses) == pytest.approx(5.9824, abs=1e-4)


def amplitude_and_phase(x, frequency, sampling_frequency):
    """Of the middle part of a long sine, by regression on sine and cosine."""
    part = slice(x.size // 4, 3 * x.size // 4)
    angle = 2.0 * np.pi * frequency * np.arange(x.size)[part] / sampling_frequency
    basis = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    sine, cosine = np.linalg.lstsq(basis, x[part], rcond=None)[0]
    return np.hypot(sine, cosine), np.arctan2(cosine, sine)


@pytest.mark.parametrize("order", [1, 4, 6])
@pytest.mark.parametrize("frequency", [10.0, 80.0, 100.0, 150.0])
def test_low_pass_has_the_squared_butterworth_response_and_no_phase(frequency, order):
    sampling_frequency = 1000.0
    x = np.sin(2.0 * np.pi * frequency * np.arange(8000) / sampling_frequency)
    low_pass = LowPass(100.0, order)
    amplitude, phase = amplitude_and_phase(
        low_pass.apply(x, sampling_frequency), frequency, sampling_frequency
    )
    b, a = scipy.signal.butter(order, 100.0, fs=sampling_frequency)
    _, response = scipy.signal.freqz(b, a, [frequency], fs=sampling_frequency)
    assert amplitude == pytest.approx(abs(response[0]) ** 2, abs=1e-9)
    assert low_pass.sampled_gain(frequency, sampling_frequency) == pytest.approx(amplitude, abs=1e-9)
    assert phase == pytest.approx(0.0, abs=1e-6)


def test_analogue_gain_is_the_limit_of_the_sampled_gain():
    low_pass = LowPass(50.0, 3)
    frequencies = np.array([0.0, 20.0, 50.0, 90.0])
    assert low_pass.gain(frequencies) == pytest.approx(low_pass.sampled_gain(frequencies, 1e6), rel=1e-6)
    assert low_pass.gain(50.0) == 0.5
    assert LowPass(1.0, 40).gain(1e9) == 0.0


@pytest.mark.parametrize("workers", [1, 2])
def test_pieces_give_what_scipy_gives_at_once(workers):
    x = np.random.default_rng(1).standard_normal(600_000).cumsum()
    sections = scipy.signal.butter(4, 30.0, fs=2000.0, output="sos")
    for samples in (600_000, 130_000):
        whole = scipy.signal.sosfiltfilt(sections, x[:samples], padtype="odd", padlen=12)
        filtered = LowPass(30.0).apply(x[:samples], 2000.0, workers=workers)
        assert np.max(np.abs(filtered - whole)) < 1e-13 * np.max(np.abs(x))


@pytest.mark.parametrize("workers", [1, 2])
def test_rows_are_filtered_one_by_one(workers):
    rows = np.random.default_rng(2).standard_normal((3, 400)).cumsum(axis=1)
    low_pass = LowPass(20.0)
    filtered = low_pass.apply(rows, 1000.0, workers=workers)
    thinned = decimate(rows, 5, workers=workers)
    for row, low, thin in zip(rows, filtered, thinned, strict=True):
        assert np.array_equal(low, low_pass.apply(row, 1000.0))
        assert np.array_equal(thin, decimate(row, 5))
    assert filtered.flags.c_contiguous


@given(level=st.floats(-1e3, 1e3), n=st.integers(13, 200))
@settings(max_examples=30)
def test_low_pass_leaves_a_constant(level, n):
    filtered = LowPass(100.0).apply(np.full(n, level), 1000.0)
    assert filtered == pytest.approx(np.full(n, level), abs=1e-9 * (1.0 + abs(level)))


@given(factor=st.floats(-50.0, 50.0), seed=st.integers(0, 99))
@settings(max_examples=30)
def test_low_pass_is_linear_and_the_same_backward(factor, seed):
    x, y = np.random.default_rng(seed).standard_normal((2, 300))
    low_pass = LowPass(100.0)
    both = low_pass.apply(x + factor * y, 1000.0)
    assert both == pytest.approx(low_pass.apply(x, 1000.0) + factor * low_pass.apply(y, 1000.0), abs=1e-9)
    # Which pass comes first matters only near the ends.
    backward = low_pass.apply(x[::-1], 1000.0)[::-1]
    assert backward[60:-60] == pytest.approx(low_pass.apply(x, 1000.0)[60:-60], abs=1e-5)


@pytest.mark.parametrize("cutoff", [0.0, -1.0, float("nan"), float("inf"), 500.0, 600.0])
def test_a_cutoff_outside_the_band_is_refused(cutoff):
    with pytest.raises(SettingError, match="cutoff"):
        LowPass(cutoff).apply(np.zeros(100), 1000.0)


def test_short_signals_are_refused_with_their_length():
    with pytest.raises(SettingError, match=r"12 samples are too few .* more than 12"):
        LowPass(10.0).apply(np.zeros(12), 1000.0)
    with pytest.raises(SettingError, match="2 samples"):
        central_difference([1.0], 0.1)
    with pytest.raises(SettingError, match="order 0"):
        LowPass(10.0, 0)
    assert LowPass(10.0).apply(np.zeros(13), 1000.0).size == 13


@given(
    coefficients=st.lists(st.floats(-10.0, 10.0), min_size=3, max_size=3),
    period=st.floats(1e-3, 10.0),
    n=st.integers(3, 60),
)
@settings(max_examples=50)
def test_central_difference_is_exact_on_parabolas(coefficients, period, n):
    c, b, a = coefficients
    t = period * np.arange(n)
    slope = central_difference(a * t**2 + b * t + c, period)
    scale = 1.0 + abs(a) * t[-1] + abs(b)
    assert slope[1:-1] == pytest.approx((2.0 * a * t + b)[1:-1], abs=1e-9 * scale + 1e-10 / period * scale)
    assert slope == pytest.approx(
        np.gradient(a * t**2 + b * t + c, period), abs=1e-9 * scale + 1e-10 / period
    )


@pytest.mark.parametrize("step", [1, 8])
def test_a_low_cutoff_loses_no_digits(step: int) -> None:
    x, low_pass = np.tile(np.sin(2 * np.pi * np.arange(2000) / 2000), 15), LowPass(2.0)
    error = low_pass.zero_phase(1000.0).apply_thinned(x[None], slice(0, None, step))[0]
    error -= low_pass.sampled_gain(0.5, 1000.0) * x[::step]
    inner = error[12_000 // step : 18_000 // step]
    assert np.abs(inner).max() < 1e-12
    assert np.abs(np.diff(inner, 2)).max() < 4e-15 * step


def test_difference_across_blocks():
    x = np.random.default_rng(3).standard_normal((2, 70_000))
    assert central_difference(x, 0.25) == pytest.approx(np.gradient(x, 0.25, axis=-1), rel=1e-12)


def test_third_derivative_of_a_cubic_inside():
    t = 0.5 * np.arange(12)
    first, second, third = derivatives(t**3, 0.5, 3)
    assert second[2:-2] == pytest.approx(6.0 * t[2:-2])
    assert third[3:-3] == pytest.approx(np.full(6, 6.0))
    assert first.size == second.size == third.size == 12
    assert derivatives(t, 0.5, 0) == []


@pytest.mark.parametrize("frequency", [1.0, 50.0, 200.0])
def test_gain_of_the_difference_is_that_of_a_sine(frequency):
    period = 0.001
    omega = 2.0 * np.pi * frequency
    t = period * np.arange(2000)
    slope = central_difference(np.sin(omega * t), period)
    measured = slope[1:-1] @ np.cos(omega * t[1:-1]) / (np.cos(omega * t[1:-1]) @ np.cos(omega * t[1:-1]))
    assert central_difference_gain(frequency, period) == pytest.approx(measured / omega, rel=1e-9)


@pytest.mark.parametrize(
    ("n", "factor", "kept"),
    [
        (10, 5, [4, 9]),  # n_beg = 5 - (5*2 - 10) = 5, counted from 1
        (11, 5, [0, 5, 10]),  # n_beg = 5 - (15 - 11) = 1
        (12, 5, [1, 6, 11]),  # n_beg = 5 - (15 - 12) = 2
        (24, 7, [2, 9, 16, 23]),  # n_beg = 7 - (28 - 24) = 3
        (4, 1, [0, 1, 2, 3]),
    ],
)
def test_kept_samples_are_those_of_matlab(n, factor, kept):
    assert list(range(n))[kept_indices(n, factor)] == kept


@given(n=st.integers(25, 400), factor=st.integers(2, 30))
@settings(max_examples=50)
def test_decimation_keeps_its_samples_of_the_filtered_signal(n, factor):
    x = np.sin(0.05 * np.arange(n)) + 0.01 * np.arange(n)
    sections = scipy.signal.cheby1(8, 0.05, 0.8 / factor, output="sos")
    whole = scipy.signal.sosfiltfilt(sections, x, padtype="odd", padlen=24)
    thinned = decimate(x, factor)
    assert thinned.size == -(-n // factor)
    assert thinned[-1] == pytest.approx(whole[-1])
    assert thinned == pytest.approx(whole[kept_indices(n, factor)])


def test_decimation_lowers_slow_signals_by_the_ripple_of_both_passes():
    assert decimate(np.full(500, 2.0), 10) == pytest.approx(
        np.full(50, 2.0 * 10.0 ** (-0.1 / 20.0)), rel=1e-6
    )


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_child_process_filters_with_threads_of_its_own() -> None:
    x = np.random.default_rng(0).standard_normal(400_000)
    expected = LowPass(30.0).apply(x, 1000.0, workers=2)
    child = os.fork()
    if not child:
        same = np.array_equal(LowPass(30.0).apply(x, 1000.0, workers=2), expected)
        os._exit(0 if same else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
