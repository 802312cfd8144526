"""Chirps and multisines against closed forms, sympy's derivatives and discrete Fourier transforms."""

import math

import numpy as np
import pytest
import sympy

from symid.errors import SettingError
from symid.simulation import Limits, chirp, frequency_lines, multisine

T = 0.001


def largest(values):
    return np.abs(values).max()


def exact_chirp(f0, f1, seconds, amplitude, order, sweep, fade):
    """Position of a chirp in its fade-in, its middle and its fade-out, written down anew in sympy."""
    t = sympy.Symbol("t")
    frequency = f0 + (f1 - f0) * t / seconds if sweep == "linear" else f0 * (f1 / f0) ** (t / seconds)
    omega = 2 * sympy.pi * frequency
    phase = sympy.integrate(omega, (t, 0, t))

    def rise(s):
        return 35 * s**4 - 84 * s**5 + 70 * s**6 - 20 * s**7

    for window in (rise(t / fade), sympy.Integer(1), rise((seconds - t) / fade)):
        position = amplitude * window * omega**-order * sympy.sin(phase)
        yield [sympy.lambdify(t, sympy.diff(position, t, n)) for n in range(3)]


@pytest.mark.parametrize("sweep", ["linear", "logarithmic"])
@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("ends", [(1, 9), (7, 2)])
def test_derivatives_of_a_chirp_are_exact(sweep, order, ends):
    seconds, fade, amplitude = 4, 1, sympy.Rational(1, 50)
    quantity = ("position", "velocity", "acceleration")[order]
    given_values = (*ends, 4.0, 0.02)
    found = chirp(*given_values, sampling_period=T, quantity=quantity, sweep=sweep, fade=1.0)
    exact = exact_chirp(*map(sympy.Integer, ends), seconds, amplitude, order, sweep, fade)
    for functions, part in zip(exact, (slice(0, 1001), slice(1000, 3001), slice(3000, 4001)), strict=True):
        values = (found.position, found.velocity, found.acceleration)
        for function, value in zip(functions, values, strict=True):
            assert largest(value[part] - function(found.time[part])) < 1e-11 * largest(value)


@pytest.mark.parametrize("sweep", ["linear", "logarithmic"])
def test_frequency_of_a_chirp_runs_as_asked(sweep):
    found = chirp(2.0, 20.0, 10.0, 1.0, sampling_period=1e-4, sweep=sweep, fade=0.0)
    before = np.flatnonzero(np.diff(np.sign(found.position[1:])))[:, None] + [1, 2]
    t, x = found.time[before], found.position[before]
    crossing = t[:, 0] - x[:, 0] * (t[:, 1] - t[:, 0]) / (x[:, 1] - x[:, 0])  # where the phase is k pi
    if sweep == "linear":
        cycles = 2.0 * crossing + 0.9 * crossing**2
    else:
        cycles = 20.0 / math.log(10.0) * (10.0 ** (crossing / 10.0) - 1.0)
    assert largest(cycles - 0.5 * np.arange(1, crossing.size + 1)) < 1e-6
    assert crossing.size >= (219 if sweep == "linear" else 156)


def test_a_chirp_begins_and_ends_at_rest_about_its_centre():
    found = chirp(1.0, 30.0, 3.0, 0.01, sampling_period=T, centre=0.4, quantity="velocity")
    for values, rest in ((found.position, 0.4), (found.velocity, 0.0), (found.acceleration, 0.0)):
        assert values[[0, -1]].tolist() == [rest, rest]
    assert largest(found.velocity[300:-300]) == pytest.approx(0.01, rel=0.01)
    tone = chirp(5.0, 5.0, 2.0, 0.1, sampling_period=T, sweep="logarithmic")
    middle = slice(200, 1801)
    assert largest(tone.position[middle] - 0.1 * np.sin(10.0 * np.pi * tone.time[middle])) < 1e-14


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"f1": 500.0}, "below half the sampling frequency of 1000 Hz"),
        ({"f0": -1.0}, "frequencies from 0 Hz"),
        ({"f0": 0.0, "quantity": "velocity"}, "constant amplitude of velocity: give a positive frequency"),
        ({"f0": 0.0, "sweep": "logarithmic"}, "logarithmic"),
        ({"sweep": "cubic"}, "'cubic' is not known: choose linear or logarithmic"),
        ({"quantity": "jerk"}, "'jerk' is not known: choose position, velocity, acceleration"),
        ({"fade": 1.1}, "fades of 1.1 s do not fit twice into 2 s"),
        ({"amplitude": 0.0}, "amplitude of the chirp is 0"),
        ({"seconds": math.inf}, "chirp is inf s"),
        (
            {"limits": Limits((-0.05, 0.05))},
            r"by 0\.0\d+ and .*, by 0\.05: it spans 0\.2: shorten it to at most 0\.5",
        ),
        (
            {"limits": Limits((-1, 1), acceleration=10.0)},
            "acceleration reaches .* 10 m/s.2 or rad/s.2: multiply",
        ),
        ({"limits": Limits((0.0, 1.0))}, r"lower end of travel, 0 m or rad, by 0\.0\d+: shift it by 0\.0"),
    ],
)
def test_impossible_chirps_are_refused(values, message):
    usual = {"f0": 1.0, "f1": 10.0, "seconds": 2.0, "amplitude": 0.1, "sampling_period": T}
    with pytest.raises(SettingError, match=message):
        chirp(**(usual | values))


