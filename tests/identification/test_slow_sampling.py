"""Logs whose sampling shows too little: motion that is folded, sensors that are apart, reversals close together."""

from dataclasses import replace

import numpy as np

from benchmarks.promise.faults import damaged
from benchmarks.promise.machines import Case, draw_case, draw_machine, draw_noise, with_noise
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
    assert found.status != "ok"
    assert "ddq1 has 86 % of its power above 0.7 of half the sampling frequency" in found.message


def shifted(x: np.ndarray, samples: int) -> np.ndarray:
    return x[np.clip(np.arange(x.size) - samples, 0, x.size - 1)]


def two_masses(number: int, measured: tuple[str, ...]) -> Case:
    rng = np.random.default_rng([12, number])
    case = draw_machine("direct_2m1s", measured, rng)
    return replace(
        case, signals={n: with_noise(x, draw_noise(case, n, rng), rng) for n, x in case.signals.items()}
    )


def message_of(case: Case, **changed: np.ndarray) -> str:
    return identified(case.changed("", **changed)).message


def test_faults_of_single_sensors_are_named() -> None:
    """An accelerometer in g, or late beside a scale that repeats it; a scale that is late against all others."""
    case = two_masses(1, ("q2", "ddq1"))
    assert "ddq1" not in message_of(case)
    assert "ddq1 would have to be" in message_of(case, ddq1=case.signals["ddq1"] / 9.80665)
    assert message_of(case, q2=shifted(case.signals["q2"], 7)).startswith("q2 acts as if")
    case = two_masses(2, ("q2", "ddq2"))
    assert "the reading of other sensors" not in message_of(case)
    late = shifted(case.signals["ddq2"], 40)
    assert "ddq2 is 8 ms later than the reading of other sensors" in message_of(case, ddq2=late)
    early = shifted(case.signals["ddq2"], -1)
    assert "ddq2 is 0.2 ms earlier than the reading of other sensors" in message_of(case, ddq2=early)


def test_a_log_with_few_rows_at_its_first_cutoff_is_estimated_at_the_one_of_the_smallest_deviations() -> None:
    case = folded(25)  # a mass on a multisine at 62.5 Hz: 56 rows at the first cutoff that leaves enough
    found = identified(case)
    assert sum(found.fit.rows) > 150
    for (name, true), deviation in zip(case.truth.items(), found.physical_deviations, strict=True):
        assert abs(found.physical_parameters[name] - true) < 3 * deviation < 0.1 * true


def test_a_first_cutoff_far_below_the_mode_is_left_where_it_makes_a_mass_negative() -> None:
    """Moves beside a multisine: 34 Hz where the mode is at 101 Hz, Ms = -40 times the true one."""
    rng = np.random.default_rng([411702, 3])
    case = draw_machine("direct_2m1s", ("q2",), rng)
    noise = {name: draw_noise(case, name, rng) for name in case.signals}
    case = replace(case, signals={name: with_noise(x, noise[name], rng) for name, x in case.signals.items()})
    found = identified(case)
    assert found.status == "ok"
    assert abs(found.physical_parameters["Ms"] / case.truth["Ms"] - 1) < 0.03


def test_a_slow_sensor_is_named_where_it_leaves_no_rows() -> None:
    t = np.arange(8000) / 1000
    q, v, a = np.sin(3 * t), 3 * np.cos(3 * t), -9 * np.sin(3 * t)
    held = np.repeat(q[::8], 8)  # between two updates its velocity is 0: each row seems to rest
    force = 5 * a + 9 * v + 2 * np.sign(v) + 0.1 * np.random.default_rng(1).standard_normal(t.size)
    found = identify("rigid_1m", Log.from_arrays({"q": held, "F": force}, sampling_period=1e-3))
    assert found.status != "ok"
    assert "q changes every 8 samples only: it is updated more rarely than it is recorded" in found.message
