"""Short and slow logs: some tens of independent rows tell a law that machines have, and no more than that."""

import numpy as np
import pytest

from benchmarks.diagnosis.other_cases import drawn
from benchmarks.diagnosis.other_machines import Loop, Recorder, run
from symid import Axis, Body, CoulombFriction, Drive, Log, Position, Unbalance, ViscousFriction
from symid.diagnosis import Diagnosis, diagnose
from symid.diagnosis.selection.priors import least_gain

VALUES = {"J": 0.02, "Fv": 0.08, "Fs": 0.15, "Gs": 0.4, "Gc": 0.05}
BODY = Body("lever", inertia="J")
COMPLETE = Axis(
    "servo",
    (BODY, ViscousFriction(BODY, "Fv"), CoulombFriction(BODY, "Fs"), Unbalance(BODY, "Gs", "Gc")),
    Drive("F", BODY),
    (Position("q", BODY),),
)


def found_in_6_s(axis: Axis, seed: int) -> Diagnosis:
    """At 50 Hz, of a servo that swings a weight, by an encoder of 12 bits."""
    rng, rate = np.random.default_rng(seed), 1000.0
    t = np.arange(6000) / rate
    waves = [np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) / f for f in rng.uniform(0.15, 1.2, 4)]
    path = np.sum(waves, axis=0)
    loop = Loop(rate, 12.5, 0.8, 2 * np.pi / 4096, force_step=0.005, noise=0.01, wander=0.01)
    course = 1.2 * path / np.abs(path).max() * np.minimum(t, 1.0)
    signals = run(VALUES, loop, course, Recorder(every=20), seed).signals
    log = Log.from_arrays({name: signals[name] for name in ("q", "F")}, sampling_period=0.02)
    return diagnose(axis, log, nominal={name: 1.05 * VALUES[name] for name in axis.physical_parameters})


def test_coulomb_friction_is_found_in_6_s_at_50_hz() -> None:
    lacking = COMPLETE.without(*(law for law in COMPLETE.laws if isinstance(law, CoulombFriction)))
    found = found_in_6_s(lacking, 2)
    assert found.search[0].before.n_rows < 80
    assert found.verdict in ("effect", "partly")
    assert found.effects[0].effect == "coulomb_friction"
    assert found.effects[0].parameters["Fs"].value == pytest.approx(VALUES["Fs"], rel=0.1)


@pytest.mark.parametrize("seed", [1, 2])
def test_nothing_is_found_where_nothing_lacks(seed: int) -> None:
    assert not found_in_6_s(COMPLETE, seed).effects


def test_laws_that_imitate_viscous_friction_are_ties_in_a_short_log() -> None:
    """Its projected gain is the fourth, and was not fitted; drag and a stiffness explain as much."""
    case = drawn(603, short=True)
    assert case.effect == "viscous_friction"
    nominal = {name: case.nominal[name] for name in case.model.physical_parameters}
    found = diagnose(case.model, case.logs[0], nominal=nominal)
    assert found.effects[0].effect == "viscous_friction"
    assert found.effects[0].probability < 0.5
    assert ("quadratic_drag", "driven") in found.effects[0].indistinguishable_from


def test_the_least_gain_grows_with_the_rows_of_usual_laws_only() -> None:
    gains = [least_gain("weight", n) for n in (36, 300, 1000, 1e5)]
    assert gains == sorted(gains)
    assert gains[0] < 13
    assert gains[-2:] == [30, 30]
    assert {least_gain("flexible_mode", n) for n in (36, 300, 1000, 1e5)} == {30}


def test_a_move_in_one_direction_shows_no_friction_by_direction() -> None:
    period, rng = 1e-3, np.random.default_rng(2)
    time = period * np.arange(540)
    phase = np.clip((time - 0.04) / 0.46, 0.0, 1.0)
    inside = (phase > 0.0) & (phase < 1.0)
    q = 0.3 * (phase - np.sin(2 * np.pi * phase) / (2 * np.pi))
    v = np.where(inside, 0.3 / 0.46 * (1 - np.cos(2 * np.pi * phase)), 0.0)
    a = np.where(inside, 0.3 / 0.46**2 * 2 * np.pi * np.sin(2 * np.pi * phase), 0.0)
    force = 43.0 * a + 90.0 * v + 35.0 * np.sign(v)
    signals = {"q": q + 1e-6 * rng.standard_normal(540), "F": force + rng.standard_normal(540)}
    table = Body("table", mass="M")
    rack = Axis("rack", (table, ViscousFriction(table, "Fv")), Drive("F", table), (Position("q", table),))
    found = diagnose(rack, Log.from_arrays(signals, sampling_period=period), nominal={"M": 48.0, "Fv": 80.0})
    first = found.effects[0]
    assert first.effect == "coulomb_friction"  # a constant force is the same here
    assert {effect for effect, _ in first.indistinguishable_from} <= {"offset_force"}
    assert first.parameters["Fs"].value == pytest.approx(35.0, rel=0.1)
