"""A force that is held from sample to sample is told from values that take up its delay, and acts as its mean."""

import numpy as np
import pytest
from scipy.linalg import expm

from symid import ActuatorLag, Log, Preparation, diagnose, identify, load_axis
from symid.diagnosis import LIBRARY
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.start import fitted_axis
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection.held import nominal_shows_hold
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

SCREW = load_axis("ballscrew_2m1s").with_signal("qm", noise=1e-7).with_signal("Fm", noise=1.0)
VALUES = {"Mm": 80.0, "Fvm": 80.0, "Fsm": 40.0, "Kt": 8e6, "Ft": 900.0, "Ml": 160.0, "Fvl": 100.0}


@pytest.mark.parametrize(
    ("held", "lag", "wrong", "shown"),
    [
        (None, 0.0, {}, True),
        (True, 0.0, {}, False),
        (None, 0.0, {"Mm": 92.0}, False),
        (None, 1e-3, {"Kt": 7.6e6}, False),
    ],
)
def test_nominal_values_that_need_only_a_hold_show_it(
    held: bool | None, lag: float, wrong: dict[str, float], shown: bool
) -> None:
    reference = trapezoids(0.1, [0.2, 0.3], acceleration=4.0, jerk=100.0, dwell=0.1, sampling_period=1e-3)
    screw = SCREW.with_effect(ActuatorLag(lag)) if lag else SCREW
    log = simulate(screw, VALUES, reference, tuned_cascade(plant_of(SCREW, VALUES), "qm"), seed=1).log
    data = data_of(SCREW, (joined([log]), None), Recording({}, held))
    state, weighting = first_state(data.record, VALUES | wrong)
    assert nominal_shows_hold(Fit(state, weighting), fitted_axis(state, weighting)) is shown


def test_a_held_force_acts_as_its_mean_over_a_sample() -> None:
    """Motion under steps of force by hand; at 28 Hz and 200 Hz a hold takes 3 % off the force."""
    T, M, Fv = 5e-3, 100.0, 300.0
    t = T * np.arange(3000)
    F = sum(40 * np.sin(2 * np.pi * f * t + k) for k, f in enumerate(np.linspace(1.0, 28.0, 24)))
    step, x, read = expm(np.array([[0, 1, 0], [0, -Fv / M, 1 / M], [0, 0, 0]]) * T), np.zeros(2), []
    for force in F:
        read.append(x[0])
        x = (step @ [*x, force])[:2]
    rng = np.random.default_rng(1)
    noise = 1e-8 * rng.normal(size=t.size), 0.1 * rng.normal(size=t.size)
    log = Log("held", 0.0, T, {"q": np.array(read) + noise[0], "F": F + noise[1]})
    least_squares = identify("rigid_1m", log, preparation=Preparation(held=True), examine=False)
    assert least_squares.physical_parameters == pytest.approx(
        {"M": M, "Fv": Fv, "Fs": 0.0}, rel=5e-4, abs=0.01
    )
    found = diagnose("rigid_1m", log, held=True, nominal={"M": 110.0, "Fv": 280.0, "Fs": 1.0}, library=())
    assert found.verdict == "parameters"
    assert found.parameters[0].reidentified == pytest.approx(M, rel=2e-3)


def test_an_accelerometer_is_read_before_the_steps_of_a_held_force() -> None:
    """An axis that is simulated by symid has no gap: at 1 kHz its accelerometer was named as 0.49 ms late."""
    axis = load_axis("direct_2m1s")
    values = {"Ms": 3899.0, "Fvs": 3000.0, "Ks": 4e7, "Mm": 362.0, "Fvm": 500.0, "Fsm": 80.0}
    for name, noise in {"q2": 1e-7, "ddq1": 1e-3, "ddq2": 1e-3}.items():
        axis = axis.with_signal(name, noise=noise)
    moves = trapezoids(0.05, [0.5, 0.25], acceleration=5.0, jerk=500.0, dwell=0.1, sampling_period=1e-3)
    log = simulate(axis, values, moves, tuned_cascade(plant_of(axis, values), "q2"), seed=1).log
    timing = [
        one for one in LIBRARY if one.name in ("sensor_delay", "delay", "actuator_lag", "viscous_friction")
    ]
    found = diagnose(axis, log, library=timing)
    assert found.verdict == "no_gap"
    assert found.faults[0].startswith("ddq2 is read just before each step of the held force")
    assert found.faults[1].startswith("Fm is held")
    assert len(found.faults) == 2
    reading = [effect for effect in LIBRARY if effect.name == "sensor_delay"]
    late = diagnose(axis, log, late={"ddq2": 5e-4}, held=True, library=reading)
    assert (late.verdict, late.faults) == ("no_gap", ())
