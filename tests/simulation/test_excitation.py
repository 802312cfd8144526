"""Trajectories against closed forms, exact integration, sympy's derivatives and discrete Fourier transforms."""

import math
import pickle

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import brentq

from symid.data import Log
from symid.errors import LogError, SettingError
from symid.simulation import (
    Extremes,
    Limits,
    MoveProfile,
    Multisine,
    Trajectory,
    chirp,
    frequency_lines,
    from_log,
    move,
    multisine,
    steps,
    trapezoids,
)

T = 0.001
WIDE = Limits((-1e3, 1e3))
magnitude = st.floats(-3.0, 3.0).map(lambda exponent: 10.0**exponent)


def largest(values):
    return np.abs(values).max()


# --- moves ---------------------------------------------------------------------------------------------


def duration_at(peak, distance, acceleration, jerk):
    """Time of a move that cruises at `peak`, by the textbook, and negative cruise where it is too fast."""
    ramp = (
        peak / acceleration + acceleration / jerk
        if peak >= acceleration**2 / jerk
        else 2.0 * math.sqrt(peak / jerk)
    )
    return 2.0 * ramp + (distance / peak - ramp), distance / peak - ramp


def fastest_duration(distance, speed, acceleration, jerk):
    """Time of the fastest move by root finding on its peak speed, with no case distinction but one."""

    def cruise(exponent):
        return (
            duration_at(math.exp(exponent), distance, acceleration, jerk)[1] * math.exp(exponent) / distance
        )

    if cruise(math.log(speed)) >= 0.0:
        return duration_at(speed, distance, acceleration, jerk)[0]
    peak = math.exp(brentq(cruise, math.log(speed) - 100.0, math.log(speed), xtol=1e-15, rtol=1e-15))
    return duration_at(peak, distance, acceleration, jerk)[0]


@given(distance=magnitude, speed=magnitude, acceleration=magnitude, jerk=magnitude)
def test_a_move_is_the_fastest_within_its_limits(distance, speed, acceleration, jerk):
    profile = MoveProfile.fastest(distance, speed, acceleration, jerk)
    assert profile.duration == pytest.approx(fastest_duration(distance, speed, acceleration, jerk), rel=1e-9)
    assert profile.speed <= speed * (1 + 1e-12)
    assert profile.acceleration <= acceleration * (1 + 1e-12)
    assert profile.jerk == pytest.approx(jerk, rel=1e-9)
    assert min(profile.jerk_time, profile.acceleration_time, profile.cruise_time) >= 0.0


@given(
    distance=magnitude, speed=magnitude, acceleration=magnitude, jerk=magnitude, count=st.integers(50, 400)
)
def test_position_and_velocity_are_exact_integrals_of_constant_jerk(
    distance, speed, acceleration, jerk, count
):
    profile = MoveProfile.fastest(distance, speed, acceleration, jerk)
    h = profile.duration / count
    x, v, a = profile.at(np.linspace(0.0, profile.duration, count + 1))
    # Between two samples of one segment these rules are exact; each of the six switching times spoils one interval.
    by_speed = np.diff(x) - 0.5 * h * (v[:-1] + v[1:]) + h**2 / 12.0 * np.diff(a)
    by_drive = np.diff(v) - 0.5 * h * (a[:-1] + a[1:])
    assert np.count_nonzero(np.abs(by_speed) > 1e-12 * distance) <= 7
    assert np.count_nonzero(np.abs(by_drive) > 1e-12 * profile.speed) <= 7
    assert largest(by_speed) <= 2 * profile.jerk * h**3
    assert largest(by_drive) <= 2 * profile.jerk * h**2
    assert largest(np.diff(a)) <= profile.jerk * h * (1 + 1e-9) + 1e-12 * profile.acceleration


