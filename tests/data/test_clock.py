"""The sampling period and the faults of written times."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from symid.data.quality.clock import inspect_clock


def faults_of(time):
    return "; ".join(inspect_clock(np.asarray(time, dtype=float)).faults)


@given(
    frequency=st.sampled_from([50.0, 100.0, 240.0, 1000.0, 1500.0, 4000.0, 48_828.125]),
    n=st.integers(25, 3000),
    start=st.sampled_from([0.0, -3.0, 17.25, 86_400.0]),
)
@settings(max_examples=60)
def test_a_uniform_clock_is_found_exactly(frequency, n, start):
    clock = inspect_clock(start + np.arange(n) / frequency)
    assert clock.faults == clock.notes == ()
    assert clock.period == pytest.approx(1.0 / frequency, rel=1e-12)
    assert clock.start == start


@pytest.mark.parametrize("decimals", [3, 4, 6])
@pytest.mark.parametrize("period", [0.001, 0.002, 0.0025, 0.0013, 0.0047])
def test_rounding_of_the_written_times_is_no_jitter(period, decimals):
    clock = inspect_clock(np.round(period * np.arange(4000), decimals))
    assert clock.faults == clock.notes == ()
    assert clock.period == pytest.approx(period, rel=1e-5)


def test_times_stored_in_32_bits():
    clock = inspect_clock((0.001 * np.arange(60_000)).astype(np.float32).astype(float))
    assert clock.faults == clock.notes == ()
    assert clock.period == pytest.approx(0.001, rel=1e-9)


def test_times_since_1970():
    clock = inspect_clock(1.7e9 + 0.001 * np.arange(5000))
    assert clock.faults == clock.notes == ()
    assert clock.period == pytest.approx(0.001, rel=1e-9)


def test_too_coarse_times_are_not_called_repeated():
    text = faults_of(np.round(np.arange(1000) / 4000.0, 3))
    assert "written too coarsely" in text
    assert "take 0.00025 s from row to row" in text
    assert "repeated" not in text


@given(at=st.integers(1, 1998), missing=st.integers(1, 400), decimals=st.sampled_from([3, 9]))
@settings(max_examples=40)
def test_missing_samples_are_a_gap_after_the_last_good_time(at, missing, decimals):
    index = np.arange(2000) + missing * (np.arange(2000) > at)
    text = faults_of(np.round(0.002 * index, decimals))
    assert text.startswith(f"t has 1 gap, the first after t = {0.002 * at:.7g} s (row {at + 1})")
    assert "sampling period from" not in text


def test_all_faults_are_reported_at_once():
    time = 0.01 * np.arange(500)
    time[100] = time[99]
    time[300:] -= 0.5
    time[400:] += 1.0
    time[450] = np.nan
    text = faults_of(time)
    assert "1 repeated time, the first at t = 0.99 s (row 101)" in text
    assert "1 step backwards" in text
    assert "499 steps backwards" in faults_of(0.01 * np.arange(500)[::-1])
    assert "(row 301)" in text
    assert "1 value that are empty" not in text
    assert "empty or no possible time, the first in row 451" in text
    assert "gap" in text
    assert "\n" not in text


@pytest.mark.parametrize("second", [0.00101, 0.0011, 0.002, 0.0005, 0.01])
@pytest.mark.parametrize("at", [300, 1000, 1700])
def test_two_clocks_are_reported_with_time_and_both_periods(second, at):
    index = np.arange(2000)
    time = np.where(index < at, 0.001 * index, 0.001 * at + second * (index - at))
    text = faults_of(time)
    assert f"from 0.001 s to {second:g} s at t = {0.001 * at:.7g} s (row {at + 1})" in text
    assert "gap" not in text


def test_two_clocks_with_a_gap_in_the_second():
    time = np.concatenate([0.001 * np.arange(1000), 1.0 + 0.002 * np.arange(1000)])
    time[1500:] += 0.1
    text = faults_of(time)
    assert "from 0.001 s to 0.002 s" in text
    assert "1 gap, the first after t = 1.998 s" in text


def test_late_samples_of_a_real_loop_are_a_note():
    intervals = np.full(3000, 0.002)
    intervals[[500, 1200]] += 0.000_05
    clock = inspect_clock(np.concatenate([[0.0], np.cumsum(intervals)]))
    assert clock.faults == ()
    assert len(clock.notes) == 1
    assert "treated as uniform" in clock.notes[0]
    assert clock.period == pytest.approx(0.002, rel=1e-4)


def test_strong_jitter_is_a_fault():
    rng = np.random.default_rng(5)
    text = faults_of(0.002 * (np.arange(3000) + 0.05 * rng.standard_normal(3000)))
    assert "jitters by" in text
    assert "resample" in text
    assert "sampling period from" not in text


def test_weak_jitter_is_accepted():
    rng = np.random.default_rng(6)
    clock = inspect_clock(0.002 * (np.arange(3000) + 0.004 * rng.standard_normal(3000)))
    assert clock.faults == ()
    assert clock.period == pytest.approx(0.002, rel=1e-6)


@pytest.mark.parametrize("n", [0, 1, 3, 24])
def test_few_samples(n):
    assert faults_of(np.arange(n)) == f"has only {n} sample{'s' * (n != 1)}: at least 25 are required"


@pytest.mark.parametrize("time", [np.zeros(100), -np.arange(100.0), np.full(100, np.nan)])
def test_times_that_do_not_advance(time):
    clock = inspect_clock(time)
    assert clock.faults
    assert np.isnan(clock.period)
