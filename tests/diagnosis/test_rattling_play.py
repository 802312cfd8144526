"""A structure that rattles in the play of its spring: its motion is observed as that under dry friction is."""

import pytest

from symid import Backlash, load_axis
from symid.data import Log
from symid.diagnosis import LIBRARY, diagnose
from symid.diagnosis.effects import Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.record import record_of
from symid.simulation import forward_dynamics, plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("direct_2m1s").with_signal("q2", noise=1e-7).with_signal("Fm", noise=0.7)
VALUES = {"Ms": 3660.0, "Fvs": 34600.0, "Ks": 2.23e8, "Mm": 246.0, "Fvm": 377.0, "Fsm": 84.0}
GAP = 1e-6


@pytest.fixture(scope="module")
def log() -> Log:
    (body,) = (body for body in AXIS.bodies if body.name == "structure")
    machine = AXIS.with_effect(Backlash(body, "Kb", gap=GAP))
    path = trapezoids([0.1, 0.2], [0.3, 0.5], acceleration=4.0, jerk=300.0, dwell=0.05, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(AXIS, VALUES), "q2")
    return simulate(machine, VALUES | {"Kb": VALUES["Ks"]}, path, loop, seed=1).log


def test_at_the_true_values_motion_that_follows_the_force_leaves_a_fraction(log: Log) -> None:
    play = next(effect for effect in LIBRARY if effect.name == "backlash")
    placed = Placed(play, "structure", (GAP,), (VALUES["Ks"],), integrated=True)
    record = record_of(forward_dynamics(AXIS), log, holds={"Fm": log.sampling_period})
    left = []
    for follows in (False, True):
        state, weighting = first_state(record, VALUES, follows=follows)
        left.append(Fit(with_effects(state, weighting, (placed,)), weighting).mean_square)
    predicted, observed = left
    assert observed < 0.3 * predicted


def test_play_of_a_structure_is_found_by_its_motor_alone(log: Log) -> None:
    names = ("backlash", "coulomb_friction", "stiffness_nonlinearity", "periodic_disturbance")
    nominal = {name: 1.04 * value for name, value in VALUES.items()}
    found = diagnose(AXIS, log, nominal=nominal, library=[own for own in LIBRARY if own.name in names])
    assert [(own.effect, own.at) for own in found.effects] == [("backlash", "structure")]
    assert found.effects[0].parameters["b"].value == pytest.approx(GAP, rel=0.3)
