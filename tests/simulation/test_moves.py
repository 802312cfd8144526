"""Moves against closed forms of jerk-limited motion, and their limits."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st
from scipy.optimize import brentq

from symid.errors import SettingError
from symid.simulation import Limits, MoveProfile, move, trapezoids

T = 0.001


WIDE = Limits((-1e3, 1e3))


magnitude = st.floats(-3.0, 3.0).map(lambda exponent: 10.0**exponent)


def largest(values):
    return np.abs(values).max()


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
