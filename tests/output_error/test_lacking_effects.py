"""Output error on machines with a small effect that the model lacks, which hardly colours innovations of one sample."""

from dataclasses import replace

import numpy as np

from symid import Axis, Weight, load_axis
from symid.arrays import FloatArray
from symid.axis import Law, OffsetForce, QuadraticDrag
from symid.identification import Preparation
from symid.output_error import OutputErrorIdentification, identify_output_error
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

VALUES = {"M": 100.0, "Fv": 80.0, "Fs": 40.0}
SLIDE = load_axis("rigid_1m")
(BODY,) = SLIDE.bodies


def identified(axis: Axis, law: Law, size: float) -> OutputErrorIdentification:
    """The axis from moves of a machine with one more law, under noise of the encoder."""
    machine = axis.with_signal("q", noise=2e-7).with_signal("F", noise=2.0).with_effect(law)
    values = VALUES | dict.fromkeys(set(machine.physical_parameters) - set(VALUES), size)
    moves = trapezoids([0.2], [0.1, 0.2, 0.5], acceleration=4.0, jerk=100.0, dwell=0.1, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(SLIDE, VALUES), "q", bandwidth_hz=10.0)
    log = simulate(machine, values, moves, loop, start="equilibrium").log
    return identify_output_error(axis, ("q",), log, preparation=Preparation(held=True))


def deviations_off(found: OutputErrorIdentification) -> FloatArray:
    errors = [found.physical_parameters[name] - value for name, value in VALUES.items()]
    return np.abs(errors) / found.physical_deviations


def test_deviations_cover_a_constant_force_that_a_weight_imitates() -> None:
    found = identified(SLIDE.with_effect(Weight(BODY)), OffsetForce(BODY, "F0"), 5.0)
    assert found.status == "ok", found.message
    assert np.all(deviations_off(found) < 3)
    assert np.any(deviations_off(replace(found, lacking=0.0)) > 6)


def test_a_fit_that_least_squares_refuse_is_refused_beside_white_innovations() -> None:
    found = identified(SLIDE, QuadraticDrag(BODY, "c"), 120.0)
    assert found.status == "poor_fit"
    assert found.fit is not None
    assert found.fit.inflation < 1.5
