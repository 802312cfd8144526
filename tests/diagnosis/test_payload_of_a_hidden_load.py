"""A hidden load that becomes heavier resonates otherwise from then on, which its derivatives must say."""

import numpy as np
import pytest

from symid import CoulombFriction, PayloadChange, load_axis
from symid.diagnosis import LIBRARY, diagnose
from symid.diagnosis.effects import Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import converged
from symid.diagnosis.fitting.moments import timed
from symid.diagnosis.fitting.sensitivity import prediction_jacobian
from symid.diagnosis.fitting.state import State, evaluated, first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.prediction.weighting import Weighting
from symid.simulation import multisine, plant_of, simulate, trapezoids, tuned_cascade

SCREW = load_axis("ballscrew_2m1s").with_signal("qm", noise=3e-8).with_signal("Fm", noise=2.0)
VALUES = {"Mm": 124.0, "Fvm": 71.0, "Fsm": 36.0, "Kt": 6.9e6, "Ft": 620.0, "Ml": 135.0, "Fvl": 180.0}
CHANGE, MOMENT = 47.0, 2.0
EFFECTS = {effect.name: effect for effect in LIBRARY}


@pytest.fixture(scope="module")
def loaded() -> tuple[State, Weighting]:
    """The screw with the change, at values that are some percent off."""
    (body,) = (body for body in SCREW.bodies if body.name == "load")
    machine = SCREW.with_effect(PayloadChange(body, CHANGE, time=MOMENT))
    shaking = multisine(
        np.arange(2.0, 60.0), 2.0, sampling_period=5e-4, quantity="acceleration", seconds=4.0, fade=0.2
    )
    log = simulate(machine, VALUES, shaking, tuned_cascade(plant_of(SCREW, VALUES), "qm"), seed=1).log
    wrong = VALUES | {"Kt": 6.8e6, "Ml": 138.0, "Mm": 122.5}
    state, weighting = first_state(data_of(SCREW, (joined([log]), None), Recording({}, True)).record, wrong)
    payload = Placed(EFFECTS["payload_change"], "load", (42.0, MOMENT), (1.0,))
    return with_effects(state, weighting, (payload,)), weighting


def test_derivatives_by_stiffness_and_mass_hold_what_the_change_takes_back(
    loaded: tuple[State, Weighting],
) -> None:
    """They were those of a load that rings at its first resonance throughout the log, 100 times as large."""
    state, weighting = loaded
    columns = weighting.projected(weighting.rows(prediction_jacobian(state)), state.beginning)
    for k, (name, value) in enumerate(state.prediction.parameters.items()):
        step = 1e-5 * value
        here, there = (
            evaluated(state, weighting, dict(state.prediction.parameters) | {name: x}, state.placed).rows
            for x in (value, value + step)
        )
        difference = weighting.projected((here - there) / step, state.beginning)
        assert np.linalg.norm(columns[k] - difference) < 0.02 * np.linalg.norm(difference), name


def test_the_fit_converges_to_the_masses(loaded: tuple[State, Weighting]) -> None:
    state, weighting = loaded
    fit = converged(state, weighting)
    assert fit.parameters["Ml"] == pytest.approx(VALUES["Ml"], rel=1e-3)
    assert fit.state.placed[0].shape[0] == pytest.approx(CHANGE, rel=1e-3)


def moved(change: float, time: float, level: float = 0.0, damping: float = 620.0) -> tuple[State, Weighting]:
    """The screw in moves with a change, and with dry friction of its load, at its values without both."""
    (body,) = (body for body in SCREW.bodies if body.name == "load")
    friction = [CoulombFriction(body, "Fsl")] if level else []
    machine = SCREW.with_effect(*friction, PayloadChange(body, change, time=time))
    values = VALUES | {"Ft": damping}
    path = trapezoids([0.2, 0.1] * 3, 0.6, acceleration=8.0, jerk=400.0, dwell=0.1, sampling_period=1e-3)
    loop, own = tuned_cascade(plant_of(SCREW, values), "qm"), {"Fsl": level} if level else {}
    log = simulate(machine, values | own, path, loop, seed=1).log
    return first_state(data_of(SCREW, (joined([log]), None), Recording({}, True)).record, values)


def test_its_moment_is_found_to_the_millisecond_where_the_load_rings_from_it_on() -> None:
    """The error has a valley of some milliseconds there, between times that were tried 80 ms apart."""
    state, weighting = moved(CHANGE, 1.468, damping=150.0)
    payload = Placed(EFFECTS["payload_change"], "load", (CHANGE, 0.3), (1.0,))
    found = timed(with_effects(state, weighting, (payload,)), weighting)
    assert found.placed[0].shape[1] == pytest.approx(1.468, abs=2e-3)


def test_a_mass_that_changes_under_dry_friction_moves_as_simulated() -> None:
    """The friction acts on the motion after the change: on that of the lighter load it left 47 times as much."""

    def left(change: float) -> float:
        state, weighting = moved(change, 1.468, level=80.0)
        friction = Placed(EFFECTS["coulomb_friction"], "load", (), (80.0,), integrated=True)
        payload = Placed(EFFECTS["payload_change"], "load", (change, 1.468), (1.0,))
        for _ in range(3):
            state = with_effects(state, weighting, (friction, payload))
        return Fit(state, weighting).mean_square

    assert left(60.0) < 1.2 * left(1e-3)


def test_a_much_heavier_structure_is_found_where_most_of_the_log_follows_the_change() -> None:
    """Re-identified values hold after the change, from which no small change of the mass leads back."""
    axis = load_axis("direct_2m1s").with_signal("q2", noise=1e-7).with_signal("Fm", noise=3.0)
    values = {"Ms": 2600.0, "Fvs": 36000.0, "Ks": 2.8e8, "Mm": 362.0, "Fvm": 70.0, "Fsm": 170.0}
    (body,) = (body for body in axis.bodies if body.name == "structure")
    machine = axis.with_effect(PayloadChange(body, 0.7 * values["Ms"], time=1.0))
    steps = [0.2, 0.1, 0.15, 0.05, 0.3, 0.12] * 2
    path = trapezoids(steps, 0.8, acceleration=5.0, jerk=300.0, dwell=0.1, sampling_period=1e-3)
    log = simulate(machine, values, path, tuned_cascade(plant_of(axis, values), "q2"), seed=1).log
    nominal = {name: 1.07 * value for name, value in values.items()}
    names = ("payload_change", "force_constant_ripple", "cogging", "encoder_ripple", "periodic_disturbance")
    library = [effect for effect in LIBRARY if effect.name in names]
    found = diagnose(axis, log, nominal=nominal, held=True, library=library)
    (effect,) = found.effects
    assert (effect.effect, effect.at) == ("payload_change", "structure")
    assert effect.parameters["dm"].value == pytest.approx(0.7 * values["Ms"], rel=0.03)
