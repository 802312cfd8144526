"""A delay and a lag of the drive, told apart although noise of the position hides the forces at high frequencies."""

import numpy as np
import pytest

from benchmarks.diagnosis.drawn_machines import RATES, drawn_machine, drawn_run, simulated
from symid import ActuatorDelay, ActuatorLag
from symid.axis import DriveImperfection
from symid.diagnosis import diagnose
from symid.diagnosis.selection.late_forces import in_band_of_forces, other_predicts_better

LATE = 1.8e-3


@pytest.mark.parametrize(
    ("late", "name"), [(ActuatorLag(LATE), "actuator_lag"), (ActuatorDelay(LATE), "delay")]
)
def test_a_lag_of_a_ball_screw_is_no_delay(late: DriveImperfection, name: str) -> None:
    rng = np.random.default_rng(40011)
    machine, period = drawn_machine(rng), 1 / float(rng.choice(RATES))
    log, other = simulated(machine, [(late, {})], *drawn_run(machine, period, rng), 1)
    found = diagnose(machine.axis, log, validation=other, nominal=machine.values)
    (effect,) = found.effects
    assert effect.effect == name
    assert effect.probability > 0.5
    assert effect.parameters["T"].value == pytest.approx(LATE, rel=0.05)
    # A search from the other one goes on only where that predicts better in place of the one found.
    (step,) = (step for step in found.search if step.accepts)
    (other,) = step.other_timing()
    weighting = in_band_of_forces(step.before)
    assert other_predicts_better(step, [other], weighting)
    assert not other_predicts_better(other, [step], weighting)