@given(distance=magnitude, speed=magnitude, acceleration=magnitude, jerk=magnitude, dwell=st.floats(0.0, 0.1))
def test_sampled_moves_keep_their_limits_and_arrive_exactly(distance, speed, acceleration, jerk, dwell):
    duration = MoveProfile.fastest(distance, speed, acceleration, jerk).duration
    period = duration / 97.3
    assume(dwell / period < 1e5)
    there_and_back = trapezoids(
        distance, speed, acceleration=acceleration, jerk=jerk, dwell=dwell, sampling_period=period
    )
    assert there_and_back.position.min() == 0.0
    assert there_and_back.position.max() == distance
    assert largest(there_and_back.velocity) <= speed * (1 + 1e-12)
    assert largest(there_and_back.acceleration) <= acceleration * (1 + 1e-12)
    assert there_and_back.extremes.jerk <= jerk * (1 + 1e-9)
    ends = (there_and_back.position[-1], there_and_back.velocity[-1], there_and_back.acceleration[-1])
    assert ends == (0.0, 0.0, 0.0)
    half = there_and_back.n_samples // 2
    assert np.array_equal(there_and_back.velocity[:half], -there_and_back.velocity[half:-1])


@pytest.mark.parametrize(
    ("distance", "reached", "times"),
    [
        (3.0, (1.0, 2.0), (0.5, 0.0, 2.0)),  # speed, and acceleration for an instant
        (1.0, (1.0, 2.0), (0.5, 0.0, 0.0)),  # both for an instant
        (0.008, (0.04, 0.4), (0.1, 0.0, 0.0)),  # neither
    ],
)
def test_moves_that_reach_their_limits_or_not(distance, reached, times):
    profile = MoveProfile.fastest(distance, 1.0, 2.0, 4.0)
    assert (profile.speed, profile.acceleration) == pytest.approx(reached, rel=1e-12)
    found = (profile.jerk_time, profile.acceleration_time, profile.cruise_time)
    assert found == pytest.approx(times, abs=1e-12)


def test_acceleration_reached_but_not_the_speed():
    profile = MoveProfile.fastest(1.5, 10.0, 1.0, 2.0)  # v (v + 1/2) = 3/2 has the root v = 1
    assert (profile.speed, profile.acceleration, profile.acceleration_time) == (1.0, 1.0, 0.5)
    assert profile.duration == 3.0


def test_speed_reached_but_not_the_acceleration():
    profile = MoveProfile.fastest(4.0, 1.0, 100.0, 4.0)
    assert (profile.speed, profile.acceleration, profile.jerk_time) == (1.0, 2.0, 0.5)
    assert profile.duration == 5.0


def test_without_limit_of_jerk_the_velocity_is_a_trapezoid():
    profile = MoveProfile.fastest(2.0, 1.0, 2.0)
    assert (profile.duration, profile.jerk_time, profile.jerk) == (2.5, 0.0, math.inf)
    x, v, a = profile.at([0.0, 0.25, 0.5, 1.25, 2.0, 2.25, 2.5])
    assert x.tolist() == [0.0, 0.0625, 0.25, 1.0, 1.75, 1.9375, 2.0]
    assert v.tolist() == [0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0]
    assert a[[0, 1, 3, 5, 6]].tolist() == [2.0, 2.0, 0.0, -2.0, 0.0]
    triangle = MoveProfile.fastest(0.5, 10.0, 2.0)
    assert (triangle.duration, triangle.speed) == (1.0, 1.0)
    sampled = trapezoids(-0.5, 10.0, acceleration=2.0, sampling_period=0.25, dwell=0.5)
    assert sampled.acceleration.tolist() == [-2, -2, 2, 2, 0, 0, 2, 2, -2, -2, 0, 0, 0]
    assert sampled.position.min() == -0.5


def test_moves_at_several_speeds_over_several_distances():
    run = trapezoids(
        [0.2, -0.1],
        [0.1, 0.2],
        acceleration=1.0,
        jerk=20.0,
        dwell=0.25,
        sampling_period=T,
        start=0.3,
        limits=Limits((0.2, 0.5), speed=0.2, acceleration=1.0, jerk=20.0),
    )
    assert (run.position.min(), run.position.max()) == (0.3 - 0.1, 0.5)
    assert (run.position[0], run.position[-1]) == (0.3, 0.3)
    cruising = [np.count_nonzero(np.isclose(np.abs(run.velocity), speed, rtol=1e-12)) for speed in (0.1, 0.2)]
    assert min(cruising) > 500
    still = run.velocity == 0.0
    assert np.count_nonzero(still) * T >= 8 * 0.25
    assert largest(run.position[0] + np.cumsum(run.velocity) * T - run.position) < 1e-3


