"""Servos and small motors: coarse readings, turns in one direction, parameters that take over a law."""

import numpy as np
import pytest

from benchmarks.diagnosis.real import recordings
from benchmarks.diagnosis.real.case import log_of
from symid import (
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Log,
    PendulumWeight,
    Position,
    QuadraticDrag,
    Velocity,
    ViscousFriction,
    diagnose,
)

TIME = np.arange(0, 12, 0.01)
BODY = Body("body", inertia="J")
FRICTION = ViscousFriction(BODY, "Fv"), CoulombFriction(BODY, "Fc")


def sines(amplitudes, hertz, derivative=0):
    """Sum of sines, or a derivative of it."""
    rates = 2 * np.pi * np.array(hertz)
    angles = np.outer(rates, TIME) + np.arange(rates.size)[:, None] + derivative * np.pi / 2
    return (np.array(amplitudes) * rates**derivative) @ np.sin(angles)


def propeller_log(seed: int) -> Log:
    """A motor with a propeller that turns one way, by its equation of motion; speed in steps of 1.5 rad/s."""
    rng = np.random.default_rng(seed)
    waves = (60.0, 50.0, 30.0), (0.23 + 0.01 * seed, 0.61, 1.3)
    w, turned = 300.0 + sines(*waves), sines(*waves, derivative=1)
    force = 3e-3 * turned + 0.016 * w + 1.8e-5 * w**2 + 0.4 + 0.01 * rng.standard_normal(TIME.size)
    return Log.from_arrays({"w": 1.5 * np.round(w / 1.5), "u": force}, sampling_period=0.01)


@pytest.mark.parametrize(("laws", "lacks"), [((QuadraticDrag(BODY, "c"),), []), ((), ["quadratic_drag"])])
def test_a_motor_that_turns_thousands_of_radians_one_way_is_diagnosed(laws, lacks):
    axis = Axis("propeller", (BODY, *FRICTION, *laws), Drive("u", BODY, unit="V"), (Velocity("w", BODY),))
    found = diagnose(axis, propeller_log(1), validation=propeller_log(2))
    assert [effect.effect for effect in found.effects] == lacks
    assert found.gap.explained.relative < 0.01
    assert found.parameters[0].explained == pytest.approx(3e-3, rel=0.02)


def lever_log(seed: int) -> Log:
    """A servo that swings a weight slowly on a lever: 4096 counts a turn, 100 Hz."""
    waves = (0.3, 0.3, 0.2), tuple((1 + 0.05 * seed) * f for f in (0.4, 0.75, 1.1))
    q, v, a = (sines(*waves, derivative=order) for order in range(3))
    force = 0.02 * a + 0.4 * v + 0.3 * np.sign(v) + 0.08 * 9.80665 * np.sin(q)
    step = 2 * np.pi / 4096
    noise = 0.03 * np.random.default_rng(seed).standard_normal(TIME.size)
    return Log.from_arrays({"q": step * np.round(q / step), "u": force + noise}, sampling_period=0.01)


def test_a_weight_that_had_taken_most_of_the_inertia_is_found():
    axis = Axis("lever", (BODY, *FRICTION), Drive("u", BODY, unit="V"), (Position("q", BODY),))
    found = diagnose(axis, lever_log(1), validation=lever_log(2))
    assert found.parameters[0].reidentified < 0.01  # less than half of it
    assert (found.verdict, found.effects[0].effect) == ("effect", "weight")
    assert found.effects[0].parameters["Gs"].value == pytest.approx(0.785, rel=0.03)
    assert found.parameters[0].explained == pytest.approx(0.02, rel=0.1)
    whole = Axis("lever", (*axis.elements, PendulumWeight(BODY, "ml")), axis.drive, axis.sensors)
    assert diagnose(whole, lever_log(1), validation=lever_log(2)).verdict == "no_gap"


def test_cogging_is_found_though_other_values_make_less_of_the_noise():
    axis = Axis("motor", (BODY, *FRICTION), Drive("i", BODY, unit="A"), (Position("q", BODY),))
    first, second = recordings.motor("comp_0"), recordings.motor("comp_1").between(0.5, 10.0)
    found = diagnose(axis, log_of(axis, first), validation=log_of(axis, second))
    assert found.effects[0].effect == "cogging"
    assert found.effects[0].parameters["pitch"].value == pytest.approx(2 * np.pi / 7, rel=0.01)
    assert found.gap.explained.relative < 0.4 * found.gap.reidentified.relative
    (twice,) = (own for own in found.effects if own.effect == "position_dependent_friction")
    assert twice.parameters["pitch"].value == pytest.approx(2 * np.pi / 14, rel=0.02)
    assert twice.probability < 0.5  # turned one way, it is cogging of order 14
