"""The moment at which a payload changes, in the log and in another one."""

import numpy as np
import pytest

from symid import Axis, Body, CoulombFriction, Drive, Log, PayloadChange, Position, ViscousFriction, load_axis
from symid.axis import LoadDependentFriction, Weight
from symid.diagnosis import LIBRARY, Diagnosis, diagnose
from symid.diagnosis.effects import Placed
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("rigid_1m").with_signal("q", noise=1e-7).with_signal("F", noise=0.5)
VALUES = {"M": 50.0, "Fv": 120.0, "Fs": 70.0}
MOVES = trapezoids([0.1], [0.2, 0.3], acceleration=6.0, jerk=200.0, dwell=0.1, sampling_period=1e-3)


def log_with_change(time: float, seed: int, *further: LoadDependentFriction) -> Log:
    loaded = AXIS.with_effect(PayloadChange(AXIS.bodies[0], 30.0, time=time), *further)
    return simulate(loaded, VALUES, MOVES, tuned_cascade(plant_of(AXIS, VALUES), "q"), seed=seed).log


PATH = MOVES.position
SPEED = np.gradient(PATH, 1e-3)
LATE = np.arange(PATH.size) > PATH.size // 2
CRUISES = 1e-3 * np.flatnonzero(LATE & (np.abs(SPEED) > 0.29))
BRAKES = 1e-3 * np.flatnonzero(LATE & (np.gradient(np.abs(SPEED), 1e-3) < -5.9))


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    logs = log_with_change(CRUISES[len(CRUISES) // 4], 1), log_with_change(BRAKES[0] + 0.01, 2)
    return diagnose(AXIS, logs[0], validation=logs[1], nominal=VALUES)


def test_a_change_at_constant_speed_may_have_been_anywhere_in_it(found: Diagnosis) -> None:
    (effect,) = found.effects
    assert effect.effect == "payload_change"
    assert effect.parameters["dm"].value == pytest.approx(30.0, rel=0.005)
    time = effect.parameters["t0"]
    assert abs(time.value - CRUISES[len(CRUISES) // 4]) < 3 * time.std


def test_a_change_in_motion_is_timed_in_the_validation_log(found: Diagnosis) -> None:
    # Its moment there is another one; an error of 1 ms would leave some ten times the noise.
    assert found.gap.explained.rms < 1.8 * found.gap.noise_floor.rms


def test_a_payload_loads_the_bearings_too() -> None:
    # A friction of 0.25 of the drive force multiplies the force of the added mass by 1 / (1 - 0.25) as well.
    time, body = float(CRUISES[0]), AXIS.bodies[0]
    log = log_with_change(time, 1, LoadDependentFriction(body, 0.25))
    data = data_of(AXIS, (joined([log]), None), Recording({}, True))
    state, weighting = first_state(data.record, VALUES)
    effects = {effect.name: effect for effect in LIBRARY}
    friction = Placed(effects["load_dependent_friction"], body.name, (), (0.25,))
    payload = Placed(effects["payload_change"], body.name, (30.0, time), (1.0,))
    for _ in range(3):  # each time the friction approaches the balance further
        state = with_effects(state, weighting, (friction, payload))
    assert Fit(state, weighting).mean_square < 4.0  # 1700 with the friction of the axis without payload


def test_a_payload_of_a_vertical_axis_has_a_weight() -> None:
    table = Body("table", mass="M")
    laws = Weight(table), CoulombFriction(table, "Fs"), ViscousFriction(table, "Fv")
    lift = Axis("lift", (table, *laws), Drive("F", table), (Position("q", table),))
    lift = lift.with_signal("q", noise=1e-7).with_signal("F", noise=0.5)
    brakes = float(BRAKES[0])

    def gripped(time: float, seed: int) -> Log:
        loaded = lift.with_effect(PayloadChange(table, 8.0, time=time))
        return simulate(loaded, VALUES, MOVES, tuned_cascade(plant_of(lift, VALUES), "q"), seed=seed).log

    # In the validation log at rest, where the axis then sinks.
    still = np.flatnonzero(~LATE & (SPEED == 0.0) & (np.arange(PATH.size) > PATH.size // 4))[20]
    found = diagnose(lift, gripped(brakes, 1), validation=gripped(1e-3 * still, 2), nominal=VALUES)
    (effect,) = found.effects
    assert (effect.effect, effect.at) == ("payload_change", "table")
    assert effect.parameters["dm"].value == pytest.approx(8.0, rel=0.01)
    assert effect.parameters["t0"].value == pytest.approx(brakes, abs=0.005)
    assert found.gap.explained.rms < 2.0 * found.gap.noise_floor.rms
