"""Logs whose sampling shows too little: motion that is folded, sensors that are apart, reversals close together."""

import numpy as np

from benchmarks.promise.faults import damaged
from benchmarks.promise.machines import Case, draw_case, draw_machine
from symid import Log, identify, load_generated
from symid.identification import Identification


def identified(case: Case) -> Identification:
    log = Log.from_arrays(case.signals, sampling_period=1 / case.rate)
    return identify(load_generated(case.axis, case.measured), log)


def folded(number: int) -> Case:
    """A random log of which samples are left out without a filter."""
    rng = np.random.default_rng([112304, number, True])
    return damaged(draw_case(rng), rng, "folded")


def test_motion_that_is_folded_is_named() -> None:
    found = identified(folded(11))  # mode and motion reach half of 135 Hz
    assert found.status == "recording"
    assert "ddq1 has 86 % of its power above 0.7 of half the sampling frequency" in found.message


def test_sensors_that_repeat_each_other_at_different_times_are_named() -> None:
    case = draw_machine("direct_2m1s", ("q2", "ddq2"), np.random.default_rng(6))
    noise = {
        name: size * np.random.default_rng(k).standard_normal(case.signals[name].size)
        for k, (name, size) in enumerate((("q2", 1e-8), ("ddq2", 1e-3), ("Fm", 1e-1)))
    }
    case = case.changed("", **{name: case.signals[name] + x for name, x in noise.items()})
    assert "what other sensors say" not in identified(case).message
    found = identified(
        case.changed("late", q2=np.concatenate([case.signals["q2"][:1], case.signals["q2"][:-1]]))
    )
    assert found.status != "ok"
    assert f"ddq2 is {1e3 / case.rate:.3g} ms earlier than what other sensors say" in found.message


def test_a_log_with_few_rows_at_its_first_cutoff_is_estimated_at_the_one_of_the_smallest_deviations() -> None:
    case = folded(25)  # a mass on a multisine at 62.5 Hz: 56 rows at the first cutoff that leaves enough
    found = identified(case)
    assert sum(found.fit.rows) > 300
    for (name, true), deviation in zip(case.truth.items(), found.physical_deviations, strict=True):
        assert abs(found.physical_parameters[name] - true) < 3 * deviation < 0.1 * true
