"""Effects with values that no machine has: friction that pushes, a mode heavier than its body, a ripple of most of a
constant.
"""

import pytest
from hand_made import rigid_log

from symid import load_axis
from symid.diagnosis.effects import LIBRARY, FlexibleModeEffect, Placed
from symid.diagnosis.effects.friction_drift import FrictionDriftEffect
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.selection.credibility import _makes_impossible, friction_drives

BODY = load_axis("rigid_1m").bodies[0].name
RIPPLE = next(effect for effect in LIBRARY if effect.name == "force_constant_ripple")


def fit_with(*placed: Placed, mass: float = 6.0) -> Fit:
    data = data_of(load_axis("rigid_1m"), (joined([rigid_log()]), None), Recording({}, None))
    state, weighting = first_state(data.record, {"M": mass, "Fv": 8.0, "Fs": 0.1})
    return Fit(with_effects(state, weighting, placed), weighting)


@pytest.mark.parametrize(("change", "pushes"), [(-4.0, False), (-24.0, True), (24.0, False)])
def test_friction_that_changes_over_time_pushes_nowhere(change: float, pushes: bool) -> None:
    """As of a motor whose force had the wrong sign: -24 beside 0.7 at the beginning, with a probability of 0.98."""
    drift = FrictionDriftEffect(coulomb=False, viscous=True)
    seconds = fit_with().state.prediction.record.duration
    fit = fit_with(Placed(drift, BODY, (0.3 * seconds,), (change,)))
    assert friction_drives(fit.state, BODY) is pushes


@pytest.mark.parametrize(("mass", "possible"), [(3.0, True), (6.1, False)])
def test_a_mode_is_lighter_than_its_body(mass: float, possible: bool) -> None:
    mode = Placed(FlexibleModeEffect(), BODY, (20.0, 0.02), (mass,))
    assert mode.effect.is_possible(fit_with().state.prediction, mode) is possible


@pytest.mark.parametrize(("mass", "impossible"), [(5.0, False), (2.5, True)])
def test_an_effect_may_not_leave_less_mass_than_a_mode_has(mass: float, impossible: bool) -> None:
    mode = Placed(FlexibleModeEffect(), BODY, (20.0, 0.02), (3.0,))
    assert _makes_impossible(fit_with(mode), fit_with(mode, mass=mass)) is impossible


@pytest.mark.parametrize(("ripple", "possible"), [(0.2, True), (0.55, False)])
def test_a_ripple_leaves_most_of_the_constant(ripple: float, possible: bool) -> None:
    prediction = fit_with().state.prediction
    placed = Placed(RIPPLE, "actuator", (prediction.joints[BODY].stroke / 5,), (ripple, 0.0))
    assert placed.effect.is_possible(prediction, placed) is possible
