"""The record of a run: read-only, picklable, cut into windows."""

import copy
import pickle

import numpy as np
import pytest

from symid.data import Log
from symid.errors import LogError


def small_log():
    return Log.from_arrays(
        {"q": np.arange(6.0), "F": np.arange(6.0) ** 2}, sampling_period=0.5, start=2.0, source="bench"
    )


def test_arrays_are_read_only_and_independent_of_the_caller():
    mine = np.arange(4.0)
    log = Log.from_arrays({"q": mine}, sampling_period=0.1)
    mine[0] = 7.0
    assert log["q"][0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        log["q"][0] = 1.0
    with pytest.raises(TypeError):
        log.signals["F"] = mine
    with pytest.raises(AttributeError):
        log.start = 1.0


def test_time_and_frequency():
    log = small_log()
    assert log.n_samples == 6
    assert log.sampling_frequency == 2.0
    assert log.time.tolist() == [2.0, 2.5, 3.0, 3.5, 4.0, 4.5]


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda log: pickle.loads(pickle.dumps(log))])
def test_survives_pickling_and_stays_read_only(again):
    log = small_log()
    other = again(log)
    assert other.source == "bench"
    assert (other.start, other.sampling_period, other.notes) == (2.0, 0.5, ())
    assert list(other.signals) == ["q", "F"]
    assert np.array_equal(other["F"], log["F"])
    assert not other["F"].flags.writeable


def test_window_shares_memory_and_knows_its_time():
    log = small_log()
    part = log.window(2, 5)
    assert part.time.tolist() == log.time[2:5].tolist()
    assert np.shares_memory(part["q"], log["q"])
    assert part.window(1, 2)["q"].tolist() == [3.0]


@pytest.mark.parametrize("bounds", [(-1, 3), (3, 3), (4, 2), (0, 7)])
def test_a_window_outside_the_log_is_refused(bounds):
    with pytest.raises(LogError, match=r"not part of the log.*<= 6"):
        small_log().window(*bounds)


def test_a_missing_signal_names_those_there_are():
    with pytest.raises(LogError, match="bench: there is no signal 'qm': the log has q, F"):
        small_log()["qm"]


@pytest.mark.parametrize(
    ("signals", "period", "statement"),
    [
        ({}, 0.1, "no signals"),
        ({"q": [1.0, 2.0], "F": [1.0]}, 0.1, r"differ in length \(q 2, F 1\)"),
        ({"q": [[1.0, 2.0]]}, 0.1, r"shape \(1, 2\)"),
        ({"q": []}, 0.1, "vector of samples"),
        (
            {"q": [1.0, float("nan"), float("inf")]},
            0.1,
            "'q' has 2 values that are not finite, the first at index 1",
        ),
        ({"q": [1.0, -9.9e37]}, 0.1, "'q' is -9.9e\\+37 at index 1, which no machine reaches"),
        ({"q": ["a", "b"]}, 0.1, "does not hold numbers"),
        ({"q": [1j, 2.0]}, 0.1, "complex"),
        ({"q": [1.0, 2.0]}, 0.0, "sampling period 0 s"),
        ({"q": [1.0, 2.0]}, float("nan"), "sampling period nan s"),
    ],
)
def test_unusable_arrays_are_refused(signals, period, statement):
    with pytest.raises(LogError, match=statement):
        Log.from_arrays(signals, sampling_period=period)
