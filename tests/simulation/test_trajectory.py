"""Trajectories: steps, references of logs, joints between trajectories, limits."""

import math
import pickle

import numpy as np
import pytest

from symid.data import Log
from symid.errors import LogError, SettingError
from symid.simulation import Extremes, Limits, Trajectory, chirp, from_log, multisine, steps
from symid.simulation.trajectories.multisine import Multisine

T = 0.001


def largest(values):
    return np.abs(values).max()


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
    assert first.then(second).position.tolist() == [0.0] * 5 + [0.2] * 10 + [0.0] * 6
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
        running.then(steps([running.position[-1]], 0.1, sampling_period=T))
    assert running.then(running).n_samples == 2001


def test_a_trajectory_is_a_record_that_cannot_change():
    found = multisine([1.0, 2.0], 0.1, sampling_period=T)
    copy = pickle.loads(pickle.dumps(found))
    assert isinstance(copy, Multisine)
    for one in (found, copy):
        for values in (one.time, one.position, one.velocity, one.acceleration, one.frequencies, one.phases):
            assert not values.flags.writeable
    assert np.array_equal(copy.position, found.position)
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
