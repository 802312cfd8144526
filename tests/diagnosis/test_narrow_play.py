"""Play that is narrow beside the deflection of its spring, beside another friction; the motor alone is measured."""

import pytest

from symid import Backlash, StribeckFriction, load_axis
from symid.data import Log
from symid.diagnosis import LIBRARY
from symid.diagnosis.effects import Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.gauss_newton import continued
from symid.diagnosis.fitting.hidden_starts import of_play
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.record import record_of
from symid.simulation import forward_dynamics, plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("ballscrew_2m1s").with_signal("qm", noise=6e-8).with_signal("Fm", noise=0.8)
VALUES = {"Mm": 92.0, "Fvm": 187.0, "Fsm": 43.5, "Kt": 3.37e6, "Ft": 480.0, "Ml": 218.0, "Fvl": 114.0}
GAP, LEVEL, VELOCITY = 5e-6, 100.0, 0.0257


def effect(name: str):
    return next(own for own in LIBRARY if own.name == name)


def test_a_narrow_play_is_fitted_beside_the_friction_found_before() -> None:
    motor, spring = AXIS.bodies[0], next(e for e in AXIS.elements if getattr(e, "stiffness", "") == "Kt")
    machine = AXIS.with_effect(Backlash(spring.at, "Kb", gap=GAP))
    machine = machine.with_effect(StribeckFriction(motor, "dF", velocity=VELOCITY))
    path = trapezoids([0.1, 0.2], [0.3, 0.5], acceleration=6.0, jerk=300.0, dwell=0.05, sampling_period=1e-3)
    loop = tuned_cascade(plant_of(AXIS, VALUES), "qm")
    log = simulate(machine, VALUES | {"Kb": VALUES["Kt"], "dF": LEVEL}, path, loop, seed=1).log
    alone = Log.from_arrays({"qm": log["qm"], "Fm": log["Fm"]}, sampling_period=log.sampling_period)
    record = record_of(forward_dynamics(AXIS), alone, holds={"Fm": log.sampling_period})
    state, weighting = first_state(record, VALUES)
    friction = Placed(effect("stribeck_friction"), "motor", (VELOCITY,), (LEVEL,))
    before = Fit(with_effects(state, weighting, (friction,)), weighting)
    narrow = next(
        own for own in of_play(before, before, [effect("backlash")]) if not own.state.prediction.follows
    )
    begun = narrow.best_state()
    assert begun is not None
    found = continued(Fit(begun, narrow.weighting), 12)
    assert found.mean_square < 0.1 * before.mean_square
    # Of a play that is passed within few samples the log determines the force that it takes away.
    play = found.state.placed[-1]
    assert play.amplitudes[0] * play.shape[0] == pytest.approx(VALUES["Kt"] * GAP, rel=0.3)