def test_the_advised_amplitude_is_possible():
    limits = Limits((-1.0, 1.0), speed=0.37, acceleration=11.0)
    with pytest.raises(SettingError) as refusal:
        chirp(1.0, 10.0, 2.0, 0.1, sampling_period=T, limits=limits)
    shares = [float(part.split(";")[0]) for part in str(refusal.value).split("at most ")[1:]]
    assert len(shares) == 2
    chirp(1.0, 10.0, 2.0, 0.1 * min(shares), sampling_period=T, limits=limits)
    with pytest.raises(SettingError):
        chirp(1.0, 10.0, 2.0, 0.1 * min(shares) * 1.002, sampling_period=T, limits=limits)


@pytest.mark.parametrize("quantity", ["position", "velocity", "acceleration"])
@pytest.mark.parametrize("rng", [None, np.random.default_rng(3)])
def test_a_multisine_has_only_the_lines_asked_for(quantity, rng):
    lines = np.array([0.5, 1.0, 2.5, 7.0, 40.0])
    amplitudes = np.array([1.0, 2.0, 0.5, 1.0, 0.25])
    found = multisine(
        lines, amplitudes, sampling_period=T, quantity=quantity, periods=3, rng=rng, centre=0.2, fade=1.0
    )
    first, stop = found.steady
    assert (found.period, stop - first, found.duration) == (2000, 6000, 8.0)
    order = ("position", "velocity", "acceleration").index(quantity)
    for n, values in enumerate((found.position - 0.2, found.velocity, found.acceleration)):
        spectrum = np.fft.rfft(values[first:stop]) * 2.0 / 6000
        expected = np.zeros(3001, dtype=complex)
        expected[np.rint(lines * 6).astype(int)] = (
            amplitudes * np.exp(1j * found.phases) * (2j * np.pi * lines) ** (n - order)
        )
        assert largest(spectrum - expected) < 1e-12 * largest(expected)


def test_a_multisine_fades_in_and_out_exactly():
    found = multisine([1.0, 3.0], [0.02, 0.01], sampling_period=T, quantity="position", fade=0.5)
    for values in (found.position, found.velocity, found.acceleration):
        assert values[[0, -1]].tolist() == [0.0, 0.0]
    # Integrals by Hermite's rule, exact to the fourth power of the sampling period.
    x, v, a = found.position, found.velocity, found.acceleration
    assert largest(np.diff(x) - T / 2 * (v[1:] + v[:-1]) + T**2 / 12 * np.diff(a)) < 1e-13
    moved = np.concatenate([[0.0], np.cumsum(T / 2 * (v[1:] + v[:-1]) - T**2 / 12 * np.diff(a))])
    assert largest(moved - x) < 1e-9 * largest(x)
    assert largest(np.cumsum(a) * T - v) < 1e-2 * largest(v)


def test_periods_hold_whole_cycles_and_whole_samples():
    assert multisine([0.3, 0.5], 1.0, sampling_period=0.01, fade=0.0).duration == pytest.approx(10.0 - 0.01)
    thirds = multisine(np.array([1.0, 4.0]) / 3.0, 1.0, sampling_period=1.0 / 8000.0, seconds=4.0)
    assert (thirds.period, thirds.steady) == (24000, (24000, 72000))
    odd = multisine([0.3], 1.0, sampling_period=1.0 / 8.0)  # 80 samples hold 3 cycles
    assert odd.period == 80
    loop = multisine([2.0, 5.0], 1.0, sampling_period=T, fade=0.0, periods=2)
    assert np.array_equal(loop.position[:1000], loop.position[1000:])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"frequencies": []}, "give at least one"),
        ({"frequencies": [0.0, 1.0]}, "positive frequencies"),
        ({"frequencies": [2.0, 1.0]}, "do not ascend"),
        ({"frequencies": [1.0, 500.0]}, "500 Hz is not below half the sampling frequency of 1000 Hz"),
        ({"frequencies": [math.pi * 1e-7, 1.0]}, "not a fraction"),
        ({"frequencies": [1.0, 1.0 + 1e-6], "sampling_period": 1e-4}, "first repeat together after 1e"),
        ({"amplitude": [1.0, 2.0, 3.0]}, r"shape \(3,\): give one number"),
        ({"amplitude": 0.0}, "not all 0"),
        ({"amplitude": [1.0, -1.0]}, "0 or more"),
        ({"periods": 0}, "0 periods make no multisine"),
        ({"periods": 10**6}, "at most 1e"),
        ({"quantity": "force"}, "'force' is not known"),
        ({"limits": Limits((-1.0, 1.0), speed=0.5)}, "speed reaches .* multiply the amplitude by at most 0"),
    ],
)
def test_impossible_multisines_are_refused(values, message):
    usual = {"frequencies": [1.0, 2.0], "amplitude": 1.0, "sampling_period": T}
    with pytest.raises(SettingError, match=message):
        multisine(**(usual | values))


def test_frequency_lines_include_the_highest():
    assert frequency_lines(0.1, 0.7, 0.1).size == 7
    with pytest.raises(SettingError, match="give the lowest first"):
        frequency_lines(2.0, 1.0, 0.1)
