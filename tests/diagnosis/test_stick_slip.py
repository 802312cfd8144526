"""A hidden load that sticks and slips: its motion depends on its beginning for ever, and is observed, not predicted."""

import pytest

from symid import StribeckFriction, load_axis
from symid.data import Log
from symid.diagnosis.effects import LIBRARY, Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import fitted
from symid.diagnosis.fitting.start import fitted_axis
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.record import record_of
from symid.simulation import forward_dynamics, plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("ballscrew_2m1s")
VALUES = {"Mm": 67.0, "Fvm": 70.0, "Fsm": 35.0, "Kt": 6.6e6, "Ft": 950.0, "Ml": 131.0, "Fvl": 57.0}
STRIBECK = next(effect for effect in LIBRARY if effect.name == "stribeck_friction")


@pytest.fixture(scope="module")
def log() -> Log:
    """A load whose friction falls with the speed, 100 N from rest to 11 mm/s: it oscillates on its spring."""
    _, load = AXIS.bodies
    machine = AXIS.with_effect(StribeckFriction(load, "dF", velocity=0.0113))
    machine = machine.with_signal("qm", noise=1e-7).with_signal("Fm", noise=0.4)
    reference = trapezoids(0.02, [0.01, 0.02], acceleration=1.0, jerk=50.0, dwell=0.1, sampling_period=1e-3)
    cascade = tuned_cascade(plant_of(AXIS, VALUES), "qm")
    run = simulate(machine, VALUES | {"dF": 100.0}, reference, cascade, seed=1).log
    return Log.from_arrays({"qm": run["qm"], "Fm": run["Fm"]}, sampling_period=run.sampling_period)


def left(log: Log, level: float, velocity: float, *, follows: bool) -> Fit:
    """The true axis with Stribeck friction of the load."""
    record = record_of(forward_dynamics(AXIS), log, holds={"Fm": log.sampling_period})
    state, weighting = first_state(record, VALUES, follows=follows)
    placed = Placed(STRIBECK, "load", (velocity,), (level,), integrated=True)
    return Fit(with_effects(state, weighting, (placed,)), weighting)


def test_at_the_true_values_motion_that_follows_the_force_leaves_a_fraction(log: Log) -> None:
    predicted, observed = (left(log, 100.0, 0.0113, follows=follows) for follows in (False, True))
    assert observed.mean_square < 0.05 * predicted.mean_square


def test_values_are_found_from_far_off(log: Log) -> None:
    begun = left(log, 30.0, 0.03, follows=True)
    found = fitted(begun.state, begun.weighting, 12)
    (friction,) = found.state.placed
    assert friction.amplitudes == pytest.approx([100.0], rel=0.05)
    assert friction.shape == pytest.approx([0.0113], rel=0.05)


def test_an_axis_that_declares_the_friction_has_no_gap(log: Log) -> None:
    """As a diagnosis writes it: the declared friction is observed like that of a candidate."""
    _, load = AXIS.bodies
    machine = AXIS.with_effect(StribeckFriction(load, "dF", velocity=0.0113))
    record = record_of(forward_dynamics(machine), log, holds={"Fm": log.sampling_period})
    fit = fitted_axis(*first_state(record, VALUES | {"dF": 100.0}))
    assert fit.mean_square < 1.5
    assert fit.parameters["dF"] == pytest.approx(100.0, rel=0.05)
