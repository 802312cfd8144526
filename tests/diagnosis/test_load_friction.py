"""Friction by load takes the force that acts, without the noise of the position in the modelled one."""

from dataclasses import replace

import numpy as np
import pytest

from symid import ForceConstantRipple, LoadDependentFriction, load_axis
from symid.data import Log
from symid.diagnosis import diagnose
from symid.diagnosis.effects import LIBRARY, Placed
from symid.diagnosis.fitting.gauss_newton import converged
from symid.diagnosis.fitting.sensitivity import prediction_jacobian
from symid.diagnosis.fitting.state import State, evaluated, first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.prediction.weighting import Weighting
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

AXIS = load_axis("rigid_1m")
EFFECTS = {effect.name: effect for effect in reversed(LIBRARY)}
VALUES = {"M": 100.0, "Fv": 20.0, "Fs": 10.0}


CONSTANT = 20.0
DRIVEN = replace(AXIS, drive=replace(AXIS.only_drive, gain="Kf", unit="A")).with_known({"Kf": CONSTANT})
"""The slide whose log holds the current: mu is that of the force."""


def slide(seed: int) -> Log:
    """A slide that cruises for most of the time, with hardly any force, read by a noisy encoder."""
    axis = DRIVEN.with_signal("q", noise=1e-6).with_signal("F", noise=0.3 / CONSTANT)
    axis = axis.with_effect(LoadDependentFriction(AXIS.bodies[0], 0.25))
    reference = trapezoids(0.4, [0.2, 0.4], acceleration=2.0, jerk=60.0, dwell=0.1, sampling_period=5e-4)
    loop = tuned_cascade(plant_of(AXIS, VALUES), "q")
    loop = replace(loop, velocity_gain=loop.velocity_gain / CONSTANT)
    return simulate(axis, VALUES, reference, loop, seed=seed).log


def test_noise_of_the_position_is_no_load() -> None:
    library = [effect for effect in LIBRARY if effect.name in ("load_dependent_friction", "cogging")]
    found = diagnose(DRIVEN, slide(1), validation=slide(2), nominal=VALUES, library=library)
    (friction,) = found.effects
    assert friction.effect == "load_dependent_friction"
    assert friction.parameters["mu"].value == pytest.approx(0.25, rel=0.01)  # 6 % less with the noise
    assert found.gap.explained.rms < 4.5 * found.gap.noise_floor.rms  # 8 with the noise


def test_friction_by_load_of_a_read_load_holds_on_another_log() -> None:
    """Iterated over a log instead of step by step, it ended in another motion near the resonance of the load."""
    screw = load_axis("ballscrew_2m1s").with_signal("qm", noise=5e-8).with_signal("ql", noise=5e-8)
    values = {"Mm": 81.0, "Fvm": 190.0, "Fsm": 88.0, "Kt": 7.65e6, "Ft": 600.0, "Ml": 246.0, "Fvl": 72.0}
    machine = screw.with_signal("Fm", noise=1.3).with_effect(LoadDependentFriction(screw.bodies[1], 0.2))
    loop = tuned_cascade(plant_of(screw, values), "qm")

    def moved(speeds: list[float], seed: int) -> Log:
        reference = trapezoids(0.15, speeds, acceleration=6.0, jerk=400.0, dwell=0.05, sampling_period=5e-4)
        return simulate(machine, values, reference, loop, seed=seed).log

    library = [effect for effect in LIBRARY if effect.name in ("load_dependent_friction", "cogging")]
    logs = {"log": moved([0.2, 0.4], 1), "validation": moved([0.3], 2)}
    found = diagnose(screw, **logs, nominal=values, library=library, held=True)
    (friction,) = found.effects
    assert (friction.effect, friction.at) == ("load_dependent_friction", "load")
    assert friction.parameters["mu"].value == pytest.approx(0.2, rel=0.01)
    assert found.gap.explained.rms < 8.0 * found.gap.noise_floor.rms  # 24 when iterated


SCREW = load_axis("ballscrew_2m1s").with_signal("qm", noise=5e-8).with_signal("ql", noise=5e-8)
SCREW_VALUES = {"Mm": 139.0, "Fvm": 130.0, "Fsm": 73.0, "Kt": 1.17e7, "Ft": 1150.0, "Ml": 241.0, "Fvl": 103.0}
FRICTION = Placed(EFFECTS["load_dependent_friction"], "load", (), (0.2,), integrated=True)


@pytest.fixture(scope="module")
def loaded_screw() -> tuple[State, Weighting]:
    """The state of a screw whose force constant varies, with friction by load at its load, without the former."""
    machine = SCREW.with_signal("Fm", noise=1.3).with_effect(LoadDependentFriction(SCREW.bodies[1], 0.2))
    machine = machine.with_effect(ForceConstantRipple(0.1, 0.0, 0.032))
    loop = tuned_cascade(plant_of(SCREW, SCREW_VALUES), "qm")
    reference = trapezoids(0.15, [0.2, 0.4], acceleration=6.0, jerk=400.0, dwell=0.05, sampling_period=5e-4)
    log = simulate(machine, SCREW_VALUES, reference, loop, seed=1).log
    record = data_of(SCREW, (joined([log]), None), Recording({}, True)).record
    state, weighting = first_state(record, SCREW_VALUES)
    return with_effects(state, weighting, (FRICTION,)), weighting


def test_load_follows_the_force_constant(loaded_screw: tuple[State, Weighting]) -> None:
    """Integrated with the motion, friction felt the force without the ripple, which then came out 16 % too large."""
    state, weighting = loaded_screw
    ripple = Placed(EFFECTS["force_constant_ripple"], "actuator", (0.032,), (0.01, 0.0))
    fit = converged(with_effects(state, weighting, (FRICTION, ripple)), weighting)
    assert fit.state.placed[0].amplitudes == pytest.approx((0.2,), rel=0.01)
    assert fit.state.placed[1].amplitudes == pytest.approx((0.1, 0.0), abs=0.003)


@pytest.mark.parametrize("name", ["Mm", "Fvm", "Fvl"])
def test_derivatives_follow_the_load(loaded_screw: tuple[State, Weighting], name: str) -> None:
    """Mass and friction of the motor change the drive force, and so the friction of the load: 20 % were missing."""
    state, weighting = loaded_screw

    def outputs(share: float) -> np.ndarray:
        moved = dict(SCREW_VALUES) | {name: SCREW_VALUES[name] * (1 + share)}
        return weighting.rows(evaluated(state, weighting, moved, state.placed).errors)

    column = weighting.rows(prediction_jacobian(state)[list(SCREW_VALUES).index(name)])
    expected = (outputs(-0.01) - outputs(0.01)) / (0.02 * SCREW_VALUES[name])
    assert np.linalg.norm(column - expected) < 0.03 * np.linalg.norm(expected)
