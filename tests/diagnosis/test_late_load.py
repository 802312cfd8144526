"""A load whose encoder is read late looks as if its drive had negative friction."""

from dataclasses import replace

import numpy as np
import pytest

from symid import Log, load_axis
from symid.diagnosis import Diagnosis, diagnose
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("ballscrew_2m1s").with_signal("qm", noise=1e-7).with_signal("Fm", noise=0.2)
VALUES = {"Mm": 40.0, "Fvm": 30.0, "Fsm": 20.0, "Kt": 4e5, "Ft": 100.0, "Ml": 60.0, "Fvl": 40.0}


@pytest.fixture(scope="module")
def log() -> Log:
    """The axis on moves of four speeds."""
    path = trapezoids([0.1, 0.02], [0.1, 0.2], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    axis = AXIS.with_signal("ql", noise=1e-6)
    return simulate(axis, VALUES, path, tuned_cascade(plant_of(AXIS, VALUES), "qm"), seed=1).log


def plainly(log: Log) -> Diagnosis:
    nominal = {name: 1.1 * value for name, value in VALUES.items()}
    return diagnose(load_axis("ballscrew_2m1s"), log, nominal=nominal, held=True, library=())


def test_a_load_that_is_read_late_is_named_and_accounted_for(log: Log) -> None:
    t = log.time
    late = replace(log, signals={**log.signals, "ql": np.interp(t - 1e-3, t, log["ql"])})
    found = plainly(late)
    assert found.faults[0].startswith("ql is read ")
    assert float(found.faults[0].split()[3]) == pytest.approx(1.0, rel=0.1)
    assert all(own.explained > 0 for own in found.parameters)


def test_a_load_that_is_read_in_time_is_not_said_to_be_late(log: Log) -> None:
    assert not any("late" in text for text in plainly(log).faults)