def test_a_single_move_joins_others():
    up = move(0.1, 0.7, speed=0.5, acceleration=1.0, jerk=10.0, sampling_period=T, dwell=0.1)
    down = move(0.7, -0.2, speed=0.5, acceleration=1.0, jerk=10.0, sampling_period=T, limits=WIDE)
    both = up.then(down)
    assert (both.position[0], both.position.max(), both.position[-1]) == (0.1, 0.7, -0.2)
    assert both.duration == pytest.approx(up.duration + down.duration, rel=1e-12)
    assert both.n_samples == up.n_samples + down.n_samples - 1


def test_moves_beyond_the_limits_are_refused():
    limits = Limits((0.0, 1.0), speed=0.5, acceleration=1.0, jerk=10.0)
    with pytest.raises(SettingError, match=r"upper end of travel, 1 m or rad, by 0\.2: shift it by -0\.2"):
        trapezoids(0.9, 0.1, acceleration=1.0, jerk=10.0, sampling_period=T, start=0.3, limits=limits)
    with pytest.raises(SettingError, match=r"spans 1\.5: shorten it to at most 0\.6666"):
        trapezoids(1.5, 0.1, acceleration=1.0, jerk=10.0, sampling_period=T, limits=limits)
    with pytest.raises(
        SettingError, match=r"speed reaches 0\.6, 0\.1 more .* at most 0\.5.*jerk reaches inf"
    ):
        trapezoids(0.9, 0.6, acceleration=1.0, sampling_period=T, limits=limits)
    short = trapezoids(0.001, 5.0, acceleration=1.0, jerk=10.0, sampling_period=T, limits=limits)
    assert largest(short.velocity) < 0.5  # it never reaches the speed that the limits forbid


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"distances": 0.0}, "distance of a move is 0"),
        ({"distances": []}, "make no moves: give a number or a list"),
        ({"speeds": [[0.1]]}, r"shape \(1, 1\) make no moves"),
        ({"speeds": [0.1, -1.0]}, "speed of a move is -1"),
        ({"acceleration": math.nan}, "acceleration of a move is nan"),
        ({"jerk": 0.0}, "jerk of a move is 0"),
        ({"dwell": -1.0}, "dwell is -1 s"),
        ({"sampling_period": 0.0}, "sampling period is 0 s"),
        ({"speeds": 1e-12}, "at most 1e"),
    ],
)
def test_impossible_moves_are_refused(values, message):
    usual = {"distances": 1.0, "speeds": 0.5, "acceleration": 1.0, "jerk": 10.0, "sampling_period": T}
    with pytest.raises(SettingError, match=message):
        trapezoids(**(usual | values))


# --- chirps --------------------------------------------------------------------------------------------


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


# --- multisines ----------------------------------------------------------------------------------------


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


def test_crest_factors():
    tone = multisine([1.0], 0.3, sampling_period=T, centre=5.0, quantity="position")
    assert tone.crest_factor == pytest.approx(math.sqrt(2.0), rel=1e-12)
    lines = frequency_lines(1.0, 64.0, 1.0)
    low = multisine(lines, 1.0, sampling_period=T)
    drawn = [multisine(lines, 1.0, sampling_period=T, rng=np.random.default_rng(k)) for k in range(5)]
    assert low.crest_factor < 1.75 < min(each.crest_factor for each in drawn)
    again = multisine(lines, 1.0, sampling_period=T, rng=np.random.default_rng(0))
    assert np.array_equal(again.position, drawn[0].position)


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


# --- steps, logs, limits and joints ------------------------------------------------------------------


