"""Hidden motion beside errors of readings, against simulated machines."""

import numpy as np
import pytest

from symid import Axis, CoulombFriction, EncoderRipple, Log, load_axis
from symid.diagnosis import LIBRARY
from symid.diagnosis.effects import Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.sensitivity import prediction_jacobian
from symid.diagnosis.fitting.state import State, evaluated, first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.prediction.weighting import Weighting
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

SCREW = load_axis("ballscrew_2m1s")
VALUES = {"Mm": 60.0, "Ml": 180.0, "Kt": 6.3e6, "Ft": 1250.0, "Fvm": 154.0, "Fvl": 63.0, "Fsm": 81.0}
EFFECTS = {effect.name: effect for effect in LIBRARY}
FRICTION, PITCH, RIPPLE = 147.0, 0.0141, 3e-5


def run(axis: Axis, values: dict[str, float], *signals: str) -> Log:
    """Signals of a simulated log of some moves."""
    reference = trapezoids(0.1, [0.15, 0.3], acceleration=4.0, jerk=120.0, dwell=0.1, sampling_period=5e-4)
    log = simulate(axis, values, reference, tuned_cascade(plant_of(SCREW, VALUES), "qm"), seed=1).log
    return Log.from_arrays({name: log[name] for name in signals}, sampling_period=log.sampling_period)


def begun(log: Log) -> tuple[State, Weighting]:
    """The declared screw at its true values."""
    return first_state(data_of(SCREW, (joined([log]), None), Recording({}, True)).record, VALUES)


def screw(*effects: EncoderRipple | CoulombFriction) -> Axis:
    """The screw with more effects, and readings with noise."""
    return SCREW.with_effect(*effects).with_signal("qm", noise=1e-7).with_signal("Fm", noise=1.9)


def with_ripple(ripple: float) -> tuple[State, Weighting]:
    """The screw with friction at its load, at its true values under a log whose encoder has a ripple."""
    machine = screw(CoulombFriction(SCREW.bodies[1], "Fsl"), EncoderRipple("qm", ripple, 0.0, pitch=PITCH))
    state, weighting = begun(run(machine, VALUES | {"Fsl": FRICTION}, "qm", "Fm"))
    friction = Placed(EFFECTS["coulomb_friction"], "load", (), (FRICTION,), integrated=True)
    return with_effects(state, weighting, (friction,)), weighting


def misread(state: State, weighting: Weighting) -> State:
    """The state with the ripple of the encoder."""
    ripple = Placed(EFFECTS["encoder_ripple"], "qm", (PITCH,), (RIPPLE, 0.0))
    return with_effects(state, weighting, (*state.placed, ripple))


def test_a_hidden_load_follows_the_motor_and_not_the_ripple_of_its_encoder() -> None:
    exact = Fit(*with_ripple(0.0)).mean_square
    state, weighting = with_ripple(RIPPLE)
    assert Fit(state, weighting).mean_square > 20 * exact
    assert Fit(misread(state, weighting), weighting).mean_square == pytest.approx(exact, rel=0.1)


@pytest.mark.parametrize(("name", "share"), [("Mm", 1e-3), ("Fvm", 1e-2), ("Ml", 1e-3)])
def test_derivatives_of_hidden_motion_beside_a_ripple_are_differences(name: str, share: float) -> None:
    state, weighting = with_ripple(RIPPLE)
    state = misread(state, weighting)
    parameters = state.prediction.parameters
    step = share * parameters[name]
    moved = evaluated(state, weighting, {**parameters, name: parameters[name] + step}, state.placed)
    difference = (state.errors - moved.errors) / step
    column = prediction_jacobian(state)[state.prediction.record.dynamics.parameters.index(name)]
    assert np.linalg.norm(column - difference) < 0.05 * np.linalg.norm(difference)


def test_forces_beside_an_integrated_one_are_those_at_the_motion_that_is_read() -> None:
    load = SCREW.bodies[1]
    machine = screw(CoulombFriction(load, "Fsl")).with_signal("ql", noise=1e-7)
    log = run(machine, VALUES | {"Fsl": FRICTION}, "qm", "ql", "Fm")
    state, weighting = begun(log)
    # Friction of half its level: the load that is integrated slides further than the one that is read.
    friction = Placed(EFFECTS["coulomb_friction"], "load", (), (FRICTION / 2,), integrated=True)
    play = Placed(EFFECTS["backlash"], "transmission", (2e-6,), (VALUES["Kt"],))
    both = with_effects(state, weighting, (friction, play))
    joint = both.prediction.joints["load"]
    record = both.prediction.record
    read = record.fine(record.measured[record.signals.index("ql")])
    np.testing.assert_allclose(joint.q, read, atol=1e-6)
    again = with_effects(both, weighting, both.placed)
    assert Fit(again, weighting).cost == pytest.approx(Fit(both, weighting).cost, rel=1e-2)
