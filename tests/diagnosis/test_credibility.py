"""Values that no machine has, causes that a log cannot tell apart, and the lead over rivals."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
import scipy
from hand_made import rigid_log

from benchmarks.diagnosis import machines
from symid import (
    AsymmetricFriction,
    Axis,
    Body,
    CoulombFriction,
    Drive,
    Geared,
    Log,
    PendulumWeight,
    Position,
    Preparation,
    ViscousFriction,
    load_axis,
)
from symid.diagnosis import diagnose
from symid.diagnosis.effects import (
    LIBRARY,
    FlexibleModeEffect,
    GainAsymmetryEffect,
    PayloadChangeEffect,
    Placed,
    SaturationEffect,
)
from symid.diagnosis.effects.periodic_disturbance import PeriodicDisturbanceEffect, is_line_of_motion
from symid.diagnosis.fitting.cross_validation import Blocks
from symid.diagnosis.fitting.fit import Fit
from symid.diagnosis.fitting.state import first_state, with_effects
from symid.diagnosis.prediction.data import Recording, data_of
from symid.diagnosis.prediction.joined_logs import joined
from symid.diagnosis.prediction.scaled_sensors import with_quantities
from symid.diagnosis.selection.credibility import _is_a_gain, _is_ringing
from symid.diagnosis.selection.screening import screened
from symid.errors import SettingError
from symid.simulation import plant_of, simulate, trapezoids, tuned_cascade

SCREW = load_axis("ballscrew_2m1s")
VALUES = {"Mm": 80.0, "Fvm": 80.0, "Fsm": 40.0, "Kt": 8e6, "Ft": 900.0, "Ml": 160.0, "Fvl": 100.0}


def switched_log() -> Log:
    """A slide of 6 kg under a force that a relay switches: M q(2) + Fv q(1) = F, solved exactly."""
    t = np.arange(0.0, 8.0, 2e-3)
    force = 13.0 * np.sign(np.sin(2 * np.pi * (0.9 * t + 0.3 * np.sin(0.8 * t))))
    _, q, _ = scipy.signal.lsim(([1.0], [6.0, 8.0, 0.0]), force, t)
    return Log.from_arrays({"q": q, "F": force}, sampling_period=2e-3)


@pytest.mark.parametrize(("log", "is_gain"), [(switched_log(), True), (rigid_log(), False)])
def test_a_limit_of_a_switched_force_is_a_gain(log: Log, is_gain: bool) -> None:
    data = data_of(load_axis("rigid_1m"), (joined([log]), None), Recording({}, None))
    state, weighting = first_state(data.record, {"M": 6.0, "Fv": 8.0, "Fs": 0.1})
    limit = Placed(SaturationEffect(), "actuator", (0.5 * float(np.abs(log["F"]).max()),), (1.0,))
    assert _is_a_gain(Fit(with_effects(state, weighting, (limit,)), weighting)) is is_gain


@pytest.mark.parametrize("least", [0.0, 20.0])
def test_the_size_of_a_force_of_one_sign_explains_nothing(least: float) -> None:
    t = np.arange(0.0, 4.0, 2e-3)
    force = least + 13.0 * np.sin(2 * np.pi * (0.9 * t + 0.3 * np.sin(0.8 * t)))
    _, q, _ = scipy.signal.lsim(([1.0], [6.0, 8.0, 0.0]), force, t)
    log = Log.from_arrays({"q": q, "F": force}, sampling_period=2e-3)
    data = data_of(load_axis("rigid_1m"), (joined([log]), None), Recording({}, None))
    fit = Fit(*first_state(data.record, {"M": 5.0, "Fv": 8.0, "Fs": 0.1}))
    assert bool(screened(fit, [GainAsymmetryEffect()])) is (least == 0.0)


@pytest.mark.parametrize(("hertz", "own"), [(0.8, True), (2.0, False)])
def test_the_frequency_at_which_an_axis_swings_is_no_disturbance(hertz: float, own: bool) -> None:
    """At the resonance of its pendulum, which needs hardly a torque; friction that lacks needs more."""
    body = Body("arm", inertia="J")
    axis = Axis("arm", (body, PendulumWeight(body, "ml")), Drive("T", body), (Position("q", body),))
    phase = 2 * np.pi * 0.8 * np.arange(0.0, 6.5, 2e-3)
    log = Log.from_arrays({"q": 0.2 * np.sin(phase), "T": 0.2 * np.sign(np.cos(phase))}, sampling_period=2e-3)
    data = data_of(axis, (joined([log]), None), Recording({}, None))
    state, _ = first_state(data.record, {"J": 0.1, "ml": 0.1 * (2 * np.pi * 0.8) ** 2 / 9.81})
    assert is_line_of_motion(state.prediction, hertz, 0.25) is own


@pytest.mark.parametrize(("change", "plausible"), [(4.0, True), (-2.0, True), (9.0, False), (-3.5, False)])
def test_a_mass_changes_by_less_than_a_factor_of_two(change: float, plausible: bool) -> None:
    data = data_of(load_axis("rigid_1m"), (joined([rigid_log()]), None), Recording({}, None))
    state, _ = first_state(data.record, {"M": 6.0, "Fv": 8.0, "Fs": 0.1})
    payload = Placed(PayloadChangeEffect(), "motor", (change, 2.0), (1.0,))
    assert payload.effect.is_plausible(state.prediction, payload) is plausible


@pytest.mark.parametrize(
    ("hertz", "least", "rings"), [(20.0, -1.0, True), (20.0, 0.8, False), (20.6, -1.0, False)]
)
def test_a_mode_that_rings_is_no_disturbance(hertz: float, least: float, rings: bool) -> None:
    """The error of one block falls by `least`, that of the others by 1 each."""
    data = data_of(load_axis("rigid_1m"), (joined([rigid_log()]), None), Recording({}, None))
    state, weighting = first_state(data.record, {"M": 6.0, "Fv": 8.0, "Fs": 0.1})
    mode = Placed(FlexibleModeEffect(), "motor", (20.0, 0.005), (2.0,))
    wave = Placed(PeriodicDisturbanceEffect(), "motor", (hertz,), (0.1, 0.0))
    found = Fit(with_effects(state, weighting, (mode, wave)), weighting)
    before, after = (
        cast(Blocks, SimpleNamespace(squares=np.array([[2.0, 2.0, 2.0 - fall, 2.0]])))
        for fall in (0.0, least)
    )
    after.squares[0, [0, 1, 3]] -= 1.0
    assert _is_ringing(cast(Fit, SimpleNamespace(blocks=before)), found, after) is rings


@pytest.mark.parametrize("name", ["cogging", "force_constant_ripple", "encoder_ripple"])
@pytest.mark.parametrize("share", [0.9, 1.1, 1.4])
def test_a_wave_has_a_whole_period_within_the_stroke(name: str, share: float) -> None:
    """Cogging, both bends of a period, if it explains all."""
    data = data_of(load_axis("rigid_1m"), (joined([rigid_log()]), None), Recording({}, None))
    state, _ = first_state(data.record, {"M": 6.0, "Fv": 8.0, "Fs": 0.1})
    pitch = share * float(np.ptp(rigid_log()["q"]))
    effect = next(effect for effect in LIBRARY if effect.name == name)
    place = next(iter(effect.places(state.prediction)))
    placed = Placed(effect, place, (pitch,), (0.01, 0.01))
    assert effect.is_possible(state.prediction, placed) is (share < (1.3 if name == "cogging" else 1.0))
    if name == "cogging":
        assert effect.is_plausible(state.prediction, placed) is (share < 1.0)


@pytest.mark.parametrize("hertz", [3.0, 5.3, 9.4, 12.5, 19.0])
@pytest.mark.parametrize("damping", [0.003, 0.02])
def test_the_mode_that_is_missing_is_among_those_that_are_tried(hertz: float, damping: float) -> None:
    data = data_of(load_axis("rigid_1m"), (joined([rigid_log()]), None), Recording({}, None))
    state, weighting = first_state(data.record, {"M": 6.0, "Fv": 8.0, "Fs": 0.1})
    effect = FlexibleModeEffect()
    (missing,) = effect.columns(state.prediction, "motor", (hertz, damping))
    wanted = weighting.adjoint(weighting.rows(missing))
    tried = effect.shapes(
        state.prediction, "motor", lambda r: data.record.fine(np.sum(r.conj() * wanted, axis=0))
    )
    narrow = np.array([f for f, d in tried if d < 0.02])
    assert np.abs(narrow / hertz - 1).min() < 0.01


def test_one_sided_friction_of_the_load_may_be_in_the_friction_of_the_motor() -> None:
    """The model has Coulomb friction at the motor alone, which moves with the load."""
    load = next(body for body in SCREW.bodies if body.name == "load")
    axis = SCREW.with_effect(AsymmetricFriction(load, viscous=("b1", "b2"), coulomb=("F1", "F2")))
    axis = axis.with_signal("qm", noise=1e-7).with_signal("Fm", noise=1.0)
    values = VALUES | {
        "F1": 60.0,
        "F2": 0.0,
        "b1": 0.0,
        "b2": 0.0,
    }  # 30 N in the mean, which the motor's take up
    reference = trapezoids(0.1, [0.1, 0.3], acceleration=3.0, jerk=60.0, dwell=0.1, sampling_period=1e-3)
    run = simulate(axis, values, reference, tuned_cascade(plant_of(SCREW, VALUES), "qm"), seed=1).log
    log = Log.from_arrays({"qm": run["qm"], "Fm": run["Fm"]}, sampling_period=run.sampling_period)
    names = ("asymmetric_friction", "coulomb_friction", "viscous_friction", "stribeck_friction")
    library = [effect for effect in LIBRARY if effect.name in names]
    first = diagnose(SCREW, log, nominal=VALUES, held=True, library=library).effects[0]
    assert ("asymmetric_friction", "load") in ((first.effect, first.at), *first.indistinguishable_from)
    assert first.effect == "asymmetric_friction"


def test_a_force_of_the_wrong_sign_is_reported_without_nominal_values() -> None:
    log = rigid_log()
    turned = Log.from_arrays({"q": log["q"], "F": -log["F"]}, sampling_period=log.sampling_period)
    found = diagnose(load_axis("rigid_1m"), turned)
    assert found.verdict == "recording"
    assert "opposite" in found.faults[0]


def test_the_constant_of_a_drive_is_taken_as_given_and_effects_are_in_its_force() -> None:
    """One log shows the ratio of mass and constant alone: free, both could grow with the effect."""
    slide = Body("slide", mass="M")
    laws = ViscousFriction(slide, "Fv"), CoulombFriction(slide, "Fs")
    axis = Axis("slide", (slide, *laws), Drive("iq", slide, gain="Kt", unit="A"), (Position("q", slide),))
    force = rigid_log()
    shifted = (force["F"] + 12.0) / 50.0
    log = Log.from_arrays({"q": force["q"], "iq": shifted}, sampling_period=force.sampling_period)
    values = {"M": 110.0, "Fv": 140.0, "Fs": 9.0, "Kt": 50.0}
    found = diagnose(
        axis,
        log,
        nominal=values,
        library=tuple(effect for effect in LIBRARY if effect.name == "offset_force"),
    )
    assert found.sentence.startswith("The model lacks offset force")
    assert found.effects[0].parameters["F0"].value == pytest.approx(12.0, rel=0.05)
    assert "Kt of iq is taken as 50 N/A." in found.assumptions
    assert all(np.isfinite(parameter.reidentified_std) for parameter in found.parameters)
    with pytest.raises(SettingError, match=r"does not determine Kt: give the known ones"):
        diagnose(axis, log)


def test_a_nominal_constant_of_a_drive_that_a_known_mass_contradicts_is_identified() -> None:
    slide = Body("slide", mass=100.0)
    laws = ViscousFriction(slide, "Fv"), CoulombFriction(slide, "Fs")
    axis = Axis("slide", (slide, *laws), Drive("iq", slide, gain="Kt", unit="A"), (Position("q", slide),))
    log = rigid_log()
    current = Log.from_arrays({"q": log["q"], "iq": log["F"] / 50.0}, sampling_period=log.sampling_period)
    library = tuple(effect for effect in LIBRARY if effect.name == "gain_nonlinearity")
    found = diagnose(axis, current, nominal={"Fv": 140.0, "Fs": 9.0, "Kt": 57.5}, library=library)
    assert not found.effects
    taken = next(statement for statement in found.assumptions if statement.startswith("Kt of iq"))
    assert taken.endswith("N/A, as the log shows; the nominal value is 57.5 N/A.")
    assert float(taken.split()[6]) == pytest.approx(50.0, rel=2e-3)


def test_a_constant_of_a_drive_is_identified_as_the_log_was_recorded() -> None:
    slide = Body("slide", mass=100.0)
    laws = ViscousFriction(slide, "Fv"), CoulombFriction(slide, "Fs")
    axis = Axis("slide", (slide, *laws), Drive("iq", slide, gain="Kt", unit="A"), (Position("q", slide),))
    log, late = rigid_log(), 4
    signals = {"q": log["q"][late:], "iq": log["F"][:-late] / 50.0}
    moved = Log.from_arrays(signals, sampling_period=log.sampling_period)
    nominal = {"Fv": 140.0, "Fs": 9.0, "Kt": 57.5}
    assert with_quantities(axis, [moved], nominal).declared.known["Kt"] == 57.5
    recorded = Preparation(late={"iq": late * log.sampling_period})
    taken = with_quantities(axis, [moved], nominal, recorded).declared.known["Kt"]
    assert taken == pytest.approx(50.0, rel=2e-3)


def test_a_gain_is_identified_beside_masses_that_no_log_separates() -> None:
    slide = Body("slide", mass="M")
    load = Body("load", mass="Ml", geared=Geared(to=slide, ratio=1.0))
    sensors = Position("q", slide), Position("wire", slide, gain="c", unit="V")
    laws = ViscousFriction(slide, "Fv"), CoulombFriction(slide, "Fs")
    axis = Axis("loaded", (slide, load, *laws), Drive("F", slide), sensors)
    log = rigid_log()
    noise = 1e-8 * np.random.default_rng(0).standard_normal(log["q"].size)
    signals = {"q": log["q"], "F": log["F"], "wire": log["q"] / 3.0 + noise}
    scaled = Log.from_arrays(signals, sampling_period=log.sampling_period)
    nominal = {"M": 70.0, "Ml": 25.0, "Fv": 140.0, "Fs": 9.0, "c": 3.45}
    known = with_quantities(axis, [scaled], nominal).declared.known
    assert known["c"] == pytest.approx(3.0, rel=1e-3)


def test_a_mode_that_only_passes_on_less_of_the_encoder_noise_is_not_found():
    case = machines.drawn(353747, worldly=True)
    log, other = case.logs
    library = tuple(effect for effect in LIBRARY if effect.name == "flexible_mode")
    found = diagnose(case.machine.axis, log, validation=other, nominal=case.nominal, library=library)
    assert found.alternatives[0].log_likelihood > 1000.0  # relative to the noise of the model without it
    assert (found.verdict, found.effects) == ("parameters", ())