def test_steps_hold_their_levels():
    found = steps([0.0, 0.2, -0.1], 0.5, sampling_period=0.1)
    assert found.position.tolist() == [0.0] * 5 + [0.2] * 5 + [-0.1] * 6
    assert largest(found.velocity) == largest(found.acceleration) == 0.0
    with pytest.raises(SettingError, match=r"lower end of travel, 0 m or rad, by 0\.1: shift it by 0\.1"):
        steps([0.0, 0.2, -0.1], 0.5, sampling_period=0.1, limits=Limits((0.0, 1.0), speed=0.01))
    with pytest.raises(SettingError, match="at least one position"):
        steps([], 0.5, sampling_period=0.1)


def test_a_reference_survives_its_log():
    sent = chirp(1.0, 3.0, 4.0, 0.1, sampling_period=T)
    log = sent.as_log()
    assert (log.source, list(log.signals)) == ("chirp from 1 to 3 Hz", ["reference"])
    read = from_log(log)
    assert np.array_equal(read.position, sent.position)
    assert largest(read.velocity - sent.velocity) < 1e-4 * largest(sent.velocity)
    assert largest(read.acceleration - sent.acceleration) < 1e-3 * largest(sent.acceleration)
    other = Log.from_arrays({"r": [0.0, 1.0]}, sampling_period=0.5, start=3.0, source="bench")
    assert from_log(other, "r").time.tolist() == [3.0, 3.5]
    with pytest.raises(LogError, match="no signal 'reference'"):
        from_log(other)
    with pytest.raises(SettingError, match=r"r of bench: speed reaches 2, 1 more"):
        from_log(other, "r", limits=Limits((0.0, 1.0), speed=1.0))


def test_trajectories_join_only_where_they_fit():
    first = steps([0.0, 0.2], 0.5, sampling_period=0.1)
    second = steps([0.2, 0.0], 0.5, sampling_period=0.1)
    assert first.then(second).dwell(0.25).position.tolist() == [0.0] * 5 + [0.2] * 10 + [0.0] * 9
    with pytest.raises(
        SettingError,
        match=r"begins at 0 m or rad, where steps through 2 levels ends at 0\.2: shift it by 0\.2",
    ):
        first.then(first)
    assert first.then(first.shifted(0.2)).position.max() == 0.4
    with pytest.raises(SettingError, match="give both the same sampling period"):
        first.then(steps([0.2], 0.5, sampling_period=0.2))
    running = chirp(1.0, 1.0, 1.0, 0.1, sampling_period=T, fade=0.0)
    with pytest.raises(SettingError, match="join trajectories at rest"):
        running.dwell(1.0)
    assert running.then(running).n_samples == 2001


def test_a_trajectory_is_a_record_that_cannot_change():
    found = multisine([1.0, 2.0], 0.1, sampling_period=T)
    copy = pickle.loads(pickle.dumps(found))
    assert isinstance(copy, Multisine)
    for one in (found, copy):
        for values in (one.time, one.position, one.velocity, one.acceleration, one.frequencies, one.phases):
            assert not values.flags.writeable
    assert np.array_equal(copy.position, found.position)
    assert copy.crest_factor == found.crest_factor
    assert found.time.size == found.n_samples == found.position.size
    with pytest.raises(SettingError, match="velocity has shape"):
        Trajectory([0.0, 1.0], [0.0], [0.0, 0.0], T, "odd")
    with pytest.raises(SettingError, match="position has values that are not finite"):
        Trajectory([math.nan], [0.0], [0.0], T, "odd")


def test_limits_name_everything_that_is_exceeded():
    limits = Limits((0.0, 1.0), speed=1.0, acceleration=2.0, jerk=3.0)
    limits.check("good", Extremes(0.0, 1.0, 1.0, 2.0, 3.0))
    with pytest.raises(SettingError) as refusal:
        limits.check("bad", Extremes(-0.5, 2.0, 1.5, 3.0, 4.0))
    message = str(refusal.value)
    words = ("bad: ", "lower end", "by 0.5", "upper end", "by 1:", "speed", "acceleration", "jerk reaches 4")
    assert all(word in message for word in words)
    with pytest.raises(SettingError, match="travel from 1 to 0 is empty"):
        Limits((1.0, 0.0))
    with pytest.raises(SettingError, match="limit of speed is 0"):
        Limits((0.0, 1.0), speed=0.0)
