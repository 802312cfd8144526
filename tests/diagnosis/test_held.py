"""A force that is held from sample to sample is told from values that take up its delay."""

import pytest

from symid import load_axis
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.start import fitted_axis
from symid.diagnosis.fitting.state import first_state
from symid.diagnosis.prediction.data import Recorded, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection.held import nominal_shows_hold
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

SCREW = load_axis("ballscrew_2m1s").with_signal("qm", noise=1e-7).with_signal("Fm", noise=1.0)
VALUES = {"Mm": 80.0, "Fvm": 80.0, "Fsm": 40.0, "Kt": 8e6, "Ft": 900.0, "Ml": 160.0, "Fvl": 100.0}


@pytest.mark.parametrize(
    ("held", "mass", "shown"), [(None, 80.0, True), (True, 80.0, False), (None, 92.0, False)]
)
def test_nominal_values_that_need_only_a_hold_show_it(held: bool | None, mass: float, shown: bool) -> None:
    reference = trapezoids(0.1, [0.2, 0.3], acceleration=4.0, jerk=100.0, dwell=0.1, sampling_period=1e-3)
    log = simulate(SCREW, VALUES, reference, tuned_cascade(plant_of(SCREW, VALUES), "qm"), seed=1).log
    data = data_of(SCREW, (joined([log]), None), Recorded({}, held))
    state, weighting = first_state(data.record, VALUES | {"Mm": mass})
    assert nominal_shows_hold(Fit(state, weighting), fitted_axis(state, weighting)) is shown
